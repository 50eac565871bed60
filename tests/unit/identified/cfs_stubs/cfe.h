/* As much of the public interface of cFE 7 as the example calls, written from its documentation. */
#ifndef CFE_H
#define CFE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef int32_t int32;
typedef uint32_t uint32;
typedef uint16_t uint16;
typedef uint8_t uint8;
typedef int32 CFE_Status_t;
typedef uint32 CFE_SB_PipeId_t;
typedef int16_t CFE_TBL_Handle_t;
typedef size_t CFE_MSG_Size_t;
typedef struct { uint32 Value; } CFE_SB_MsgId_t;
typedef struct { uint8 Byte[8]; } CFE_MSG_Message_t;
typedef struct { CFE_MSG_Message_t Msg; uint8 Time[8]; } CFE_MSG_TelemetryHeader_t;
typedef union { CFE_MSG_Message_t Msg; long long LongInt; long double LongDouble; } CFE_SB_Buffer_t;
typedef struct { uint16 EventID, Mask; } CFE_EVS_BinFilter_t;
typedef CFE_Status_t (*CFE_TBL_CallbackFuncPtr_t)(void*);

#define CFE_SUCCESS ((CFE_Status_t)0)
#define CFE_SB_PEND_FOREVER (-1)
#define CFE_TBL_OPT_DEFAULT 0
#define CFE_EVS_EventFilter_BINARY 0
#define CFE_MSG_PTR(header) (&(header).Msg)
enum { CFE_ES_RunStatus_APP_RUN = 1, CFE_ES_RunStatus_APP_EXIT, CFE_ES_RunStatus_APP_ERROR };
enum { CFE_EVS_EventType_DEBUG = 1, CFE_EVS_EventType_INFORMATION, CFE_EVS_EventType_ERROR,
       CFE_EVS_EventType_CRITICAL };
typedef enum { CFE_TBL_SRC_FILE = 0, CFE_TBL_SRC_ADDRESS } CFE_TBL_SrcEnum_t;

bool CFE_ES_RunLoop(uint32* status);
void CFE_ES_ExitApp(uint32 status);
void CFE_ES_PerfLogEntry(uint32 id);
void CFE_ES_PerfLogExit(uint32 id);
CFE_Status_t CFE_EVS_Register(const void* filters, uint16 count, uint16 scheme);
CFE_Status_t CFE_EVS_SendEvent(uint16 id, uint16 type, const char* format, ...)
    __attribute__((format(printf, 3, 4)));
CFE_SB_MsgId_t CFE_SB_ValueToMsgId(uint32 value);
CFE_Status_t CFE_SB_CreatePipe(CFE_SB_PipeId_t* pipe, uint16 depth, const char* name);
CFE_Status_t CFE_SB_Subscribe(CFE_SB_MsgId_t id, CFE_SB_PipeId_t pipe);
CFE_Status_t CFE_SB_ReceiveBuffer(CFE_SB_Buffer_t** buffer, CFE_SB_PipeId_t pipe, int32 timeout);
CFE_Status_t CFE_SB_TransmitMsg(const CFE_MSG_Message_t* message, bool origin);
void CFE_SB_TimeStampMsg(CFE_MSG_Message_t* message);
CFE_Status_t CFE_MSG_Init(CFE_MSG_Message_t* message, CFE_SB_MsgId_t id, CFE_MSG_Size_t size);
CFE_Status_t CFE_MSG_GetSize(const CFE_MSG_Message_t* message, CFE_MSG_Size_t* size);
CFE_Status_t CFE_TBL_Register(CFE_TBL_Handle_t* table, const char* name, size_t size, uint16 options,
                              CFE_TBL_CallbackFuncPtr_t check);
CFE_Status_t CFE_TBL_Load(CFE_TBL_Handle_t table, CFE_TBL_SrcEnum_t source, const void* data);
CFE_Status_t CFE_TBL_Manage(CFE_TBL_Handle_t table);
CFE_Status_t CFE_TBL_GetAddress(void** address, CFE_TBL_Handle_t table);
CFE_Status_t CFE_TBL_ReleaseAddress(CFE_TBL_Handle_t table);

#endif
