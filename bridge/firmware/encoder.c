#include "encoder.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "board.h"

static volatile uint8_t edges[2];

void encoder_init(void) {
  PORTB |= 1 << SENSOR_POWER_PIN;
  DDRB |= 1 << SENSOR_POWER_PIN;
  /* Any change of level: both edges of each bar count. */
  MCUCR |= (1 << ISC00) | (1 << ISC10);
  GICR |= (1 << INT0) | (1 << INT1);
}

ISR(INT0_vect) {
  if (edges[LEFT] != 255) edges[LEFT]++;
}

ISR(INT1_vect) {
  if (edges[RIGHT] != 255) edges[RIGHT]++;
}

uint8_t encoder_take(uint8_t side) {
  uint8_t taken;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    taken = edges[side];
    edges[side] = 0;
  }
  return taken;
}
