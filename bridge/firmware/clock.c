#include "clock.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "board.h"
#include "motor.h"

static volatile uint32_t milliseconds;
static volatile uint16_t silent_ms = SILENCE_MS;

void clock_init(void) {
  /* 8 MHz / 64 = 125 kHz; cleared on a match (CTC) each 125 steps: 1 kHz. */
  OCR0 = F_CPU_HZ / 64 / 1000 - 1;
  TCCR0 = (1 << WGM01) | (1 << CS01) | (1 << CS00);
  TIMSK |= 1 << OCIE0;
}

/* Switching the motors off here, and not in the main loop, keeps the promise when the main loop is
   busy or stuck. */
ISR(TIMER0_COMP_vect) {
  milliseconds++;
  if (silent_ms < SILENCE_MS) {
    silent_ms++;
  } else {
    motor_off();
  }
}

uint32_t clock_ms(void) {
  uint32_t now;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { now = milliseconds; }
  return now;
}

void guard_feed(void) {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { silent_ms = 0; }
}

uint8_t guard_is_silent(void) {
  uint16_t silent;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { silent = silent_ms; }
  return silent >= SILENCE_MS;
}
