/* The serial line: 38400 baud, 8 data bits, no parity, 1 stop bit, with a ring of bytes each
   way. */
#ifndef UART_H
#define UART_H

#include <stdint.h>

void uart_init(void);

/* Takes the oldest byte that came; 0 when there is none. */
uint8_t uart_read(uint8_t *byte);

/* Queues all the bytes, or none when there is no room: half a frame would be worse than none.
   Returns whether it did. */
uint8_t uart_write(const uint8_t *bytes, uint8_t length);

#endif
