// Rooms and corridors of the map as a list: what each is, its area, and its doors with where they
// lead.

import { css, html, nothing, type TemplateResult } from "lit";
import { DOORWAY, DOORWAY_STRIDE, REGION, REGION_STRIDE, type Rooms } from "../protocol/module.js";
import type { Topic } from "../store.js";
import { roomAt } from "../view/layers/rooms.js";
import { SlamElement } from "./element.js";
import { fixed } from "./format.js";
import { shared } from "./style.js";

interface Doorway {
  leadsTo: number;
  width: number;
  framed: boolean;
}

export class SlamRooms extends SlamElement {
  static override styles = [
    shared,
    css`
      :host { display: block; }
      h2 { margin: 18px 0 8px; }
      p { margin: 0 0 8px; font-size: 12.5px; color: var(--muted); }
      ul { list-style: none; margin: 0; padding: 0; max-height: 264px; overflow-y: auto; scrollbar-width: thin; }
      li > button { width: 100%; justify-content: space-between; border-color: transparent; background: transparent; font-weight: 400; font-size: 13px; padding: 0 8px; min-height: 30px; }
      li > button:hover { background: var(--hover); }
      li > button[aria-expanded="true"] { background: var(--sunk); border-color: var(--line-strong); }
      dl { margin: 4px 0 10px; padding: 0 8px 0 16px; font-size: 12.5px; }
      dl div { display: flex; justify-content: space-between; gap: 8px; padding: 2px 0; }
      dt { color: var(--muted); }
      dd { margin: 0; text-align: right; flex: none; }
      @media (pointer: coarse) { li > button { min-height: 44px; } }
    `,
  ];

  protected override readonly topics: readonly Topic[] = ["rooms", "view"];

  override render(): TemplateResult | typeof nothing {
    const { rooms, roomNumbers, roomSpot, layers } = this.store;
    if (!layers.rooms) return nothing;
    const count = rooms ? rooms.regions.length / REGION_STRIDE : 0;
    const byNumber = Array.from({ length: count }, (_, room) => room).sort((a, b) => (roomNumbers[a] ?? 0) - (roomNumbers[b] ?? 0));
    const chosen = rooms && roomSpot ? roomAt(rooms, ...roomSpot) : null;
    return html`
      <h2 id="rooms">Rooms</h2>
      <p data-testid="rooms-summary">${rooms && count > 0
        ? `${counted(count, "region")} and ${counted(rooms.doors.length / DOORWAY_STRIDE, "door")} in the map so far.`
        : "No room is found yet: let the robot scan."}</p>
      ${rooms ? html`<ul aria-labelledby="rooms">${byNumber.map((room) => this.#item(rooms, room, room === chosen))}</ul>` : nothing}
    `;
  }

  #nameOf({ regions }: Rooms, room: number): string {
    return `${regions[room * REGION_STRIDE + REGION.kind] === 1 ? "Corridor" : "Room"} ${this.store.roomNumbers[room]}`;
  }

  #item(rooms: Rooms, room: number, isChosen: boolean): TemplateResult {
    const at = (place: number): number => rooms.regions[room * REGION_STRIDE + place] ?? NaN;
    return html`<li>
      <button data-testid="room-${room}" aria-expanded=${isChosen} @click=${() => this.store.set("rooms", { roomSpot: isChosen ? null : [at(REGION.x), at(REGION.y)] })}>
        <span>${this.#nameOf(rooms, room)}</span><span class="num muted">${fixed(at(REGION.area), 1)} m²</span></button>
      ${isChosen ? html`<dl data-testid="room-details">
        <div><dt>Kind</dt><dd>${at(REGION.kind) === 1 ? "corridor: much longer than wide" : "room"}</dd></div>
        <div><dt>Free floor</dt><dd class="num">${fixed(at(REGION.area), 1)} m²</dd></div>
        <div><dt>Width between its walls</dt><dd class="num">${fixed(at(REGION.width), 2)} m</dd></div>
        ${doorsOf(rooms, room).map(({ leadsTo, width, framed }) => html`<div>
          <dt>Door to ${this.#nameOf(rooms, leadsTo).toLowerCase()}${framed ? "" : ", one post not seen yet"}</dt><dd class="num">${framed ? "" : "about "}${Math.round(100 * width)} cm</dd></div>`)}
      </dl>` : nothing}
    </li>`;
  }
}

function counted(count: number, what: string): string {
  return `${count} ${what}${count === 1 ? "" : "s"}`;
}

function doorsOf({ doors }: Rooms, room: number): Doorway[] {
  const found: Doorway[] = [];
  for (let i = 0; i + DOORWAY_STRIDE <= doors.length; i += DOORWAY_STRIDE) {
    const [from, to] = [doors[i + DOORWAY.from], doors[i + DOORWAY.to]];
    if (from !== room && to !== room) continue;
    found.push({ leadsTo: (from === room ? to : from) ?? NaN, width: doors[i + DOORWAY.width] ?? NaN, framed: doors[i + DOORWAY.framed] === 1 });
  }
  return found;
}

customElements.define("slam-rooms", SlamRooms);
