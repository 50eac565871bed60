/* Messages and the table of an application for the core Flight System. */
#ifndef ORBIDENT_APP_H
#define ORBIDENT_APP_H

#include "cfe.h"
#include "robot.h"

#define ORBIDENT_APP_PIPE_DEPTH 32
#define ORBIDENT_APP_PERF_ID 91

/* Of your mission: give those that its tables of message identifiers leave free. */
#ifndef ORBIDENT_APP_SAMPLE_MID
#define ORBIDENT_APP_SAMPLE_MID 0x08F0
#define ORBIDENT_APP_ESTIMATE_MID 0x08F1
#endif

#define ORBIDENT_APP_LIMITS_EID 1
#define ORBIDENT_APP_CHANGED_EID 2
#define ORBIDENT_APP_LOST_EID 3
#define ORBIDENT_APP_LENGTH_EID 4
#define ORBIDENT_APP_PIPE_EID 5

/* A sample that your estimators of rate and attitude have prepared: flight-computer.md says how. */
typedef struct {
  CFE_MSG_TelemetryHeader_t header;
  orbident_real t;
  orbident_real sample[ROBOT_MEASURED];
} ORBIDENT_APP_Sample_t;

typedef struct {
  CFE_MSG_TelemetryHeader_t header;
  orbident_real t;
  orbident_real beta[ROBOT_BETAS], deviations[ROBOT_BETAS];
  orbident_real statistic; /* of a change, over its threshold */
  int32 code;              /* of the step, see orbident/flight.h */
  uint32 counted, refused, changes;
} ORBIDENT_APP_Estimate_t;

/* What is possible for this robot: the filter itself believes all that is possible for any. */
typedef struct {
  orbident_real least[ROBOT_MEASURED], most[ROBOT_MEASURED];
} ORBIDENT_APP_Limits_t;

void ORBIDENT_APP_Main(void);

#endif
