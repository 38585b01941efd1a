/* The two motors: duty by Timer 1, direction by a pin each. */
#ifndef MOTOR_H
#define MOTOR_H

#include <stdint.h>

/* Duty of full voltage: 8 MHz / (2 x 210) is 19 kHz, which nobody hears. */
#define DUTY_TOP 210

void motor_init(void);

/* Duty from -DUTY_TOP to DUTY_TOP; negative drives backwards. Does nothing while the motors are
   latched. */
void motor_set(uint8_t side, int16_t duty);

/* Duty 0 at once, by writing the compare registers. For interrupts too. */
void motor_off(void);

/* Emergency stop: off, and nothing but motor_unlatch lets them turn again. */
void motor_latch(void);
void motor_unlatch(void);
uint8_t motor_is_latched(void);

#endif
