/* From commands to motors: speeds that change no faster than they may, and ways that end where they
   should. */
#ifndef DRIVE_H
#define DRIVE_H

#include <stdint.h>

#define FAULT_NONE 0
#define FAULT_LEFT_ENCODER 1
#define FAULT_RIGHT_ENCODER 2
#define FAULT_BATTERY_LOW 4

/* Each returns whether the robot can do that. */
uint8_t drive_velocity(int16_t forward_mm_s, int16_t turn_mrad_s);
uint8_t drive_forward(int32_t way_um);
uint8_t drive_turn(int32_t angle_urad);

/* Gives up everything at once; the motors are off already or go off now. */
void drive_abort(void);

/* One period of the controller. */
void drive_step(void);

/* Whether the motors are under control: something is under way. */
uint8_t drive_is_driven(void);

/* Whether that is so, or the tracks turn all the same. */
uint8_t drive_is_moving(void);

/* Counts since the start, signed by the direction driven. */
int32_t drive_counts(uint8_t side);

/* Speed, counts/s. */
int16_t drive_speed(uint8_t side);

/* What is wrong; 0 when nothing is. A new command clears it. */
uint8_t drive_fault(void);

#endif
