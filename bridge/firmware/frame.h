/* Frames: 00 | COBS( kind, sequence, payload, CRC low, CRC high ) | 00. The table of the
 * messages stands in core/src/wire/rp6/mod.rs; the host has the very same bytes from there. */
#ifndef FRAME_H
#define FRAME_H

#include <stdint.h>

#define LONGEST_TO_ROBOT 31 /* markers included */
#define LONGEST_PAYLOAD 56  /* of a report */

/* A frame that came: bytes[0] is the kind, bytes[1] the sequence, the payload follows. */
typedef struct {
  uint8_t length; /* of kind, sequence and payload */
  uint8_t bytes[LONGEST_TO_ROBOT];
} frame_t;

/* Takes one byte from the line; returns whether it completed a good frame. */
uint8_t frame_push(uint8_t byte, frame_t *frame);

/* Sends a report under the next sequence; returns whether there was room for it. */
uint8_t frame_send(uint8_t kind, const uint8_t *payload, uint8_t length);

#endif
