/* The recursive filter as an application of the core Flight System: takes samples from the software bus,
 * and sends the estimate after each. Its memory is its own; a filter that is lost begins anew. */
#include "orbident_app.h"

#include <string.h>

typedef struct {
  CFE_SB_PipeId_t pipe;
  CFE_TBL_Handle_t table;
  bool begun;
  ORBIDENT_APP_Estimate_t out;
  orbident_real memory[ROBOT_MEMORY];
} ORBIDENT_APP_Data_t;

static ORBIDENT_APP_Data_t data;

static CFE_Status_t begin(void) {
  CFE_Status_t status = CFE_EVS_Register(NULL, 0, CFE_EVS_EventFilter_BINARY);
  if (status == CFE_SUCCESS)
    status = CFE_MSG_Init(CFE_MSG_PTR(data.out.header), CFE_SB_ValueToMsgId(ORBIDENT_APP_ESTIMATE_MID),
                          sizeof data.out);
  if (status == CFE_SUCCESS)
    status = CFE_SB_CreatePipe(&data.pipe, ORBIDENT_APP_PIPE_DEPTH, "ORBIDENT_PIPE");
  if (status == CFE_SUCCESS)
    status = CFE_SB_Subscribe(CFE_SB_ValueToMsgId(ORBIDENT_APP_SAMPLE_MID), data.pipe);
  if (status == CFE_SUCCESS)
    status = CFE_TBL_Register(&data.table, "Limits", sizeof(ORBIDENT_APP_Limits_t),
                              CFE_TBL_OPT_DEFAULT, NULL);
  if (status == CFE_SUCCESS)
    status = CFE_TBL_Load(data.table, CFE_TBL_SRC_FILE, "/cf/orbident_limits.tbl");
  return status;
}

/* Whether every number is possible for this robot; without a table everything is. A velocity may lack. */
static bool is_possible(const orbident_real* sample) {
  void* address = NULL;
  bool possible = true;
  if (CFE_TBL_GetAddress(&address, data.table) >= CFE_SUCCESS && address != NULL) {
    const ORBIDENT_APP_Limits_t* const limits = address;
    for (int i = 0; i < ROBOT_MEASURED; ++i)
      if (sample[i] < limits->least[i] || sample[i] > limits->most[i]) possible = false;
    CFE_TBL_ReleaseAddress(data.table);
  }
  return possible;
}

static int step(orbident_real t, const orbident_real* sample) {
  if (!data.begun) {
    const int code = orbident_init(&ROBOT, data.memory, ROBOT_MEMORY, sample, NULL);
    if (code != ORBIDENT_DONE) return code;
    data.begun = true;
  }
  return orbident_step(&ROBOT, data.memory, t, sample);
}

static void watch(orbident_real t) {
  orbident_detection detection = {0, 0};
  const int code = orbident_detect(&ROBOT, data.memory, &detection);
  data.out.statistic = detection.statistic;
  if (code != ORBIDENT_CHANGED) return;
  ++data.out.changes;
  CFE_EVS_SendEvent(ORBIDENT_APP_CHANGED_EID, CFE_EVS_EventType_CRITICAL,
                    "ORBIDENT: the robot changed at %.3f s", (double)detection.onset);
  orbident_open(&ROBOT, data.memory, t);
}

static void take(const ORBIDENT_APP_Sample_t* message) {
  const orbident_real t = message->t;
  data.out.t = t;
  if (!is_possible(message->sample)) {
    data.out.code = ORBIDENT_ABSURD;
    ++data.out.refused;
  } else {
    data.out.code = step(t, message->sample);
    if (data.out.code >= ORBIDENT_DONE) {
      ++data.out.counted;
      watch(t);
    } else {
      ++data.out.refused;
    }
  }
  if (data.out.code == ORBIDENT_DIVERGED) {
    data.begun = false;
    CFE_EVS_SendEvent(ORBIDENT_APP_LOST_EID, CFE_EVS_EventType_ERROR,
                      "ORBIDENT: the estimate is lost; it begins anew with the next sample");
  }
  if (data.begun) {
    orbident_get(&ROBOT, data.memory, ORBIDENT_BETA, data.out.beta, ROBOT_BETAS);
    orbident_get(&ROBOT, data.memory, ORBIDENT_DEVIATIONS, data.out.deviations, ROBOT_BETAS);
  }
  CFE_SB_TimeStampMsg(CFE_MSG_PTR(data.out.header));
  CFE_SB_TransmitMsg(CFE_MSG_PTR(data.out.header), true);
}

static void receive(const CFE_SB_Buffer_t* buffer) {
  CFE_MSG_Size_t size = 0;
  CFE_MSG_GetSize(&buffer->Msg, &size);
  if (size == sizeof(ORBIDENT_APP_Sample_t)) {
    take((const ORBIDENT_APP_Sample_t*)buffer);
  } else {
    CFE_EVS_SendEvent(ORBIDENT_APP_LENGTH_EID, CFE_EVS_EventType_ERROR,
                      "ORBIDENT: a sample of %lu bytes, expected %lu", (unsigned long)size,
                      (unsigned long)sizeof(ORBIDENT_APP_Sample_t));
  }
  CFE_TBL_Manage(data.table);
}

void ORBIDENT_APP_Main(void) {
  uint32 run = CFE_ES_RunStatus_APP_RUN;
  memset(&data, 0, sizeof data);
  if (begin() < CFE_SUCCESS) {
    CFE_EVS_SendEvent(ORBIDENT_APP_LIMITS_EID, CFE_EVS_EventType_ERROR,
                      "ORBIDENT: cannot begin, or has no table of limits");
    run = CFE_ES_RunStatus_APP_ERROR;
  }
  while (CFE_ES_RunLoop(&run)) {
    CFE_SB_Buffer_t* buffer = NULL;
    const CFE_Status_t status = CFE_SB_ReceiveBuffer(&buffer, data.pipe, CFE_SB_PEND_FOREVER);
    CFE_ES_PerfLogEntry(ORBIDENT_APP_PERF_ID);
    if (status == CFE_SUCCESS) {
      receive(buffer);
    } else {
      CFE_EVS_SendEvent(ORBIDENT_APP_PIPE_EID, CFE_EVS_EventType_ERROR,
                        "ORBIDENT: the pipe cannot be read (0x%08lX)", (unsigned long)status);
      run = CFE_ES_RunStatus_APP_ERROR;
    }
    CFE_ES_PerfLogExit(ORBIDENT_APP_PERF_ID);
  }
  CFE_ES_ExitApp(run);
}
