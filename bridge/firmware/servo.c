#include "servo.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "board.h"

/* Timer 2 counts in steps of 1 us and holds 256 of them. A pulse or a pause is made of pieces of
 * at most PIECE steps, and none is shorter than half of that, so that there is time to set the
 * next one: 5000 interrupts a second, 4 % of the time. */
#define STEPS_PER_MS 1000
#define PERIOD_STEPS (20 * STEPS_PER_MS)
#define PIECE 200

static volatile uint16_t pulse = 3 * STEPS_PER_MS / 2;
static int16_t angle;

void servo_init(void) {
  DDRA |= 1 << SERVO_PIN;
  OCR2 = PIECE - 1;
  TCCR2 = (1 << WGM21) | (1 << CS21); /* cleared on a match; 8 MHz / 8 */
  TIMSK |= 1 << OCIE2;
}

/* A piece is over: sets the next. */
ISR(TIMER2_COMP_vect) {
  static uint16_t left;
  static uint8_t is_high;
  if (left == 0) {
    is_high = !is_high;
    if (is_high) {
      PORTA |= 1 << SERVO_PIN;
      left = pulse;
    } else {
      PORTA &= ~(1 << SERVO_PIN);
      left = PERIOD_STEPS - pulse;
    }
  }
  uint8_t piece = left;
  if (left > 2 * PIECE) {
    piece = PIECE;
  } else if (left > PIECE) {
    piece = left / 2;
  }
  left -= piece;
  OCR2 = piece - 1;
}

void servo_point(int16_t mrad) {
  angle = mrad;
  /* 1 ms, 1000 steps, for pi/2: 0.63662 steps for a mrad. */
  uint16_t steps = 3 * STEPS_PER_MS / 2 + (int16_t)((int32_t)mrad * 41722 / 65536);
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { pulse = steps; }
}

int16_t servo_angle(void) { return angle; }
