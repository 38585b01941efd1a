/* What the robot is told. */
#ifndef COMMAND_H
#define COMMAND_H

#include <stdint.h>

#include "frame.h"

/* Does what a frame asks for, and acknowledges it. `cause` is why the robot started, for its
   hello. */
void command_take(const frame_t *frame, uint8_t cause);

/* Time from one telemetry to the next, ms. */
uint16_t command_telemetry_period(void);

#endif
