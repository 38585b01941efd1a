/* Milliseconds since the start, by Timer 0; and the guard that needs nothing but them. */
#ifndef CLOCK_H
#define CLOCK_H

#include <stdint.h>

/* Motors go off when the driver has been silent for this long. What is promised is 400 ms from
 * the moment at which the host sends its last command; the rest is that command's time on the
 * line and in the main loop. */
#define SILENCE_MS 390

void clock_init(void);

/* Milliseconds since the start. */
uint32_t clock_ms(void);

/* A command came: the driver is there. */
void guard_feed(void);

/* Whether the driver has been silent for too long. The interrupt has switched the motors off by
   then. */
uint8_t guard_is_silent(void);

#endif
