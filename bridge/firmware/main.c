/* Firmware of the RP6: drives by commands from the serial line, sweeps four rangers, and stops
 * when in doubt.
 *
 * Three guards, none of which needs the others:
 *   - the timer interrupt switches the motors off when no command came for 400 ms (clock.c);
 *   - an emergency stop writes the motors' registers at once and is latched (motor.c);
 *   - the hardware watchdog resets the controller when this loop hangs; after a reset the motor
 *     pins are off.
 *
 * Written from the data sheet of the ATmega32 and the manual of the RP6; nothing of the vendor's
 * library is used. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/wdt.h>

#include "analog.h"
#include "board.h"
#include "clock.h"
#include "command.h"
#include "controller.h"
#include "drive.h"
#include "encoder.h"
#include "frame.h"
#include "gains.h"
#include "motor.h"
#include "report.h"
#include "servo.h"
#include "sweep.h"
#include "uart.h"

static uint8_t reset_cause(void) {
  uint8_t flags = MCUCSR;
  MCUCSR = 0;
  if (flags & (1 << WDRF)) return CAUSE_WATCHDOG;
  if (flags & (1 << BORF)) return CAUSE_BROWN_OUT;
  if (flags & (1 << EXTRF)) return CAUSE_EXTERNAL;
  return CAUSE_POWER_ON;
}

/* 5.5 V behind the divider: the least that the manual allows. */
#define BATTERY_LOW 563

static uint8_t state_bits(uint8_t was_silenced) {
  uint8_t state = 0;
  if (PINB & (1 << BUMPER_LEFT_PIN)) state |= STATE_BUMPER_LEFT;
  if (PINC & (1 << BUMPER_RIGHT_PIN)) state |= STATE_BUMPER_RIGHT;
  if (drive_is_moving()) state |= STATE_MOVING;
  if (sweep_is_under_way()) state |= STATE_SWEEPING;
  if (motor_is_latched()) state |= STATE_LATCHED;
  if (was_silenced) state |= STATE_SILENT;
  return state;
}

static void send_telemetry(uint32_t now, uint8_t was_silenced) {
  telemetry_t t = {
      .time_ms = now,
      .counts = {drive_counts(LEFT), drive_counts(RIGHT)},
      .speeds = {drive_speed(LEFT), drive_speed(RIGHT)},
      .currents = {analog_read(ADC_CURRENT_LEFT), analog_read(ADC_CURRENT_RIGHT)},
      .battery = analog_read(ADC_BATTERY),
      .state = state_bits(was_silenced),
      .fault = drive_fault(),
  };
  if (t.fault == FAULT_NONE && t.battery < BATTERY_LOW) t.fault = FAULT_BATTERY_LOW;
  report_telemetry(&t);
}

/* Once in a period. Returns whether silence has stopped the robot; a command that comes clears
   that. */
static uint8_t control(uint8_t was_silenced) {
  uint8_t is_silent = guard_is_silent();
  if (is_silent && drive_is_driven()) {
    drive_abort();
    was_silenced = 1;
  }
  drive_step();
  return was_silenced && is_silent;
}

int main(void) {
  uint8_t cause = reset_cause();
  wdt_enable(WDTO_120MS);
  PORTD &= ~(1 << IR_LED_PIN);
  DDRD |= 1 << IR_LED_PIN;
  motor_init();
  encoder_init();
  analog_init();
  servo_init();
  uart_init();
  clock_init();
  controller_rest();
  sei();
  report_hello(0, cause);

  uint32_t last_ms = 0, controlled_ms = 0, told_ms = 0;
  uint8_t was_silenced = 0;
  frame_t frame;
  for (;;) {
    uint8_t byte;
    while (uart_read(&byte)) {
      if (frame_push(byte, &frame)) command_take(&frame, cause);
    }
    uint32_t now = clock_ms();
    if (now == last_ms) continue;
    last_ms = now;
    sweep_step(now);
    if (now - controlled_ms >= PERIOD_MS) {
      controlled_ms += PERIOD_MS;
      was_silenced = control(was_silenced);
      wdt_reset(); /* only here: a loop that no longer controls is one that hangs */
    }
    if (now - told_ms >= command_telemetry_period()) {
      told_ms = now;
      send_telemetry(now, was_silenced);
    }
  }
}
