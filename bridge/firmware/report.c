#include "report.h"

#include "board.h"
#include "frame.h"
#include "gains.h"
#include "sweep.h"

#define HELLO 0x81
#define ACK 0x82
#define TELEMETRY 0x83
#define RANGER 0x84

/* Rangers, servo, bumpers, currents, battery. */
#define CAPABILITIES 0x1F

/* A payload under construction. Numbers are little-endian. */
typedef struct {
  uint8_t length;
  uint8_t bytes[LONGEST_PAYLOAD];
} payload_t;

static void put8(payload_t *p, uint8_t value) { p->bytes[p->length++] = value; }

static void put16(payload_t *p, uint16_t value) {
  put8(p, value);
  put8(p, value >> 8);
}

static void put32(payload_t *p, uint32_t value) {
  put16(p, value);
  put16(p, value >> 16);
}

uint8_t report_hello(uint8_t nonce, uint8_t cause) {
  /* Where the rangers look, counter-clockwise from where the servo points: ahead, left, back,
     right. */
  static const int16_t angles[RANGERS] = {0, 1571, 3142, -1571};
  payload_t p = {0, {0}};
  put8(&p, PROTOCOL);
  put8(&p, FIRMWARE_MAJOR);
  put8(&p, FIRMWARE_MINOR);
  put8(&p, nonce);
  put8(&p, cause);
  put8(&p, CAPABILITIES);
  put16(&p, LENGTH_MM);
  put16(&p, WIDTH_MM);
  put16(&p, TRACK_WIDTH_MM);
  put32(&p, COUNT_NM);
  put16(&p, MAX_SPEED_MM_S);
  put8(&p, RANGERS);
  for (uint8_t i = 0; i < RANGERS; i++) put16(&p, angles[i]);
  return frame_send(HELLO, p.bytes, p.length);
}

uint8_t report_ack(uint8_t of, uint8_t result) {
  uint8_t bytes[2] = {of, result};
  return frame_send(ACK, bytes, 2);
}

uint8_t report_telemetry(const telemetry_t *t) {
  payload_t p = {0, {0}};
  put32(&p, t->time_ms);
  put32(&p, t->counts[LEFT]);
  put32(&p, t->counts[RIGHT]);
  put16(&p, t->speeds[LEFT]);
  put16(&p, t->speeds[RIGHT]);
  put16(&p, t->currents[LEFT]);
  put16(&p, t->currents[RIGHT]);
  put16(&p, t->battery);
  put8(&p, t->state);
  put8(&p, t->fault);
  return frame_send(TELEMETRY, p.bytes, p.length);
}

uint8_t report_ranger(const reading_t *r) {
  payload_t p = {0, {0}};
  put32(&p, r->time_ms);
  put16(&p, r->servo_mrad);
  put8(&p, r->index);
  put16(&p, r->adc);
  put8(&p, r->sweep);
  return frame_send(RANGER, p.bytes, p.length);
}
