/* What hangs on which pin of the RP6's ATmega32 (8 MHz).
 *
 * Facts of the RP6 Robot Base manual and schematic:
 *
 *   PA7 ADC7  battery, divided by two        PD5 OC1A  right motor, pulse width
 *   PA6 ADC6  current of the left motor      PD4 OC1B  left motor, pulse width
 *   PA5 ADC5  current of the right motor     PC3       right motor, direction (1 is backwards)
 *   PA1 ADC1  free: here the servo           PC2       left motor, direction
 *   PA0 ADC0  free: here the multiplexer     PD3 INT1  right encoder
 *   PB4       power of encoders, current     PD2 INT0  left encoder
 *             sensors, infra-red receiver    PD1, PD0  serial line
 *   PB0       left bumper (and LED 6)        PC6       right bumper (and LED 3)
 *   PC4, PC5  LEDs 1 and 2: here the two select lines of the multiplexer
 *   PD7       infra-red LEDs: must never be left on, so it stays an output at 0
 */
#ifndef BOARD_H
#define BOARD_H

#include <avr/io.h>

#define F_CPU_HZ 8000000UL

#define ADC_RANGERS 0
#define ADC_CURRENT_RIGHT 5
#define ADC_CURRENT_LEFT 6
#define ADC_BATTERY 7

#define SERVO_PIN PA1        /* port A */
#define BUMPER_LEFT_PIN PB0  /* port B, high when pressed */
#define SENSOR_POWER_PIN PB4 /* port B */
#define DIRECTION_LEFT_PIN PC2
#define DIRECTION_RIGHT_PIN PC3
#define SELECT_SHIFT PC4 /* select lines: PC4 low bit, PC5 high bit */
#define BUMPER_RIGHT_PIN PC6
#define ENCODER_LEFT_PIN PD2
#define ENCODER_RIGHT_PIN PD3
#define PWM_LEFT_PIN PD4
#define PWM_RIGHT_PIN PD5
#define IR_LED_PIN PD7

#define LEFT 0
#define RIGHT 1

#endif
