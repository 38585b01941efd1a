/* What the robot says: the reports of the protocol, byte for byte. */
#ifndef REPORT_H
#define REPORT_H

#include <stdint.h>

#define PROTOCOL 1
#define FIRMWARE_MAJOR 0
#define FIRMWARE_MINOR 1

#define VERDICT_DONE 0
#define VERDICT_REPEATED 1
#define VERDICT_STALE 2
#define VERDICT_BAD_VALUE 3
#define VERDICT_LATCHED 4
#define VERDICT_UNKNOWN_KIND 5

#define STATE_BUMPER_LEFT (1 << 0)
#define STATE_BUMPER_RIGHT (1 << 1)
#define STATE_MOVING (1 << 2)
#define STATE_SWEEPING (1 << 3)
#define STATE_LATCHED (1 << 4)
#define STATE_SILENT (1 << 5)

#define CAUSE_POWER_ON 1
#define CAUSE_EXTERNAL 2
#define CAUSE_BROWN_OUT 3
#define CAUSE_WATCHDOG 4

typedef struct {
  uint32_t time_ms;
  int32_t counts[2];
  int16_t speeds[2];
  uint16_t currents[2];
  uint16_t battery;
  uint8_t state;
  uint8_t fault;
} telemetry_t;

typedef struct {
  uint32_t time_ms;
  int16_t servo_mrad;
  uint8_t index;
  uint16_t adc;
  uint8_t sweep;
} reading_t;

/* Each returns whether there was room on the line. */
uint8_t report_hello(uint8_t nonce, uint8_t cause);
uint8_t report_ack(uint8_t of, uint8_t result);
uint8_t report_telemetry(const telemetry_t *telemetry);
uint8_t report_ranger(const reading_t *reading);

#endif
