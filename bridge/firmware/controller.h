/* The controller of the two motors, in integers.
 *
 * State feedback with an observer for each motor and an integrator on both outputs: the same
 * controller that the simulated robot has, core/src/robot/controller.rs, with its gains from
 * gains.h. Numbers are "Q16": 16 bits behind the point. Angles are in counts, speeds in counts
 * in a period, currents in A, voltages in V. */
#ifndef CONTROLLER_H
#define CONTROLLER_H

#include <stdint.h>

/* What one track is to do now, Q16. */
typedef struct {
  int32_t speed;
  int32_t acceleration;
} wish_t;

/* The tracks stand: forgets everything. */
void controller_rest(void);

/* One period: takes how many counts came since the last, signed, and gives voltages, Q16. */
void controller_step(const int16_t counts[2], const wish_t wishes[2], int32_t voltages[2]);

/* Says which voltage the motor really got, where it was not the one asked for, Q16. */
void controller_applied(uint8_t side, int32_t voltage);

/* Speed of a track as the observer has it, Q16. */
int32_t controller_speed(uint8_t side);

/* How far the wished way is ahead of the observed one, Q16 counts. */
int32_t controller_error(uint8_t side);

#endif
