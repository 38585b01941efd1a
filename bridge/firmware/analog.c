#include "analog.h"

#include <avr/io.h>

#include "board.h"

void analog_init(void) {
  DDRC |= 3 << SELECT_SHIFT;
  /* 8 MHz / 64 = 125 kHz: the converter is exact from 50 to 200 kHz. */
  ADCSRA = (1 << ADEN) | (1 << ADPS2) | (1 << ADPS1);
}

uint16_t analog_read(uint8_t channel) {
  ADMUX = (1 << REFS0) | channel; /* reference: the supply */
  /* The first conversion after a change of channel may still sample the old one: it is thrown
     away. */
  for (uint8_t i = 0; i < 2; i++) {
    ADCSRA |= 1 << ADSC;
    while (ADCSRA & (1 << ADSC)) {
    }
  }
  return ADC;
}

void analog_select(uint8_t ranger) {
  PORTC = (PORTC & ~(3 << SELECT_SHIFT)) | (ranger & 3) << SELECT_SHIFT;
}
