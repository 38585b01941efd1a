// The inspector: a card about what was pointed at on the map. It is a bundle of its own.
//
// During a run its numbers are updated, at most once a second. The run is asked only for what
// frames do not contain, and only while that is shown.

import { css, nothing, type PropertyValues, type TemplateResult } from "lit";
import { card } from "../ui/card.js";
import { SlamElement } from "../ui/element.js";
import { figure, figures } from "../ui/figures.js";
import { icons } from "../ui/icons.js";
import { DOOR, DOOR_STRIDE } from "../protocol/module.js";
import type { Question } from "../protocol.js";
import { isTouched } from "../screen.js";
import type { Thing } from "../view/things.js";
import { html } from "../words.js";
import { beam } from "./beam.js";
import { cell } from "./cell.js";
import { closure, join } from "./constraints.js";
import { line } from "./line.js";
import { frontier, submap, torn, truth } from "./places.js";
import { hypothesis, particles, point, robot, track } from "./poses.js";
import { door, doorway, edit, room } from "./rooms.js";
import type { Formula, Known, Told } from "./told.js";

/** How often the run is asked again, wall milliseconds. */
const AGAIN_MILLIS = 1000;

/** What is shown about each kind of thing. */
const TELL: { readonly [Kind in Thing["kind"]]: (thing: Extract<Thing, { kind: Kind }>, known: Known) => Told } = {
  torn: ({ tear }) => torn(tear),
  closure: ({ name }, known) => closure(name, known),
  join: ({ submap: later }, known) => join(later, known),
  robot: (_, known) => robot(known),
  track: ({ id }, known) => track(id, known),
  point: ({ id }, known) => point(id, known),
  line: ({ id }, known) => line(id, known),
  hypothesis: ({ x, y }, known) => hypothesis(x, y, known),
  particles: (_, known) => particles(known),
  frontier: ({ x, y }, known) => frontier(x, y, known),
  cell: ({ x, y }, known) => cell(x, y, known),
  submap: ({ number }, known) => submap(number, known),
  truth: ({ row }, known) => truth(row, known),
  beam: ({ number }, known) => beam(number, known),
  door: ({ number }, known) => door(number, known),
  doorway: ({ posts }, known) => doorway(posts, known),
  room: ({ x, y }, known) => room(x, y, known),
  edit: ({ number }, known) => edit(number, known),
};

export class SlamInspector extends SlamElement {
  static override styles = [
    figures,
    card,
    css`
      section { width: min(360px, calc(100vw - 16px)); max-height: calc(100dvh - 54px - 14px - 170px); margin-bottom: 8px; overflow-y: auto; scrollbar-width: thin; padding-top: 0; }
      header { position: sticky; top: 0; z-index: 1; margin: 0 -14px 4px; padding: 10px 14px 6px; background: var(--raised); }
      header b { line-height: 1.25; }
      .fate { display: block; font-size: 12.5px; font-weight: 500; color: var(--muted); }
      header .icon { flex: none; }
      h3 { margin: 12px 0 4px; font: 600 13px/1.3 var(--sans); }
      h4 { margin: 0 0 2px; font: 500 13px/1.4 var(--sans); }
      ul { margin: 0 0 8px; padding-left: 18px; font-size: 13px; line-height: 1.5; }
      .formula { margin: 10px 0 0; padding: 8px 10px; border-radius: 10px; background: var(--sunk); overflow-x: auto; }
      .formula math { font-size: 15px; margin: 0 0 8px; }
      .formula small { display: block; color: var(--muted); font-size: 12px; line-height: 1.4; }
      .hint { margin: 10px 0 0; font-size: 12px; color: var(--muted); }
      .step { display: inline-flex; align-items: center; gap: 4px; font-size: 12.5px; color: var(--muted); }
      @media (max-width: 760px) { section { width: auto; margin: 0; max-height: 36dvh; } }
      @media (pointer: coarse) { header .icon { margin: -4px 0; } header .close { margin-right: -8px; } }
    `,
  ];

  protected override readonly topics = ["chosen", "frame", "view", "run", "submaps", "quality"] as const;
  #asked: Thing | null = null;
  #askedAt = -Infinity;

  protected override willUpdate(changed: PropertyValues): void {
    super.willUpdate(changed);
    const { thing, playing } = this.store;
    if (!thing) {
      this.#asked = null;
      return;
    }
    const now = performance.now();
    const isDue = thing !== this.#asked || (playing && now - this.#askedAt >= AGAIN_MILLIS);
    if (!isDue) return;
    [this.#asked, this.#askedAt] = [thing, now];
    const question = this.#questionOf(thing);
    if (question) this.client.examine(question);
  }

  /** The question for the run about it; null if frames contain everything. */
  #questionOf(thing: Thing): Question | null {
    switch (thing.kind) {
      case "cell": case "frontier": return { x: thing.x, y: thing.y };
      case "line": return { x: 0, y: 0, wall: true };
      case "beam": return { x: 0, y: 0, beam: thing.number };
      case "doorway": return { x: 0, y: 0, leaf: thing.posts };
      case "door": return { x: 0, y: 0, leaf: [...this.scene.doors.subarray(thing.number * DOOR_STRIDE + DOOR.x1, thing.number * DOOR_STRIDE + DOOR.y2 + 1)] };
      default: return null;
    }
  }

  override render(): TemplateResult | typeof nothing {
    const { store } = this;
    const { thing, chosen } = store;
    if (!thing || !chosen || this.#isHidden(thing)) return nothing;
    const told = this.#tell(thing);
    const count = chosen.things.length;
    return html`<section aria-label="Inspector" data-testid="inspector"><div data-testid=${thing.kind}>
      <header><b><span data-testid="${thing.kind}-title">${told.title}</span>${told.fate ? html`<span class="fate" data-testid="${thing.kind}-${thing.kind === "join" ? "kind" : "fate"}">${told.fate}</span>` : nothing}</b>
        ${count > 1 ? html`<span class="step"><button class="icon" aria-label="What lies above it" data-testid="inspect-previous" @click=${() => this.#step(-1)}>${icons.back}</button><span aria-live="polite" data-testid="inspect-step">${chosen.at + 1} of ${count}</span><button class="icon" aria-label="What lies under it" data-testid="inspect-next" @click=${() => this.#step(1)}>${icons.step}</button></span>` : nothing}
        <button class="icon close" aria-label="Close" title="Close (Esc)" @click=${() => this.#close()}>${icons.close}</button></header>
      ${told.words ? html`<p data-testid="${thing.kind}-why">${told.words}</p>` : nothing}
      <dl>${told.figures.map(([name, value, id, meaning = ""]) => figure(name, value, id, meaning, "wide"))}</dl>
      ${(told.formulas ?? []).map((each) => this.#formula(each))}
      ${told.more ?? nothing}
      ${store.inspecting ? html`<p class="hint">${HINT}</p>` : nothing}
    </div></section>`;
  }

  protected override updated(changed: PropertyValues): void {
    super.updated(changed);
    const { thing } = this.store;
    // The map draws it in its next frame.
    const outline = thing && !this.#isHidden(thing) ? this.#tell(thing).outline : [];
    if (JSON.stringify(outline) !== JSON.stringify(this.store.outline)) this.store.set("spot", { outline });
  }

  #tell(thing: Thing): Told {
    const { store, scene } = this;
    const tell = TELL[thing.kind] as (thing: Thing, known: Known) => Told;
    return tell(thing, { store, scene, examined: store.examined });
  }

  /** Things that are not drawn are not described. */
  #isHidden({ kind }: Thing): boolean {
    const { layers } = this.store;
    const layer = ({ closure: "closures", join: "graph", torn: "torn", truth: "truth", door: "truth", doorway: "rooms", room: "rooms", beam: "scan" } as const)[kind as "closure"];
    return layer !== undefined && !layers[layer];
  }

  #formula({ general, numbers, source }: Formula): TemplateResult {
    return html`<div class="formula" data-testid="formula">${general}${numbers}<small>${source}</small></div>`;
  }

  #step(by: number): void {
    const { chosen } = this.store;
    if (chosen) this.store.choose(chosen.things, (chosen.at + by + chosen.things.length) % chosen.things.length);
  }

  #close(): void {
    this.store.choose([]);
    dispatchEvent(new Event("focus-map"));
  }
}

const HINT = isTouched()
  ? "Tap anything on the map; tap again for what lies under it. The robot is not sent anywhere."
  : "Click anything on the map, or Enter at its cross; again for what lies under it. The robot is not sent anywhere.";

customElements.define("slam-inspector", SlamInspector);
