// Every layer with its symbol, its meaning, and a switch; the order of the layers; and what draws
// the map.

import { css, nothing, type TemplateResult } from "lit";
import { repeat } from "lit/directives/repeat.js";
import { needsPriorMap } from "../protocol/methods.js";
import { chooseDrawing, chosenDrawing, type Drawing } from "../view/graphics.js";
import { isOfPlan } from "../view/parts.js";
import { LAYERS, type LayerName, type Scene } from "../view/scene.js";
import type { GridView } from "../view/tiles.js";
import { html, svg, t } from "../words.js";
import { SlamElement } from "./element.js";
import { fixed } from "./format.js";
import { icons } from "./icons.js";
import { valueOf } from "./input.js";

interface Entry {
  name: LayerName;
  label: string;
  meaning: string;
  sign: TemplateResult<2>;
  simOnly?: boolean;
  /** Only for a real or a recorded robot. */
  realOnly?: boolean;
  /** Only for a log that several methods have mapped. */
  comparedOnly?: boolean;
  /** Only for a method with submaps. */
  submapsOnly?: boolean;
  /** Only for a robot that is localised in a prior map. */
  priorMapOnly?: boolean;
  /** Not drawn now, because planners are compared. */
  makesRoom?: boolean;
}

const stroke = (colour: string, dash = "", width = 2.5): TemplateResult<2> =>
  svg`<path d="M2 9h24" stroke="var(--map-${colour})" stroke-width=${width} stroke-dasharray=${dash}/>`;

const ENTRIES: readonly Entry[] = [
  { name: "robot", label: "Robot", meaning: "The estimated pose. The robot is inside the ellipse with 95 % probability; the wedge is its heading.",
    sign: svg`<ellipse cx="14" cy="9" rx="11" ry="7" fill="var(--map-estimate)" fill-opacity=".25" stroke="var(--map-estimate)" stroke-width="1.5"/><path d="m20 9-9 4 2-4-2-4z" fill="var(--map-robot)" stroke="none"/>` },
  { name: "trails", label: "Trails", meaning: "Solid: the estimate. Dashed: the truth. Dotted: the wheels alone, drifting away.",
    sign: svg`<path d="M2 4h24" stroke="var(--map-estimate)" stroke-width="2.2"/><path d="M2 9h24" stroke="var(--map-truth)" stroke-width="2.2" stroke-dasharray="5 4"/><path d="M2 14h24" stroke="var(--map-odometry)" stroke-width="2" stroke-dasharray=".5 4"/>` },
  { name: "grid", label: "Occupancy grid", meaning: "Free, occupied or unknown, from all scans together; hover shows the probability.",
    sign: svg`<rect x="2" y="2" width="8" height="14" fill="var(--map-free)" stroke="var(--line-strong)" stroke-width="1"/><rect x="10" y="2" width="8" height="14" fill="var(--map-unknown)" stroke="var(--line-strong)" stroke-width="1"/><rect x="18" y="2" width="8" height="14" fill="var(--map-occupied)" stroke="none"/>` },
  { name: "wheels", label: "Wheels alone", meaning: "The walls as they would be drawn by the wheels alone: where these come out double or bent, the wheels slipped, and what the sensor saw had to put it right.",
    sign: svg`<path d="M3 14 9 4h16" fill="none" stroke="var(--map-occupied)" stroke-width="1.6" opacity=".5"/><path d="m3 15 8-8 14-2" fill="none" stroke="var(--map-odometry)" stroke-width="3"/>` },
  { name: "rooms", label: "Rooms", meaning: "Rooms and corridors that the map holds, the doors between them with their widths, and the graph that joins them. A click chooses one; they are listed under Status.",
    sign: svg`<rect x="2" y="3" width="11" height="12" fill="var(--map-contest5)" fill-opacity=".4" stroke="none"/><rect x="15" y="3" width="11" height="12" fill="var(--map-contest3)" fill-opacity=".4" stroke="none"/><path d="M7 9h14" stroke="var(--map-ink)" stroke-width="1.2"/><path d="M14 5v8" stroke="var(--map-door)" stroke-width="2.5"/>` },
  { name: "torn", label: "Torn places", meaning: "Where the map contradicts itself, and how far its sides are apart; dashed where it is only doubtful. It is judged when a recording ends, or under Status.",
    sign: svg`<circle cx="14" cy="9" r="7" fill="none" stroke="var(--map-torn)" stroke-width="2.2"/><path d="m11 6 6 6m0-6-6 6" stroke="var(--map-torn)" stroke-width="2"/>` },
  { name: "scan", label: "Current scan", meaning: "What the sensor sees just now.",
    sign: svg`<path d="M4 14h.01M8 10h.01M13 7h.01M18 6h.01M23 8h.01" stroke="var(--map-scan)" stroke-width="3.4"/>` },
  { name: "tracks", label: "Moving objects", meaning: "Who moves about: each with its number, its velocity (the arrow is a second long) and the ellipse in which it is with 95 % probability. Dashed: it may move, or moved just before. Points in this colour are theirs, and kept out of pose and map.",
    sign: svg`<ellipse cx="8" cy="11" rx="5.5" ry="4.5" fill="none" stroke="var(--map-moving)" stroke-width="1.8"/><path d="m8 11 14-6m-5-1 5 1-3 4.5" fill="none" stroke="var(--map-moving)" stroke-width="1.8"/>` },
  { name: "found", label: "Lines found", meaning: "Straight pieces of the last scan, before they are compared with the walls.", sign: stroke("found", "", 3.5) },
  { name: "points", label: "Points found", meaning: "Of the last scan: squares are corners, triangles spikes, crosses crossings of lines, rings posts and pillars. Each lies in its ellipse with 95 % probability. Settings say which are looked for.",
    sign: svg`<path d="M3 6h6v6H3z" stroke="var(--map-points)" stroke-width="1.8"/><circle cx="14" cy="9" r="3.5" stroke="var(--map-points)" stroke-width="1.8"/><path d="m19 12 3.5-7 3.5 7z" stroke="var(--map-points)" stroke-width="1.8"/>` },
  { name: "walls", label: "Walls", meaning: "Segments of the line map: the walls the filter believes in.", sign: stroke("walls", "", 3) },
  { name: "lines", label: "Line uncertainty", meaning: "The wall lies in this band with 95 % probability; it narrows as the wall is seen again.",
    sign: svg`<path d="M2 3c8 4 16 4 24 0v12c-8-4-16-4-24 0z" fill="var(--map-lines)" fill-opacity=".35" stroke="var(--map-lines)" stroke-width="1"/>` },
  { name: "landmarks", label: "Landmarks", meaning: "What the filter keeps and finds again, or in scan matching the corners and posts of submaps that are complete: the wider the circle, the oftener it was found again (at least once; dotted while it is not believed). Circles of walls stand on their middles. Filled: a corner (square) or a post (disc), in the ellipse in which it lies with 95 % probability.",
    sign: svg`<circle cx="8" cy="9" r="7" fill="none" stroke="var(--map-landmarks)" stroke-width="1.8"/><path d="M6 7h4v4H6z" fill="var(--map-landmarks)" stroke="none"/><circle cx="21" cy="9" r="4" fill="none" stroke="var(--map-landmarks)" stroke-width="1.8"/>` },
  { name: "frontiers", label: "Frontiers", meaning: "Where known free space meets the unknown: the places worth a visit.",
    sign: svg`<path d="M3 12h.01M7 9h.01M11 8h.01M15 9h.01M19 11h.01M23 10h.01" stroke="var(--map-frontiers)" stroke-width="4" stroke-linecap="square"/>`, simOnly: true },
  { name: "path", label: "Path", meaning: "The legs that it will drive, after shortening, with the goal.", sign: stroke("path", "", 3), simOnly: true },
  { name: "rawPath", label: "Path as found", meaning: "Before shortening, as the random tree found it.", sign: stroke("path", "1 5", 2), simOnly: true },
  { name: "tree", label: "Search tree", meaning: "All that the planner (RRT) tried.",
    sign: svg`<path d="M3 14 9 9l5 4m-5-4 4-6m0 0 6 3m-6-3 4 7 7 2" stroke="var(--map-tree)" stroke-width="1.6"/>`, simOnly: true },
  { name: "compared", label: "Other methods", meaning: "The ways that other methods found on the same log; which is which, and how far they lie apart, stands under Status.", comparedOnly: true,
    sign: svg`<path d="M2 6h24" stroke="var(--map-contest2)" stroke-width="2.2" stroke-dasharray="7 3"/><path d="M2 12h24" stroke="var(--map-contest4)" stroke-width="2.2" stroke-dasharray="2 3"/>` },
  { name: "closures", label: "Loop closures", meaning: "Places recognised, or thought to be. Solid: accepted, and the map is bent by it. Thin and grey: neighbours on the way that lie well on each other, without a loop. Dotted: it waits for proof. Dashed: refused; with dots: revoked. A click says why.", submapsOnly: true,
    sign: svg`<path d="M2 3h24" stroke="var(--map-accepted)" stroke-width="2.4"/><path d="M2 7h24" stroke="var(--map-ink)" stroke-width="1" opacity=".45"/><path d="M2 11h24" stroke="var(--map-waiting)" stroke-width="2.4" stroke-dasharray=".5 4"/><path d="M2 15h24" stroke="var(--map-refused)" stroke-width="1.8" stroke-dasharray="6 4"/>` },
  { name: "graph", label: "Pose graph", meaning: "Where each submap begins, joined to the next. Dashed: the scan that began it did not belong to the one before. A click on a join says how far the two lie from it.", submapsOnly: true,
    sign: svg`<path d="m4 13 10-8 10 8" stroke="var(--map-ink)" stroke-width="1.6"/><g fill="var(--map-free)" stroke="var(--map-ink)" stroke-width="1.5"><circle cx="4" cy="13" r="2.8"/><circle cx="14" cy="5" r="2.8"/><circle cx="24" cy="13" r="2.8"/></g>` },
  { name: "submaps", label: "Submaps", meaning: "The pieces that the map is made of, each with its walls in a tint and its number. Where a loop closes, they move as a whole.", submapsOnly: true,
    sign: svg`<path d="M3 14V4h10" stroke="var(--map-contest3)" stroke-width="2.5" stroke-dasharray="2 1.5"/><path d="M12 6h13v9" stroke="var(--map-contest1)" stroke-width="2.5" stroke-dasharray="2 1.5"/>` },
  { name: "twin", label: "Twin", meaning: "Where a simulated robot would be after the same motion of the wheels; switched on in Settings.", sign: stroke("twin", "7 2 1.5 2", 2), realOnly: true },
  { name: "priorMap", label: "Prior map", meaning: "The walls of the map that the robot finds itself in. Where what it sees does not lie on them, map or place is wrong.", sign: stroke("prior", "", 2), priorMapOnly: true },
  { name: "hypotheses", label: "Where it may be", meaning: "Poses that fit what was seen, the likelier the darker, with the particles that stand for them; they go once the robot knows where it is.",
    sign: svg`<path d="m12 9-7 4 1.5-4L5 5z" fill="var(--map-hypotheses)" stroke="none"/><path d="m25 9-7 4 1.5-4L18 5z" fill="var(--map-hypotheses)" fill-opacity=".4" stroke="none"/>`, priorMapOnly: true },
  { name: "truth", label: "Truth", meaning: "The real walls and the real pose. Only the simulator knows them.", sign: stroke("truth", "5 4", 2), simOnly: true },
];

/** Special parts of the truth, shown if the world has them. */
const MATERIALS: readonly { has: (scene: Scene) => boolean; label: string; meaning: string; sign: TemplateResult<2> }[] = [
  { has: (scene) => scene.materials.includes(1), label: "Glass", meaning: "A lidar sees through it, but for beams that meet it squarely. A sonar hears it.", sign: stroke("glass", "8 2 2 2", 3) },
  { has: (scene) => scene.materials.includes(2), label: "Dark wall", meaning: "It swallows light: a lidar sees it from near only.", sign: stroke("dark", "2 2.5", 3.5) },
  { has: (scene) => scene.doors.length > 0, label: "Door", meaning: "Shut: a thick line between two posts. Open: a faint one. A click on it, or its button, moves it.",
    sign: svg`<path d="M4 9h20" stroke="var(--map-door)" stroke-width="4"/><circle cx="4" cy="9" r="3" fill="var(--map-door)" stroke="none"/><circle cx="24" cy="9" r="3" fill="var(--map-door)" stroke="none"/>` },
  { has: (scene) => scene.movers.length > 0, label: "People", meaning: "They walk about. What moves must not become a wall.",
    sign: svg`<circle cx="14" cy="9" r="7" fill="var(--map-people)" fill-opacity=".28" stroke="var(--map-people)" stroke-width="1.5"/><circle cx="14" cy="9" r="2.8" fill="var(--map-people)" stroke="none"/>` },
];

/** Distances are shown up to this many cells. */
const MOST_CELLS = 64;
/** What the grid can show; for fields also the ends of the scale and the meaning. */
const VIEWS: readonly { view: GridView; label: string; ends?: readonly [string, string]; meaning?: string }[] = [
  { view: "continuous", label: "how sure each cell is" },
  { view: "three", label: "three tones, as it is saved" },
  { view: "distance", label: "distance to the nearest wall", ends: ["0 m", "and more"], meaning: "From the middle of each known cell to that of the nearest occupied one." },
  { view: "likelihood", label: "likelihood of a beam's end", ends: ["0: 0.4 m off", "1: on a wall"], meaning: "How well a beam that ends there fits the map, walls taken to be off by 0.1 m (standard deviation)." },
  { view: "room", label: "where the robot may be", ends: ["0 m of room", "and more"], meaning: "Configuration space: how far the middle of the robot's disc may move. Dark: it may not be there at all." },
];

/** What the map can be drawn with; the present meaning of "auto" is shown beside it. */
const DRAWN: Readonly<Record<Drawing, string>> = { auto: "what is quicker here", webgl2: "WebGL2", canvas: "Canvas 2D" };

export class SlamLegend extends SlamElement {
  static override styles = css`
    h2 { margin-bottom: 8px; }
    ul { list-style: none; margin: 0; padding: 0; }
    label { display: grid; grid-template-columns: 28px 1fr auto; align-items: center; gap: 9px; padding: 4px 0; cursor: pointer; font-size: 13px; min-height: 28px; }
    label:hover span { text-decoration: underline; text-decoration-color: var(--line-strong); text-underline-offset: 3px; }
    svg { width: 28px; height: 18px; }
    .off svg { opacity: .35; }
    .off span { color: var(--muted); }
    input { appearance: none; width: 28px; height: 16px; margin: 0; border-radius: 8px; background: var(--line-strong); position: relative; cursor: pointer; transition: background .15s; }
    input::after { content: ""; position: absolute; left: 2px; top: 2px; width: 12px; height: 12px; border-radius: 50%; background: var(--surface); transition: left .15s; }
    input:checked { background: var(--accent); }
    input:checked::after { left: 14px; }
    small { display: none; color: var(--muted); font-size: 12.5px; line-height: 1.35; grid-column: 2 / -1; margin: -4px 0 4px; }
    .meaning { position: sticky; bottom: -12px; margin: 8px -14px -12px; padding: 8px 14px 12px; min-height: 64px; border-top: 1px solid var(--line); background: var(--surface); color: var(--muted); font-size: 12.5px; line-height: 1.35; }
    .tools { display: flex; flex-wrap: wrap; gap: 6px; margin-top: 8px; }
    .tools button { flex: 1; padding: 0 8px; font-size: 13px; min-height: 32px; white-space: nowrap; }
    .order { display: grid; grid-template-columns: 28px 1fr auto auto; align-items: center; gap: 4px 6px; padding: 2px 0; font-size: 13px; }
    .order > svg, .order > span { cursor: grab; user-select: none; }
    .order > svg { touch-action: none; }
    .order.dragged { background: var(--hover); border-radius: 8px; }
    .order button { width: 28px; min-height: 28px; padding: 0; }
    .order button svg { width: 16px; height: 16px; }
    .order .turned svg { transform: rotate(180deg); }
    .material div { display: grid; grid-template-columns: 28px 1fr; align-items: center; gap: 9px; padding: 2px 0 2px 16px; font-size: 12.5px; color: var(--muted); min-height: 24px; }
    .tones { display: grid; gap: 5px; margin-top: 6px; padding-top: 8px; border-top: 1px solid var(--line); font-size: 13px; }
    .tones select { width: 100%; }
    .tones small { display: block; margin: 0; }
    .scale { display: grid; grid-template-columns: 1fr auto; gap: 2px 8px; font: 500 11.5px/1.3 var(--mono); color: var(--muted); }
    .scale i { grid-column: 1 / -1; height: 10px; border-radius: 3px; border: 1px solid var(--line); background: linear-gradient(to right, var(--map-field), color-mix(in srgb, var(--map-field), var(--map-free) 50%) 25%, var(--map-free)); }
    .scale i.likelihood { background: linear-gradient(to right, var(--map-free), var(--map-field)); }
    .scale small { display: block; grid-column: 1 / -1; margin: 2px 0 0; font-family: var(--sans); }
    @media (max-width: 760px) { .meaning { display: none; } small { display: block; } label { min-height: 40px; font-size: 14px; } .order button { width: 40px; min-height: 40px; } li { border-bottom: 1px solid color-mix(in srgb, var(--line) 60%, transparent); } }
  `;

  protected override readonly topics = ["view", "run", "drawing", "tab"] as const;
  /** Whether the list shows the order of the layers, rather than which are shown. */
  #isOrdering = false;
  /** The layer that is being dragged to another place. */
  #dragged: LayerName | null = null;
  /** The meaning of the entry last pointed at. */
  #meaning = "";

  override connectedCallback(): void {
    super.connectedCallback();
    this.addEventListener("pointerleave", () => this.#explain(""));
    // Materials, people and submaps are known from the first frame of a run on.
    let seen = "";
    this.store.on("frame", () => {
      const now = [this.scene.submaps.count > 0, ...MATERIALS.map((m) => m.has(this.scene))].join();
      if (now !== seen) this.requestUpdate();
      seen = now;
    });
  }

  override render(): TemplateResult {
    const { store } = this;
    return html`
      <h2>Layers</h2>
      ${this.#isOrdering ? this.#order() : this.#switches()}
      <div class="tools">
        ${this.#isOrdering && store.layerOrder !== LAYERS ? html`<button data-testid="order-reset" @click=${() => store.set("view", { layerOrder: LAYERS })}>As it was</button>` : nothing}
        <button data-testid="layer-order" aria-pressed=${this.#isOrdering} @click=${() => this.#toggleOrdering()}>${this.#isOrdering ? "Done" : "Order…"}</button>
      </div>
      <p class="meaning" aria-hidden="true" data-testid="layer-meaning">${this.#isOrdering ? "What is higher in the list lies over what is lower." : this.#meaning || "Point at a layer to read what it shows."}</p>
    `;
  }

  #switches(): TemplateResult {
    const { store } = this;
    const { drawing } = store;
    return html`
      <ul>
        ${this.#entries().map(
          (e) => html`<li @pointerenter=${() => this.#explain(e.meaning)} @focusin=${() => this.#explain(e.meaning)}><label class=${store.layers[e.name] && !e.makesRoom ? "" : "off"}>
            <svg viewBox="0 0 28 18" aria-hidden="true">${e.sign}</svg><span>${e.label}</span>
            <input type="checkbox" role="switch" data-testid="layer-${e.name}" aria-label=${e.label} aria-description=${e.meaning} .checked=${store.layers[e.name]} @change=${() => store.toggleLayer(e.name)}>
            <small>${e.meaning}</small></label></li>`,
        )}
        ${store.source === "sim" && store.layers.truth ? MATERIALS.filter((m) => m.has(this.scene)).map((m) => html`<li class="material" title=${m.meaning} data-testid="material-${m.label}"><div><svg viewBox="0 0 28 18" aria-hidden="true">${m.sign}</svg><span>${m.label}</span><small>${m.meaning}</small></div></li>`) : ""}
        <li class="tones"><span id="grid-view">The map shows</span>
          <select data-testid="grid-view" aria-labelledby="grid-view" @change=${(e: Event) => store.set("view", { gridView: valueOf(e) as GridView })}>
            ${VIEWS.map(({ view, label }) => html`<option value=${view} .selected=${store.gridView === view}>${label}</option>`)}
          </select>
          ${this.#scale()}</li>
        <li class="tones"><span id="drawing">The map is drawn with</span>
          <select data-testid="drawing" aria-labelledby="drawing" @change=${(e: Event) => chooseDrawing(valueOf(e) as Drawing)}>
            ${Object.entries(DRAWN).map(([name, label]) => html`<option value=${name} .selected=${chosenDrawing() === name}>${label}</option>`)}
          </select>
          <small data-testid="drawn-with">${DRAWN[drawing.with]}${drawing.why === "" ? "" : html`: ${drawing.why}`}.</small></li>
      </ul>`;
  }

  /** The layers from the top down. */
  #order(): TemplateResult {
    const { store } = this;
    const entries = this.#entries();
    const listed = [...store.layerOrder].reverse().flatMap((name) => entries.filter((e) => e.name === name));
    const move = (at: number, by: 1 | -1) => (): void => {
      const [entry, other] = [listed[at], listed[at + by]];
      if (entry && other) store.moveLayer(entry.name, by < 0 ? "over" : "under", other.name);
    };
    return html`<ul @pointermove=${(event: PointerEvent) => this.#drag(event, listed)} @pointerup=${() => this.#drop()} @pointercancel=${() => this.#drop()}
      >${repeat(listed, (e) => e.name, (e, at) => html`<li class="order ${e.name === this.#dragged ? "dragged" : ""}" data-testid="order-${e.name}" @pointerdown=${(event: PointerEvent) => this.#take(event, e.name)}>
      <svg viewBox="0 0 28 18" aria-hidden="true">${e.sign}</svg><span>${e.label}</span>
      <button class="icon" ?disabled=${at === 0} data-testid="lift-${e.name}" title="Over the one above" aria-label="Lift ${e.label}" @click=${move(at, -1)}>${icons.arrow}</button>
      <button class="icon turned" ?disabled=${at === listed.length - 1} data-testid="lower-${e.name}" title="Under the one below" aria-label="Lower ${e.label}" @click=${move(at, 1)}>${icons.arrow}</button></li>`)}</ul>`;
  }

  /** Starts a drag, by the symbol; with a mouse also by the name, where touch scrolls the list. */
  #take(event: PointerEvent, name: LayerName): void {
    const pressed = event.target as Element;
    if (event.button !== 0 || pressed.closest("button") || (event.pointerType === "touch" && !pressed.closest("svg"))) return;
    // Rows move under the pointer, but the list stays.
    (event.currentTarget as Element).parentElement?.setPointerCapture(event.pointerId);
    event.preventDefault();
    this.#dragged = name;
    this.requestUpdate();
  }

  /** Moves the layer at once to where it is held: over or under its neighbour there. */
  #drag({ clientY }: PointerEvent, listed: readonly Entry[]): void {
    const name = this.#dragged;
    if (name === null) return;
    const at = listed.findIndex((e) => e.name === name);
    const middle = (each: Element): number => each.getBoundingClientRect().top + each.getBoundingClientRect().height / 2;
    const rows = [...this.renderRoot.querySelectorAll("li.order")].map(middle);
    // It passes all layers that it was dragged across, up or down.
    const over = listed.find((_, i) => i < at && clientY < (rows[i] ?? -Infinity));
    const under = listed.findLast((_, i) => i > at && clientY > (rows[i] ?? Infinity));
    if (over) this.store.moveLayer(name, "over", over.name);
    else if (under) this.store.moveLayer(name, "under", under.name);
  }

  #drop(): void {
    this.#dragged = null;
    this.requestUpdate();
  }

  #toggleOrdering(): void {
    this.#isOrdering = !this.#isOrdering;
    this.requestUpdate();
  }

  /** The layers that exist in this run. */
  #entries(): readonly Entry[] {
    const { store } = this;
    const isThere = (e: Entry): boolean => (!e.priorMapOnly || needsPriorMap(store.method)) && (!e.submapsOnly || this.scene.submaps.count > 0) && (!e.comparedOnly || store.compared.length > 0);
    const makesRoom = (e: Entry): boolean => store.comparesPaths && isOfPlan(e.name);
    return ENTRIES.filter((e) => isThere(e) && (store.source === "sim" ? !e.realOnly : !e.simOnly))
      .map((e) => (makesRoom(e) ? { ...e, makesRoom: true, meaning: t`${e.meaning} Not drawn while Paths is open: there paths are compared.` } : e));
  }

  #explain(meaning: string): void {
    this.#meaning = meaning;
    this.requestUpdate();
  }

  /** The meaning of a field's colours. */
  #scale(): TemplateResult | typeof nothing {
    const { gridView: view } = this.store;
    const chosen = VIEWS.find((entry) => entry.view === view);
    if (!chosen?.ends) return nothing;
    const [low, high] = chosen.ends;
    const most = `${fixed(MOST_CELLS * this.scene.tiles.resolution, 1)} m`;
    return html`<div class="scale" data-testid="grid-scale"><i class=${view}></i><span>${low}</span><span>${high === "and more" ? t`${most} and more` : high}</span><small>${chosen.meaning}</small></div>`;
  }
}

customElements.define("slam-legend", SlamLegend);
