/* A bus on which the recording of golden.h comes, one sample of which is impossible; ends with 0 where
 * every other estimate that was sent is Python's. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "golden.h"
#include "orbident_app.h"

static ORBIDENT_APP_Sample_t message;
static ORBIDENT_APP_Limits_t limits;
static int sent = 0, agree = 0, changes = 0, spoilt = 0;

bool CFE_ES_RunLoop(uint32* status) { return *status == CFE_ES_RunStatus_APP_RUN && sent <= GOLDEN_STEPS; }
void CFE_ES_ExitApp(uint32 status) { spoilt += status != CFE_ES_RunStatus_APP_RUN; }
void CFE_ES_PerfLogEntry(uint32 id) { (void)id; }
void CFE_ES_PerfLogExit(uint32 id) { (void)id; }
CFE_Status_t CFE_EVS_Register(const void* f, uint16 n, uint16 s) { (void)f, (void)n, (void)s; return CFE_SUCCESS; }
CFE_Status_t CFE_EVS_SendEvent(uint16 id, uint16 type, const char* format, ...) {
  (void)type, (void)format;
  changes += id == ORBIDENT_APP_CHANGED_EID;
  return CFE_SUCCESS;
}
CFE_SB_MsgId_t CFE_SB_ValueToMsgId(uint32 value) { return (CFE_SB_MsgId_t){value}; }
CFE_Status_t CFE_SB_CreatePipe(CFE_SB_PipeId_t* p, uint16 d, const char* n) { (void)d, (void)n; *p = 7; return CFE_SUCCESS; }
CFE_Status_t CFE_SB_Subscribe(CFE_SB_MsgId_t id, CFE_SB_PipeId_t p) { (void)id, (void)p; return CFE_SUCCESS; }
CFE_Status_t CFE_SB_ReceiveBuffer(CFE_SB_Buffer_t** buffer, CFE_SB_PipeId_t pipe, int32 timeout) {
  (void)timeout;
  const int k = sent < 5 ? sent : sent - 1; /* the fifth comes spoilt first */
  for (int i = 0; i < ROBOT_MEASURED; ++i)
    message.sample[i] = (orbident_real)GOLDEN_SAMPLE[(long)k * ROBOT_MEASURED + i];
  message.t = (orbident_real)GOLDEN_TIME[k];
  if (sent == 5) message.sample[0] = 50;
  *buffer = (CFE_SB_Buffer_t*)&message;
  return pipe == 7 ? CFE_SUCCESS : -1;
}
CFE_Status_t CFE_SB_TransmitMsg(const CFE_MSG_Message_t* sent_message, bool origin) {
  const ORBIDENT_APP_Estimate_t* const out = (const ORBIDENT_APP_Estimate_t*)sent_message;
  const int k = sent < 5 ? sent : sent - 1;
  int same = origin;
  if (sent == 5) spoilt += out->code != ORBIDENT_ABSURD || out->refused != 1;
  /* After a change the deviations are of the opened filter, and the estimate is the same. */
  for (int i = 0; i < ROBOT_BETAS; ++i) same &= (double)out->beta[i] == GOLDEN_BETA[k * ROBOT_BETAS + i];
  if (sent != 5) agree += same;
  ++sent;
  return CFE_SUCCESS;
}
void CFE_SB_TimeStampMsg(CFE_MSG_Message_t* m) { (void)m; }
CFE_Status_t CFE_MSG_Init(CFE_MSG_Message_t* m, CFE_SB_MsgId_t id, CFE_MSG_Size_t n) { (void)m, (void)id, (void)n; return CFE_SUCCESS; }
CFE_Status_t CFE_MSG_GetSize(const CFE_MSG_Message_t* m, CFE_MSG_Size_t* n) { (void)m; *n = sizeof message; return CFE_SUCCESS; }
CFE_Status_t CFE_TBL_Register(CFE_TBL_Handle_t* t, const char* n, size_t s, uint16 o, CFE_TBL_CallbackFuncPtr_t c) {
  (void)n, (void)o, (void)c;
  *t = 3;
  for (int i = 0; i < ROBOT_MEASURED; ++i) limits.least[i] = i ? -1e4 : -10, limits.most[i] = i ? 1e4 : 10;
  return s == sizeof limits ? CFE_SUCCESS : -1;
}
CFE_Status_t CFE_TBL_Load(CFE_TBL_Handle_t t, CFE_TBL_SrcEnum_t s, const void* d) { (void)t, (void)s, (void)d; return CFE_SUCCESS; }
CFE_Status_t CFE_TBL_Manage(CFE_TBL_Handle_t t) { (void)t; return CFE_SUCCESS; }
CFE_Status_t CFE_TBL_GetAddress(void** a, CFE_TBL_Handle_t t) { (void)t; *a = &limits; return CFE_SUCCESS; }
CFE_Status_t CFE_TBL_ReleaseAddress(CFE_TBL_Handle_t t) { (void)t; return CFE_SUCCESS; }

int main(void) {
  ORBIDENT_APP_Main();
  printf("%d of %d agree, %d changes\n", agree, GOLDEN_STEPS, changes);
  return agree != GOLDEN_STEPS || spoilt;
}
