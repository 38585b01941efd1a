/* 1. Forward speed and turn rate (half the difference of the tracks) follow what is asked for,
 *    within their accelerations.
 * 2. A way is a trapezoid: the speed from which the rest is just enough to stop.
 * 3. The encoders do not tell the direction. A track counts in the direction that is wished of
 *    it; it is wished the other way only once it stands. And once it is slow, no voltage may
 *    drive it against the direction in which it is counted: a step back would be counted as one
 *    ahead, and the controller would run away from its own error.
 * 4. Driven hard without a count for a second: the encoder or the motor is at fault, and the
 *    motors go off. */
#include "drive.h"

#include "board.h"
#include "controller.h"
#include "encoder.h"
#include "gains.h"
#include "motor.h"

/* Periods without a count after which a track stands, a way is done, and a driven track is at
   fault. */
#define STILL 4
#define LONGEST_SETTLING 60
#define STALLED 100
/* Below this speed, Q16 counts in a period, no voltage against the direction of counting. */
#define SLOW ((int32_t)2 << 16)
/* The duty that ought to turn a track. */
#define HARD (DUTY_TOP / 3)
/* Ways and turns are within 100 m and 100 rad: 12 bits behind the point leave room for no more. */
#define MOST_UM 100000000L
#define MOST_MM_S 1000
#define MOST_MRAD_S 10000

typedef enum { SPEEDS, FORWARD, TURN, SETTLE } task_t;

static task_t task;
static int32_t asked_forward, asked_turn; /* Q16 counts in a period */
static int32_t forward, turn;             /* the same, wished now */
static int32_t way_left;                  /* Q12 counts */
static uint8_t is_let_go = 1;
static uint8_t settling_for;
static uint8_t fault;

/* What is known of a track. */
static int8_t direction[2] = {1, 1};
static uint8_t still_for[2] = {STILL, STILL};
static uint8_t stalled_for[2];
static int32_t counts[2];
static int32_t last_speed[2]; /* wished in the last period */
static int16_t duty[2];

static int32_t clamp(int32_t value, int32_t most) {
  if (value > most) return most;
  if (value < -most) return -most;
  return value;
}

static int32_t size(int32_t value) { return value < 0 ? -value : value; }

static void begin(task_t what) {
  task = what;
  is_let_go = 0;
  settling_for = 0;
  fault = FAULT_NONE;
  stalled_for[LEFT] = stalled_for[RIGHT] = 0;
}

uint8_t drive_velocity(int16_t forward_mm_s, int16_t turn_mrad_s) {
  /* What no RP6 can do is a mistake; what this one cannot quite do is cut. */
  if (size(forward_mm_s) > MOST_MM_S || size(turn_mrad_s) > MOST_MRAD_S) return 0;
  int32_t f = clamp((int32_t)forward_mm_s * SPEED_Q16_PER_MM_S_Q8 / 256, MAX_SPEED_Q16);
  int32_t t = clamp((int32_t)turn_mrad_s * TURN_Q16_PER_MRAD_S_Q8 / 256, MAX_TURN_Q16);
  /* Where the outer track could not follow, both give way by the same factor: the curve stays the
     curve. */
  int32_t outer = size(f) + size(t);
  if (outer > MAX_SPEED_Q16) {
    f = (int64_t)f * MAX_SPEED_Q16 / outer;
    t = (int64_t)t * MAX_SPEED_Q16 / outer;
  }
  begin(SPEEDS);
  asked_forward = f;
  asked_turn = t;
  return 1;
}

uint8_t drive_forward(int32_t way_um) {
  if (size(way_um) > MOST_UM) return 0;
  begin(FORWARD);
  way_left = (int64_t)way_um * WAY_Q12_PER_UM_Q16 >> 16;
  return 1;
}

uint8_t drive_turn(int32_t angle_urad) {
  if (size(angle_urad) > MOST_UM) return 0;
  begin(TURN);
  way_left = (int64_t)angle_urad * TURN_Q12_PER_URAD_Q16 >> 16;
  return 1;
}

void drive_abort(void) {
  motor_off();
  task = SPEEDS;
  asked_forward = asked_turn = 0;
  forward = turn = 0;
  is_let_go = 1;
  for (uint8_t side = 0; side < 2; side++) {
    last_speed[side] = 0;
    duty[side] = 0;
    stalled_for[side] = 0;
  }
  controller_rest();
}

static uint16_t square_root(uint32_t of) {
  uint32_t root = 0;
  for (uint32_t bit = 1UL << 30; bit; bit >>= 2) {
    if (of >= root + bit) {
      of -= root + bit;
      root = (root >> 1) + bit;
    } else {
      root >>= 1;
    }
  }
  return root;
}

/* The highest speed v, Q16, at which after one more period the rest of the way is enough to stop:
   v + v2/(2 a) = left. */
static int32_t stopping_speed(int32_t left, int32_t acceleration) {
  uint32_t a = acceleration >> 4; /* Q12, as the way */
  uint32_t way = size(left);
  if (way > 400UL << 12) way = 400UL << 12; /* beyond this any speed can stop in time, and 32 bits would not do */
  uint32_t v;
  if (way <= a) {
    v = way;
  } else {
    v = square_root(a * a + 2 * a * way) - a;
  }
  return left < 0 ? -(int32_t)(v << 4) : (int32_t)(v << 4);
}

static int32_t towards(int32_t from, int32_t to, int32_t most) { return from + clamp(to - from, most); }

/* Wished speeds of the body for this period. */
static void ramp(void) {
  int32_t f = 0, t = 0;
  if (task == SPEEDS) {
    f = asked_forward;
    t = asked_turn;
  } else if (task == FORWARD) {
    f = clamp(stopping_speed(way_left, ACCELERATION_Q16), MAX_SPEED_Q16);
  } else if (task == TURN) {
    t = clamp(stopping_speed(way_left, TURN_ACCELERATION_Q16), MAX_TURN_Q16);
  }
  forward = towards(forward, f, ACCELERATION_Q16);
  turn = towards(turn, t, TURN_ACCELERATION_Q16);
}

static void count_down(void) {
  int32_t done, most;
  if (task == FORWARD) {
    done = forward;
    most = ACCELERATION_Q16;
  } else if (task == TURN) {
    done = turn;
    most = TURN_ACCELERATION_Q16;
  } else {
    return;
  }
  way_left -= done >> 4;
  if (size(way_left) < 41 && size(done) <= most) { /* 41: a hundredth of a count */
    task = SETTLE;
  }
}

/* Turns the wishes of a track into what can be counted; returns the wished speed. */
static int32_t wished_speed(uint8_t side) {
  int32_t speed = side == LEFT ? forward - turn : forward + turn;
  int8_t wanted = speed < 0 ? -1 : 1;
  if (speed == 0 || wanted == direction[side]) return speed;
  if (still_for[side] < STILL) return 0; /* first it has to stand */
  direction[side] = wanted;
  return speed;
}

static void take_counts(int16_t came[2]) {
  for (uint8_t side = 0; side < 2; side++) {
    uint8_t edges = encoder_take(side);
    came[side] = (int16_t)edges * direction[side];
    counts[side] += came[side];
    if (edges) {
      still_for[side] = 0;
    } else if (still_for[side] < 255) {
      still_for[side]++;
    }
  }
}

/* Voltage, Q16, to duty; none against the direction of counting once the track is slow. */
static void drive_motor(uint8_t side, int32_t voltage) {
  int32_t speed = controller_speed(side) * direction[side];
  uint8_t is_against = voltage != 0 && (voltage < 0) != (direction[side] < 0);
  if (is_against && speed < SLOW) {
    voltage = 0;
    controller_applied(side, 0);
  }
  duty[side] = (voltage >> 8) * ((int32_t)DUTY_TOP * 1000 / (BATTERY_MV / 16)) / (16L * 256L);
  motor_set(side, duty[side]);
}

static void watch_for_stall(void) {
  for (uint8_t side = 0; side < 2; side++) {
    uint8_t is_driven = duty[side] > HARD || duty[side] < -HARD;
    if (!is_driven || still_for[side] == 0) {
      stalled_for[side] = 0;
    } else if (++stalled_for[side] >= STALLED) {
      drive_abort();
      fault = side == LEFT ? FAULT_LEFT_ENCODER : FAULT_RIGHT_ENCODER;
      return;
    }
  }
}

/* Lets the motors go when they stand where they should. */
static void settle(void) {
  if (forward != 0 || turn != 0 || asked_forward != 0 || asked_turn != 0 || task == FORWARD || task == TURN) {
    settling_for = 0;
    return;
  }
  settling_for++;
  uint8_t stands = still_for[LEFT] >= STILL && still_for[RIGHT] >= STILL;
  uint8_t is_there = size(controller_error(LEFT)) <= 65536 && size(controller_error(RIGHT)) <= 65536;
  if ((stands && (is_there || task != SETTLE)) || settling_for >= LONGEST_SETTLING) {
    drive_abort();
  }
}

void drive_step(void) {
  int16_t came[2];
  take_counts(came);
  if (is_let_go) return;
  ramp();
  wish_t wishes[2];
  for (uint8_t side = 0; side < 2; side++) {
    wishes[side].speed = wished_speed(side);
    wishes[side].acceleration = wishes[side].speed - last_speed[side];
    last_speed[side] = wishes[side].speed;
  }
  int32_t voltages[2];
  controller_step(came, wishes, voltages);
  drive_motor(LEFT, voltages[LEFT]);
  drive_motor(RIGHT, voltages[RIGHT]);
  count_down();
  settle();
  watch_for_stall();
}

uint8_t drive_is_driven(void) { return !is_let_go; }

uint8_t drive_is_moving(void) { return !is_let_go || still_for[LEFT] < STILL || still_for[RIGHT] < STILL; }

int32_t drive_counts(uint8_t side) { return counts[side]; }

int16_t drive_speed(uint8_t side) {
  if (is_let_go) return 0;
  return ((controller_speed(side) >> 4) * (1000 / PERIOD_MS)) >> 12;
}

uint8_t drive_fault(void) { return fault; }
