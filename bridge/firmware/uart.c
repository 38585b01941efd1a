#include "uart.h"

#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"

/* Powers of two, so that an index wraps by a mask. */
#define RECEIVE_SIZE 64
#define SEND_SIZE 128

static volatile uint8_t received[RECEIVE_SIZE];
static volatile uint8_t received_head, received_tail;
static volatile uint8_t to_send[SEND_SIZE];
static volatile uint8_t send_head, send_tail;

void uart_init(void) {
  /* 8 MHz / 16 / 13 = 38462 baud: 0.16 % fast, far within what a receiver bears. */
  UBRRH = 0;
  UBRRL = 12;
  UCSRC = (1 << URSEL) | (1 << UCSZ1) | (1 << UCSZ0);
  UCSRB = (1 << RXCIE) | (1 << RXEN) | (1 << TXEN);
}

ISR(USART_RXC_vect) {
  uint8_t byte = UDR;
  uint8_t next = (received_head + 1) & (RECEIVE_SIZE - 1);
  /* A byte too many is dropped; the checksum of its frame will tell. */
  if (next != received_tail) {
    received[received_head] = byte;
    received_head = next;
  }
}

ISR(USART_UDRE_vect) {
  if (send_tail == send_head) {
    UCSRB &= ~(1 << UDRIE); /* nothing left: this interrupt would come for ever */
    return;
  }
  UDR = to_send[send_tail];
  send_tail = (send_tail + 1) & (SEND_SIZE - 1);
}

uint8_t uart_read(uint8_t *byte) {
  if (received_tail == received_head) return 0;
  *byte = received[received_tail];
  received_tail = (received_tail + 1) & (RECEIVE_SIZE - 1);
  return 1;
}

uint8_t uart_write(const uint8_t *bytes, uint8_t length) {
  uint8_t used = (send_head - send_tail) & (SEND_SIZE - 1);
  if (length > SEND_SIZE - 1 - used) return 0;
  uint8_t head = send_head;
  for (uint8_t i = 0; i < length; i++) {
    to_send[head] = bytes[i];
    head = (head + 1) & (SEND_SIZE - 1);
  }
  send_head = head;
  /* One instruction (sbi) on this register, so the interrupt cannot come in between. */
  UCSRB |= 1 << UDRIE;
  return 1;
}
