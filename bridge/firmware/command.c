#include "command.h"

#include "clock.h"
#include "drive.h"
#include "motor.h"
#include "report.h"
#include "sweep.h"

#define GREET 0x01
#define VELOCITY 0x02
#define FORWARD 0x03
#define TURN 0x04
#define STOP 0x05
#define ESTOP 0x06
#define RESET 0x07
#define SERVO 0x08
#define SWEEP 0x09
#define SET_RATE 0x0A
#define ALIVE 0x0B

#define SHORTEST_PERIOD_MS 10
#define LONGEST_PERIOD_MS 500

static uint16_t telemetry_period_ms = 50;
static uint8_t last_sequence;
static uint8_t has_sequence; /* since the last greeting */

static int16_t take16(const uint8_t *at) { return at[0] | (uint16_t)at[1] << 8; }

static int32_t take32(const uint8_t *at) { return (uint16_t)take16(at) | (uint32_t)(uint16_t)take16(at + 2) << 16; }

/* Length that a payload of this kind has; 255 for a kind that is none. */
static uint8_t payload_length(uint8_t kind) {
  switch (kind) {
    case STOP:
    case ESTOP:
    case RESET:
    case ALIVE:
      return 0;
    case GREET:
      return 1;
    case SERVO:
    case SET_RATE:
      return 2;
    case VELOCITY:
    case FORWARD:
    case TURN:
      return 4;
    case SWEEP:
      return 6;
    default:
      return 255;
  }
}

static uint8_t set_rate(uint16_t period_ms) {
  if (period_ms < SHORTEST_PERIOD_MS || period_ms > LONGEST_PERIOD_MS) return 0;
  telemetry_period_ms = period_ms;
  return 1;
}

static uint8_t moves(uint8_t kind) { return kind == VELOCITY || kind == FORWARD || kind == TURN; }

/* Does it; returns whether the figures are within what the robot can do. */
static uint8_t run(uint8_t kind, const uint8_t *payload) {
  switch (kind) {
    case VELOCITY:
      return drive_velocity(take16(payload), take16(payload + 2));
    case FORWARD:
      return drive_forward(take32(payload));
    case TURN:
      return drive_turn(take32(payload));
    case STOP:
      drive_abort(); /* no ramp: whoever stops it must not wait for one */
      return 1;
    case ESTOP:
      motor_latch(); /* first the registers, then the rest */
      drive_abort();
      return 1;
    case RESET:
      drive_abort(); /* nothing that was under way goes on */
      motor_unlatch();
      return 1;
    case SERVO:
      return sweep_point(take16(payload));
    case SWEEP:
      return sweep_begin(take16(payload), take16(payload + 2), take16(payload + 4));
    case SET_RATE:
      return set_rate(take16(payload));
    default:
      return 1; /* ALIVE */
  }
}

static uint8_t judge(uint8_t kind, uint8_t sequence, const uint8_t *payload) {
  if (has_sequence) {
    if (sequence == last_sequence) return VERDICT_REPEATED;
    if ((int8_t)(sequence - last_sequence) < 0) return VERDICT_STALE;
  }
  last_sequence = sequence;
  has_sequence = 1;
  if (moves(kind) && motor_is_latched()) return VERDICT_LATCHED;
  /* Silence has switched the motors off, and the loop may not have seen it yet: a sign of life must
     not let go on what was ended. */
  if (guard_is_silent()) drive_abort();
  /* Before it runs: silence from before this command must not switch off what it starts. */
  guard_feed();
  return run(kind, payload) ? VERDICT_DONE : VERDICT_BAD_VALUE;
}

void command_take(const frame_t *frame, uint8_t cause) {
  uint8_t kind = frame->bytes[0];
  uint8_t sequence = frame->bytes[1];
  const uint8_t *payload = frame->bytes + 2;
  uint8_t length = payload_length(kind);
  if (length == 255 || length != frame->length - 2) {
    report_ack(sequence, VERDICT_UNKNOWN_KIND);
    return;
  }
  if (kind == GREET) {
    drive_abort();
    has_sequence = 0;
    report_hello(payload[0], cause);
    return;
  }
  report_ack(sequence, judge(kind, sequence, payload));
}

uint16_t command_telemetry_period(void) { return telemetry_period_ms; }
