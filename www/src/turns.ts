// Long work in slices: between its turns a worker hears what it is sent.

export class Turns {
  readonly #channel = new MessageChannel();
  /** A turn waits in the channel: one is enough. */
  #isDue = false;

  constructor(turn: () => void) {
    this.#channel.port1.onmessage = () => {
      this.#isDue = false;
      turn();
    };
  }

  /** Another turn is taken once all that waits has been heard. */
  wake(): void {
    if (this.#isDue) return;
    this.#isDue = true;
    this.#channel.port2.postMessage(null);
  }
}
