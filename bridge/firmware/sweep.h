/* One sweep: the servo from one angle to another, all rangers read at each. */
#ifndef SWEEP_H
#define SWEEP_H

#include <stdint.h>

#define RANGERS 4

/* Begins a sweep, angles in mrad; returns whether the servo can do that. */
uint8_t sweep_begin(int16_t from, int16_t to, int16_t step);

/* Points the servo and gives up a sweep; returns whether it can. */
uint8_t sweep_point(int16_t mrad);

/* To be called once in a millisecond. */
void sweep_step(uint32_t now_ms);

uint8_t sweep_is_under_way(void);

#endif
