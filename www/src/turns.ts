// Long work in slices, called turns: between them a worker handles its messages.

export class Turns {
  readonly #channel = new MessageChannel();
  /** A turn is queued in the channel already: one is enough. */
  #isDue = false;

  constructor(turn: () => void) {
    this.#channel.port1.onmessage = () => {
      this.#isDue = false;
      turn();
    };
  }

  /** Takes another turn after all messages in the queue. */
  wake(): void {
    if (this.#isDue) return;
    this.#isDue = true;
    this.#channel.port2.postMessage(null);
  }
}
