// The base of every component: the common style, the store, the client, and the topics on which it
// renders again.

import { type CSSResultGroup, type CSSResultOrNative, LitElement } from "lit";
import type { Client } from "../client.js";
import { LANGUAGE_CHANGED } from "../spoken.js";
import type { Store, Topic } from "../store.js";
import type { Scene } from "../view/scene.js";
import { inTurn } from "./in_turn.js";
import { shared } from "./style.js";

/** A component; it exists as long as the page. */
export abstract class SlamElement extends LitElement {
  /** Set by main.ts before the element is connected. */
  store!: Store;
  scene!: Scene;
  client!: Client;

  protected readonly topics: readonly Topic[] = [];

  protected static override finalizeStyles(own: CSSResultGroup = []): CSSResultOrNative[] {
    return super.finalizeStyles([shared, own]);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    for (const topic of this.topics) this.store.on(topic, () => (topic === "frame" && this.store.playing ? inTurn(this, () => this.requestUpdate()) : this.requestUpdate()));
    addEventListener(LANGUAGE_CHANGED, () => this.requestUpdate());
  }

  /** The handler of a button. After a click with the mouse, keys control the robot again, not the
      button. */
  protected press(act: () => void): (event: Event) => void {
    return (event) => {
      act();
      if (event instanceof PointerEvent && event.detail > 0) this.dispatchEvent(new CustomEvent("focus-map", { bubbles: true, composed: true }));
    };
  }
}
