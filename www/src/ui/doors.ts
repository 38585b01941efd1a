// The doors of the simulated world: a button for each, and one for all of them.

import { css, nothing, type TemplateResult } from "lit";
import { DOOR, DOOR_STRIDE } from "../protocol/module.js";
import { html, t } from "../words.js";
import { SlamElement } from "./element.js";

/** Most doors that get a button of their own; others can be clicked on the map. */
const MOST_BUTTONS = 12;

interface Door {
  open: boolean;
  /** Whether the door is ordered to be open. */
  ordered: boolean;
}

export class SlamDoors extends SlamElement {
  static override styles = css`
    h2 { margin: 16px 0 10px; }
    div { display: flex; flex-wrap: wrap; gap: 6px; }
    button[aria-pressed="true"] { border-color: var(--map-door); }
    p { margin: 8px 0 0; font-size: 12.5px; }
  `;

  protected override readonly topics = ["doors", "run"] as const;

  override render(): TemplateResult | typeof nothing {
    const doors = this.#doors();
    if (this.store.source !== "sim" || doors.length === 0) return nothing;
    const shut = doors.filter((door) => !door.ordered).length;
    const all = shut < doors.length;
    return html`
      <h2 id="doors">Doors</h2>
      <div role="group" aria-labelledby="doors">
        ${doors.slice(0, MOST_BUTTONS).map((door, i) => html`<button data-testid="door-${i}" aria-pressed=${door.ordered} title=${wordsOf(door)}
          @click=${() => this.client.setDoor(i, !door.ordered)}>${i + 1}: ${t(door.ordered ? "open" : "shut")}${door.open === door.ordered ? "" : "…"}</button>`)}
        ${doors.length > 1 ? html`<button data-testid="doors-all" @click=${() => doors.forEach((_, i) => this.client.setDoor(i, !all))}>${all ? "Shut all" : "Open all"}</button>` : nothing}
      </div>
      <p class="muted">${doors.length > MOST_BUTTONS ? `${t`The other ${doors.length - MOST_BUTTONS} by a click on the map.`} ` : ""}A click on a door in the map does the same. The robot does not know of it.</p>
    `;
  }

  #doors(): Door[] {
    const { doors } = this.store;
    const flag = (i: number, place: number): boolean => doors[i * DOOR_STRIDE + place] === 1;
    return Array.from({ length: doors.length / DOOR_STRIDE }, (_, i) => ({ open: flag(i, DOOR.open), ordered: flag(i, DOOR.ordered) }));
  }
}

function wordsOf({ open, ordered }: Door): string {
  if (open && !ordered) return "Shuts as soon as nobody stands in it";
  return ordered ? "Shut this door" : "Open this door";
}

customElements.define("slam-doors", SlamDoors);
