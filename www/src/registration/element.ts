// The base of every component of the lab: the common style, and rendering whenever the model
// changes.

import { type CSSResultGroup, type CSSResultOrNative, LitElement, type PropertyDeclarations } from "lit";
import { shared } from "../ui/style.js";
import type { LabModel } from "./model.js";

export abstract class LabElement extends LitElement {
  /** Set by the creator of the element. */
  static override properties: PropertyDeclarations = { model: { attribute: false } };
  declare model: LabModel;

  #leave: (() => void) | null = null;
  readonly #resized = new ResizeObserver(() => this.requestUpdate());
  #isDark = matchMedia("(prefers-color-scheme: dark)");

  protected static override finalizeStyles(own: CSSResultGroup = []): CSSResultOrNative[] {
    return super.finalizeStyles([shared, own]);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.#leave = this.model.on(() => this.requestUpdate());
    this.#resized.observe(this);
    this.#isDark.addEventListener("change", this.#again);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.#leave?.();
    this.#resized.disconnect();
    this.#isDark.removeEventListener("change", this.#again);
  }

  readonly #again = (): void => this.requestUpdate();
}
