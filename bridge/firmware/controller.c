#include "controller.h"

#include "board.h"
#include "gains.h"

#define BATTERY_Q16 ((int32_t)BATTERY_MV * 65536 / 1000)
/* Errors of position and integral are kept within this, Q16: they would wrap round otherwise. */
#define MOST_ERROR ((int32_t)8000 << 16)

/* What the observer knows of a motor, Q16. */
typedef struct {
  int32_t angle; /* less the last count */
  int32_t speed;
  int32_t current;
  int32_t load; /* as the current that holds it */
} observer_t;

static observer_t observers[2];
static int32_t applied[2];       /* voltages of the present period */
static int32_t left_error;       /* observed less wished angle of the left track */
static int32_t difference_error; /* the same of left less right */
static int32_t integral;         /* of the difference's error, in INTEGRAL_UNIT counts x periods */

/* state x coefficient, less `bits`. 32 x 16 bits by two 16 x 16 products: the full product in 64
 * bits would take ten times as long on this processor. */
static int32_t times(int32_t state, int16_t coefficient, uint8_t bits) {
  int32_t high = (int32_t)(int16_t)(state >> 16) * coefficient;
  int32_t low = (int32_t)(uint32_t)(uint16_t)state * coefficient;
  return high * ((int32_t)1 << (16 - bits)) + (low >> bits);
}

#define OBSERVED(state, coefficient) times(state, coefficient, OBSERVER_BITS)
#define VOLTS(state, coefficient) times(state, coefficient, FEEDBACK_BITS)

static int32_t clamp(int32_t value, int32_t most) {
  if (value > most) return most;
  if (value < -most) return -most;
  return value;
}

static int32_t size(int32_t value) { return value < 0 ? -value : value; }

/* Predicts by the motor's model, corrects by what was counted. Returns how far the angle came,
   Q16. */
static int32_t observe(uint8_t side, int16_t counts) {
  observer_t *o = &observers[side];
  int32_t predicted[3];
  for (uint8_t row = 0; row < 3; row++) {
    const int16_t *phi = TRANSITION[side][row];
    predicted[row] = OBSERVED(o->speed, phi[0]) + OBSERVED(o->current, phi[1]) +
                     OBSERVED(o->load, phi[2]) + OBSERVED(applied[side], INPUT[side][row]);
  }
  int32_t before = o->angle;
  int32_t counted = (int32_t)counts << 16;
  int32_t angle = before + predicted[0] - counted;
  int32_t innovation = -angle;
  const int16_t *gain = OBSERVER_GAIN[side];
  o->angle = angle + OBSERVED(innovation, gain[0]);
  o->speed = predicted[1] + OBSERVED(innovation, gain[1]);
  o->current = predicted[2] + OBSERVED(innovation, gain[2]);
  o->load += OBSERVED(innovation, gain[3]);
  return counted + o->angle - before;
}

void controller_rest(void) {
  for (uint8_t side = 0; side < 2; side++) {
    observers[side] = (observer_t){0, 0, 0, 0};
    applied[side] = 0;
  }
  left_error = difference_error = integral = 0;
}

/* Cuts what both want in common before what they want apart: a weak battery makes the robot slow,
   not crooked. */
static void within_battery(const int32_t wanted[2], int32_t voltages[2]) {
  int32_t common = (wanted[LEFT] + wanted[RIGHT]) / 2;
  int32_t apart = clamp((wanted[LEFT] - wanted[RIGHT]) / 2, BATTERY_Q16);
  common = clamp(common, BATTERY_Q16 - size(apart));
  voltages[LEFT] = common + apart;
  voltages[RIGHT] = common - apart;
}

/* Whether an integrator may go on: nothing is cut off (but what halving rounds away), or the error
   has the sign of what is. */
static uint8_t may_integrate(int32_t cut, int32_t error) { return size(cut) <= 4 || error == 0 || (cut < 0) == (error < 0); }

void controller_step(const int16_t counts[2], const wish_t wishes[2], int32_t voltages[2]) {
  int32_t moved_left = observe(LEFT, counts[LEFT]);
  int32_t moved_right = observe(RIGHT, counts[RIGHT]);
  left_error = clamp(left_error + moved_left, MOST_ERROR);
  difference_error = clamp(difference_error + moved_left - moved_right, MOST_ERROR);

  int32_t speed_error[2], current_error[2], wanted[2];
  for (uint8_t side = 0; side < 2; side++) {
    const observer_t *o = &observers[side];
    int32_t current = OBSERVED(wishes[side].speed, HOLDING_CURRENT[side][0]) +
                      OBSERVED(wishes[side].acceleration, HOLDING_CURRENT[side][1]) + o->load;
    wanted[side] = VOLTS(current, HOLDING_VOLTAGE[side][0]) +
                   VOLTS(wishes[side].speed, HOLDING_VOLTAGE[side][1]);
    speed_error[side] = o->speed - wishes[side].speed;
    current_error[side] = o->current - current;
  }
  for (uint8_t side = 0; side < 2; side++) {
    const int16_t *k = FEEDBACK[side];
    wanted[side] -= VOLTS(difference_error, k[0]) + VOLTS(speed_error[LEFT], k[1]) +
                    VOLTS(current_error[LEFT], k[2]) + VOLTS(speed_error[RIGHT], k[3]) +
                    VOLTS(current_error[RIGHT], k[4]) + VOLTS(integral, k[5]) +
                    VOLTS(left_error, k[6]);
    wanted[side] = clamp(wanted[side], 4 * BATTERY_Q16);
  }
  within_battery(wanted, voltages);

  /* Integrators go on, unless that would ask for more of what is cut off. More error makes less
     voltage. */
  int32_t cut[2] = {wanted[LEFT] - voltages[LEFT], wanted[RIGHT] - voltages[RIGHT]};
  if (may_integrate(cut[LEFT] - cut[RIGHT], difference_error)) {
    integral = clamp(integral + difference_error / INTEGRAL_UNIT, MOST_ERROR);
  }
  difference_error -= wishes[LEFT].speed - wishes[RIGHT].speed;
  uint8_t is_free = may_integrate(cut[LEFT] + cut[RIGHT], speed_error[LEFT]);
  left_error -= is_free ? wishes[LEFT].speed : observers[LEFT].speed;
  applied[LEFT] = voltages[LEFT];
  applied[RIGHT] = voltages[RIGHT];
}

void controller_applied(uint8_t side, int32_t voltage) { applied[side] = voltage; }

int32_t controller_speed(uint8_t side) { return observers[side].speed; }

int32_t controller_error(uint8_t side) {
  return side == LEFT ? -left_error : difference_error - left_error;
}
