#include "motor.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "board.h"

static volatile uint8_t is_latched;

void motor_init(void) {
  /* Phase-correct PWM with ICR1 as top (mode 10); pins high while the counter is below the compare
     register. */
  OCR1A = 0;
  OCR1B = 0;
  ICR1 = DUTY_TOP;
  TCCR1A = (1 << COM1A1) | (1 << COM1B1) | (1 << WGM11);
  TCCR1B = (1 << WGM13) | (1 << CS10);
  DDRC |= (1 << DIRECTION_LEFT_PIN) | (1 << DIRECTION_RIGHT_PIN);
  DDRD |= (1 << PWM_LEFT_PIN) | (1 << PWM_RIGHT_PIN);
}

void motor_set(uint8_t side, int16_t duty) {
  uint8_t is_backwards = duty < 0;
  uint16_t size = is_backwards ? -duty : duty;
  if (size > DUTY_TOP) size = DUTY_TOP;
  uint8_t pin = side == LEFT ? DIRECTION_LEFT_PIN : DIRECTION_RIGHT_PIN;
  /* The 16-bit registers share one buffer byte with whatever an interrupt writes: not to be
   * parted. And the latch must be looked at in the same moment. */
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    if (is_latched) size = 0;
    if (is_backwards) {
      PORTC |= 1 << pin;
    } else {
      PORTC &= ~(1 << pin);
    }
    if (side == LEFT) {
      OCR1B = size;
    } else {
      OCR1A = size;
    }
  }
}

void motor_off(void) {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    OCR1A = 0;
    OCR1B = 0;
  }
}

void motor_latch(void) {
  is_latched = 1;
  motor_off();
}

void motor_unlatch(void) { is_latched = 0; }

uint8_t motor_is_latched(void) { return is_latched; }
