// What every component starts from: the store, the client, and the topics that make it render
// again.

import { LitElement } from "lit";
import type { Client } from "../client.js";
import { Listening, type Store, type Topic } from "../store.js";

export abstract class SlamElement extends LitElement {
  /** Set by main.ts before the element is connected. */
  store!: Store;
  client!: Client;

  protected abstract readonly topics: readonly Topic[];

  override connectedCallback(): void {
    super.connectedCallback();
    if (!this.#listening) this.#listening = new Listening(this, this.store, ...this.topics);
  }

  #listening: Listening | null = null;

  /** After a click with the mouse the keys belong to the robot again, not to the button. */
  protected giveBackFocus(event: Event): void {
    if (event instanceof PointerEvent && event.detail > 0) this.dispatchEvent(new CustomEvent("focus-map", { bubbles: true, composed: true }));
  }
}
