// A list of the rooms and corridors of the map: kind, area, and doors with the regions that they
// lead to.

import { css, nothing, type TemplateResult } from "lit";
import type { Rooms } from "../protocol/module.js";
import { roomAt } from "../view/things.js";
import { html, t } from "../words.js";
import { SlamElement } from "./element.js";
import { fixed } from "./format.js";

export class SlamRooms extends SlamElement {
  static override styles = css`
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
  `;

  protected override readonly topics = ["rooms", "view"] as const;

  override render(): TemplateResult | typeof nothing {
    const { rooms, roomNumbers, roomSpot, layers } = this.store;
    if (!layers.rooms) return nothing;
    const count = rooms?.regions.length ?? 0;
    const byNumber = roomNumbers.slice(0, count).map((number, room) => ({ number, room })).sort((a, b) => a.number - b.number);
    const chosen = rooms && roomSpot ? roomAt(rooms, ...roomSpot) : null;
    return html`
      <h2 id="rooms">Rooms</h2>
      <p data-testid="rooms-summary">${rooms && count > 0
        ? t`${regions(count)} and ${doors(rooms.doors.length)} in the map so far.`
        : "No room is found yet: let the robot scan."}</p>
      ${rooms ? html`<ul aria-labelledby="rooms">${byNumber.map(({ room }) => this.#item(rooms, room, room === chosen))}</ul>` : nothing}
    `;
  }

  #nameOf({ regions }: Rooms, room: number): string {
    const number = this.store.roomNumbers[room];
    return regions[room]?.kind === "corridor" ? t`Corridor ${number}` : t`Room ${number}`;
  }

  #doorTo(rooms: Rooms, room: number, framed: boolean): string {
    const name = this.#nameOf(rooms, room).toLowerCase();
    return framed ? t`Door to ${name}` : t`Door to ${name}, one post not seen yet`;
  }

  #item(rooms: Rooms, room: number, isChosen: boolean): TemplateResult | typeof nothing {
    const region = rooms.regions[room];
    if (!region) return nothing;
    const { kind, area, middle, width } = region;
    return html`<li>
      <button data-testid="room-${room}" aria-expanded=${isChosen} @click=${() => this.store.set("rooms", { roomSpot: isChosen ? null : middle })}>
        <span>${this.#nameOf(rooms, room)}</span><span class="num muted">${fixed(area, 1)} m²</span></button>
      ${isChosen ? html`<dl data-testid="room-details">
        <div><dt>Kind</dt><dd>${kind === "corridor" ? "corridor: much longer than wide" : "room"}</dd></div>
        <div><dt>Free floor</dt><dd class="num">${fixed(area, 1)} m²</dd></div>
        <div><dt>Width between its walls</dt><dd class="num">${fixed(width, 2)} m</dd></div>
        ${rooms.doors.filter(({ regions }) => regions.includes(room)).map(({ regions: [from, to], width, framed }) => html`<div>
          <dt>${this.#doorTo(rooms, from === room ? to : from, framed)}</dt><dd class="num">${framed ? "" : "≈ "}${Math.round(100 * width)} cm</dd></div>`)}
      </dl>` : nothing}
    </li>`;
  }
}

const regions = (count: number): string => (count === 1 ? t`${count} region` : t`${count} regions`);
const doors = (count: number): string => (count === 1 ? t`${count} door` : t`${count} doors`);

customElements.define("slam-rooms", SlamRooms);
