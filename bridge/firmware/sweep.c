#include "sweep.h"

#include "analog.h"
#include "board.h"
#include "report.h"
#include "servo.h"

/* A new angle reaches the servo with its next pulse, 20 ms later at most, and takes it a
 * millisecond for each degree; a ranger measures once in 38.3 +- 9.6 ms and holds its output
 * meanwhile. After this long, and the way, what it says was measured there. */
#define DWELL_MS 68
#define MRAD_PER_MS 17

static uint8_t number;
static uint8_t is_under_way;
static int16_t last, step;
static uint8_t waits;
static uint8_t ranger;

static uint8_t is_within(int16_t mrad) { return mrad >= -SERVO_MOST_MRAD && mrad <= SERVO_MOST_MRAD; }

static void go_to(int16_t mrad) {
  int16_t way = mrad - servo_angle();
  waits = DWELL_MS + (way < 0 ? -way : way) / MRAD_PER_MS;
  servo_point(mrad);
  ranger = 0;
  analog_select(0);
}

uint8_t sweep_begin(int16_t from, int16_t to, int16_t by) {
  if (!is_within(from) || !is_within(to) || by <= 0 || by > 2 * SERVO_MOST_MRAD) return 0;
  last = to;
  step = from <= to ? by : -by;
  number++;
  is_under_way = 1;
  go_to(from);
  return 1;
}

uint8_t sweep_point(int16_t mrad) {
  if (!is_within(mrad)) return 0;
  is_under_way = 0;
  servo_point(mrad);
  return 1;
}

void sweep_step(uint32_t now_ms) {
  if (!is_under_way) return;
  if (waits > 0) {
    waits--;
    return;
  }
  reading_t reading = {now_ms, servo_angle(), ranger, analog_read(ADC_RANGERS), number};
  if (!report_ranger(&reading)) return; /* the line is full: a millisecond later, then */
  ranger++;
  analog_select(ranger);
  if (ranger < RANGERS) return;
  int16_t next = servo_angle() + step;
  if (step > 0 ? next > last : next < last) {
    is_under_way = 0;
  } else {
    go_to(next);
  }
}

uint8_t sweep_is_under_way(void) { return is_under_way; }
