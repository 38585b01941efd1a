/* The encoders: each has one channel, so it tells that a track moves, but not which way. */
#ifndef ENCODER_H
#define ENCODER_H

#include <stdint.h>

void encoder_init(void);

/* Edges since this was last asked; at most 255, which is 20 times what 10 ms can bring. */
uint8_t encoder_take(uint8_t side);

#endif
