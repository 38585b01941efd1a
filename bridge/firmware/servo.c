#include "servo.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "board.h"

/* Timer 2 counts in steps of 4 us and holds 256 of them. A pulse or a pause is made of pieces of at most PIECE steps; the
 * rest of each is at least half of that, so that there is time to set the next one. */
#define STEPS_PER_MS 250
#define PERIOD_STEPS (20 * STEPS_PER_MS)
#define PIECE 200

static volatile uint16_t pulse = 3 * STEPS_PER_MS / 2;
static int16_t angle;

void servo_init(void) {
  DDRA |= 1 << SERVO_PIN;
  OCR2 = PIECE - 1;
  TCCR2 = (1 << WGM21) | (1 << CS21) | (1 << CS20); /* cleared on a match; 8 MHz / 32 */
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
  /* 1 ms, 250 steps, for pi/2: 0.15915 steps for a mrad. */
  uint16_t steps = 3 * STEPS_PER_MS / 2 + (int16_t)((int32_t)mrad * 10430 / 65536);
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { pulse = steps; }
}

int16_t servo_angle(void) { return angle; }
