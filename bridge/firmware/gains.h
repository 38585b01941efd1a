/* Made from the robot's model; do not edit it: a test holds that it is current.
 * cargo run -p slamlab-core --example firmware_gains > bridge/firmware/gains.h */
#ifndef GAINS_H
#define GAINS_H

#include <stdint.h>

#define PERIOD_MS 10 /* period of the controller */
#define LENGTH_MM 189 /* of the board */
#define WIDTH_MM 113 /* of the board */
#define TRACK_WIDTH_MM 197 /* effective, when turning */
#define COUNT_NM 240000 /* way of a track for one count */
#define MAX_SPEED_MM_S 300 /* of the body */
#define MAX_SPEED_Q16 819200 /* of a track, counts in a period */
#define MAX_TURN_Q16 537941 /* of a track, turning on the spot */
#define ACCELERATION_Q16 16384 /* counts in a period, in a period */
#define TURN_ACCELERATION_Q16 16138 /* of a track, turning on the spot */
#define SPEED_Q16_PER_MM_S_Q8 699051 /* times mm/s, less 8 bits: a track's speed */
#define TURN_Q16_PER_MRAD_S_Q8 68856 /* times mrad/s, less 8 bits */
#define WAY_Q12_PER_UM_Q16 1118481 /* times um, less 16 bits: counts with 12 bits */
#define TURN_Q12_PER_URAD_Q16 110170 /* times urad, less 16 bits */
#define BATTERY_MV 7200 /* the voltage of full duty */
#define OBSERVER_BITS 14 /* behind the point */
#define FEEDBACK_BITS 11 /* behind the point */
#define INTEGRAL_UNIT 64 /* counts x periods */

/* Of the left and the right motor. Rows: angle, speed, current; columns: speed, current, load. */
static const int16_t TRANSITION[2][3][3] = {
    {{15703, 674, -8038}, {14986, 674, -15832}, {-1307, -59, 1317}},
    {{15703, 674, -8038}, {14986, 674, -15832}, {-1307, -59, 1317}},
};
static const int16_t INPUT[2][3] = {
    {1636, 3368, 3361},
    {1636, 3368, 3361},
};
static const int16_t OBSERVER_GAIN[2][4] = {
    {10441, 5173, -445, -1641},
    {10441, 5173, -445, -1641},
};
static const int16_t HOLDING_CURRENT[2][2] = {
    {85, 16250},
    {85, 16250},
};
static const int16_t HOLDING_VOLTAGE[2][2] = {
    {9216, 800},
    {9216, 800},
};
static const int16_t FEEDBACK[2][7] = {
    {303, 6699, 294, -257, -11, 408, 160},
    {-440, -190, -14, 6596, 296, -496, 135},
};

#endif
