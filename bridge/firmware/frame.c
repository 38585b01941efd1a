#include "frame.h"

#include <util/crc16.h>

#include "uart.h"

/* CRC-16/MCRF4XX: start FFFF, reflected polynomial 8408: what avr-libc computes as
   _crc_ccitt_update. */
static uint16_t checksum(const uint8_t *bytes, uint8_t length) {
  uint16_t crc = 0xFFFF;
  for (uint8_t i = 0; i < length; i++) crc = _crc_ccitt_update(crc, bytes[i]);
  return crc;
}

/* COBS: a byte tells how far it is to the next zero, and stands in its place. Takes that out
 * again, in place; returns the length, or 0 where a step leads beyond the end. */
static uint8_t unstuff(uint8_t *bytes, uint8_t length) {
  uint8_t from = 0, to = 0;
  while (from < length) {
    uint8_t step = bytes[from++];
    if (step == 0 || step - 1 > length - from) return 0;
    for (uint8_t i = 1; i < step; i++) bytes[to++] = bytes[from++];
    if (from < length) bytes[to++] = 0;
  }
  return to;
}

uint8_t frame_push(uint8_t byte, frame_t *frame) {
  static uint8_t piece[LONGEST_TO_ROBOT];
  static uint8_t length;
  static uint8_t is_overlong;
  if (byte != 0) {
    if (length < LONGEST_TO_ROBOT - 2) {
      piece[length++] = byte;
    } else {
      is_overlong = 1;
    }
    return 0;
  }
  uint8_t content = is_overlong ? 0 : unstuff(piece, length);
  length = 0;
  is_overlong = 0;
  if (content < 4) return 0;
  content -= 2;
  uint16_t crc = piece[content] | (uint16_t)piece[content + 1] << 8;
  if (checksum(piece, content) != crc) return 0;
  frame->length = content;
  for (uint8_t i = 0; i < content; i++) frame->bytes[i] = piece[i];
  return 1;
}

uint8_t frame_send(uint8_t kind, const uint8_t *payload, uint8_t length) {
  static uint8_t sequence;
  uint8_t message[LONGEST_PAYLOAD + 4];
  uint8_t stuffed[LONGEST_PAYLOAD + 7];
  message[0] = kind;
  message[1] = sequence;
  for (uint8_t i = 0; i < length; i++) message[2 + i] = payload[i];
  uint8_t end = length + 2;
  uint16_t crc = checksum(message, end);
  message[end++] = crc;
  message[end++] = crc >> 8;

  stuffed[0] = 0;
  uint8_t code = 1; /* where the distance to the next zero will stand */
  uint8_t to = 2;
  for (uint8_t i = 0; i < end; i++) {
    if (message[i] == 0) {
      stuffed[code] = to - code;
      code = to++;
    } else {
      stuffed[to++] = message[i];
    }
  }
  stuffed[code] = to - code;
  stuffed[to++] = 0;
  if (!uart_write(stuffed, to)) return 0;
  sequence++;
  return 1;
}
