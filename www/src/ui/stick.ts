// A joystick for the thumb: up is forward, left turns left. Letting go stops the robot.

import { css, type TemplateResult } from "lit";
import { html } from "../words.js";
import { SlamElement } from "./element.js";

/** Dead zone, as part of the radius. */
const DEAD = 0.12;

export class SlamStick extends SlamElement {
  static override styles = css`
    :host { display: none; }
    :host([shown]) { display: block; }
    #base { width: 128px; height: 128px; border-radius: 50%; background: var(--glass); border: 1.5px solid var(--line-strong); touch-action: none; position: relative; cursor: grab; box-shadow: var(--shadow); }
    #base::before { content: ""; position: absolute; inset: 14px; border-radius: 50%; border: 1px dashed var(--line-strong); }
    #knob { position: absolute; left: 50%; top: 50%; width: 56px; height: 56px; margin: -28px; border-radius: 50%; background: var(--accent); box-shadow: 0 3px 10px #0006; pointer-events: none; }
  `;

  protected override readonly topics = ["frame", "run"] as const;
  #pointer: number | null = null;

  override render(): TemplateResult {
    const { status, source, aiming } = this.store;
    this.toggleAttribute("shown", (source === "sim" || (source === "bridge" && this.store.bridge?.armed === true)) && status?.mode === "manual" && !aiming);
    return html`<div id="base" data-testid="stick" role="img" aria-label="Driving stick; the arrow keys do the same"
      @pointerdown=${this.#down} @pointermove=${this.#move} @pointerup=${this.#up} @pointercancel=${this.#up}><div id="knob"></div></div>`;
  }

  #down(event: PointerEvent): void {
    this.#pointer = event.pointerId;
    (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
    this.#move(event);
  }

  #move(event: PointerEvent): void {
    if (event.pointerId !== this.#pointer) return;
    const box = (event.currentTarget as HTMLElement).getBoundingClientRect();
    const radius = box.width / 2;
    let x = (event.clientX - box.left - radius) / radius;
    let y = (event.clientY - box.top - radius) / radius;
    const size = Math.hypot(x, y);
    if (size > 1) [x, y] = [x / size, y / size];
    this.#place(x, y);
    const soft = (v: number): number => (Math.abs(v) < DEAD ? 0 : (v - Math.sign(v) * DEAD) / (1 - DEAD));
    this.client.drive(soft(-y), soft(-x));
  }

  #up(event: PointerEvent): void {
    if (event.pointerId !== this.#pointer) return;
    this.#pointer = null;
    this.#place(0, 0);
    this.client.drive(0, 0);
  }

  #place(x: number, y: number): void {
    this.renderRoot.querySelector<HTMLElement>("#knob")?.style.setProperty("translate", `${x * 42}px ${y * 42}px`);
  }
}

customElements.define("slam-stick", SlamStick);
