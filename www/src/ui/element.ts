// The base of every component: the common style, the store, the client, and the topics on which it
// renders again.

import { type CSSResultGroup, type CSSResultOrNative, LitElement } from "lit";
import type { Client } from "../client.js";
import { LANGUAGE_CHANGED } from "../spoken.js";
import type { Store, Topic } from "../store.js";
import type { Scene } from "../view/scene.js";
import { inTurn } from "./in_turn.js";
import { shared } from "./style.js";

/** While a run plays, a component that is scrolled out of sight shows new figures this often,
    milliseconds: whoever listens to the page may still read it. */
const UNSEEN_MILLIS = 1000;

const outOfSight = new WeakSet<Element>();
let sight: IntersectionObserver | null = null;

function look(entries: readonly IntersectionObserverEntry[]): void {
  for (const { target, isIntersecting, boundingClientRect: { width, height } } of entries) {
    // What has no box of its own may have parts that are seen.
    const isSeen = isIntersecting || width * height === 0;
    if (isSeen && outOfSight.delete(target)) (target as SlamElement).requestUpdate();
    if (!isSeen) outOfSight.add(target);
  }
}

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
    for (const topic of this.topics) this.store.on(topic, () => (topic === "frame" && this.store.playing ? this.#renderInTurn() : this.requestUpdate()));
    if (this.topics.includes("frame")) (sight ??= new IntersectionObserver(look)).observe(this);
    addEventListener(LANGUAGE_CHANGED, () => this.requestUpdate());
  }

  #turnAt = -Infinity;

  #renderInTurn(): void {
    const now = performance.now();
    if (outOfSight.has(this) && now - this.#turnAt < UNSEEN_MILLIS) return;
    this.#turnAt = now;
    inTurn(this, () => this.requestUpdate());
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
