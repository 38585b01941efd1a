/* The analogue-to-digital converter: 10 bits over 5 V. */
#ifndef ANALOG_H
#define ANALOG_H

#include <stdint.h>

void analog_init(void);

/* Reads a channel; takes 0.2 ms. */
uint16_t analog_read(uint8_t channel);

/* Puts one of the four rangers on channel ADC_RANGERS; it needs a moment to settle. */
void analog_select(uint8_t ranger);

#endif
