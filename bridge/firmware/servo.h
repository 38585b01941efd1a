/* The servo: a pulse of 1 to 2 ms each 20 ms, by Timer 2. */
#ifndef SERVO_H
#define SERVO_H

#include <stdint.h>

/* 1.5 ms points ahead; 1 ms of difference is a right angle. */
#define SERVO_MOST_MRAD 800

void servo_init(void);

/* Points it, mrad, counter-clockwise; the caller keeps within SERVO_MOST_MRAD. */
void servo_point(int16_t mrad);

int16_t servo_angle(void);

#endif
