// The planners side by side, all with the same query: the path of each, the time that it took, and
// its tree on the map.

import { css, nothing, type TemplateResult, unsafeCSS } from "lit";
import type uPlot from "uplot";
import type { ContestState, Entrant, Ground, NoPathKind } from "../protocol/module.js";
import type { Column } from "../csv.js";
import { isNarrow, isTouched } from "../screen.js";
import { word } from "../spoken.js";
import { CONTEST_COLOURS } from "../view/layers/contest.js";
import { html, t } from "../words.js";
import "./csv_button.js";
import { fixed, list, sentence } from "./format.js";
import { icons } from "./icons.js";
import { valueOf } from "./input.js";
import { colourOf } from "./plot_style.js";
import { type Plotter, SlamPlotted } from "./plotted.js";

const GROUNDS: readonly { ground: Ground; label: string; simOnly?: boolean }[] = [
  { ground: "truth", label: "True walls", simOnly: true },
  { ground: "map", label: "Map so far" },
  { ground: "known", label: "Map, seen only" },
];
/** Seconds for each planner. */
const TIMES = [0.2, 1, 3, 10] as const;
/** Why there is no path, short enough for a cell of the table; the tooltip has the whole
    sentence. */
const WHY: Readonly<Record<NoPathKind, string>> = {
  "start-blocked": "blocked", "goal-blocked": "blocked", unreachable: "no way, proved", "not-offered": "needs walls", exhausted: "none found", "budget-spent": "none found",
};

export class SlamContest extends SlamPlotted {
  static override styles = css`
    :host { container-type: inline-size; }
    p { margin: 8px 0 10px; font-size: 12.5px; color: var(--muted); }
    .bad { color: var(--warn-ink); }
    .row { display: grid; grid-template-columns: 1fr 1fr; gap: 8px; margin-bottom: 8px; }
    .ends button { flex-direction: column; gap: 0; align-items: flex-start; padding: 5px 10px; min-height: 46px; line-height: 1.3; font-size: 12.5px; }
    .ends button .num { font-size: 11.5px; font-weight: 500; color: var(--muted); }
    .ends button[aria-pressed="true"] { border-color: var(--accent); box-shadow: inset 0 0 0 1px var(--accent); }
    label { display: grid; gap: 3px; font-size: 12px; color: var(--muted); }
    label select { color: var(--ink); font-size: 13px; }
    table { width: 100%; border-collapse: collapse; margin: 6px 0 4px; font-size: 12px; }
    th { font: 500 11px/1.2 var(--sans); color: var(--muted); text-align: right; padding: 0 0 5px 5px; white-space: nowrap; }
    th:first-child { text-align: left; padding-left: 0; }
    td { padding: 0 0 0 5px; text-align: right; font: 500 11.5px/1.2 var(--mono); font-variant-numeric: tabular-nums; white-space: nowrap; border-top: 1px solid var(--line); letter-spacing: -.02em; }
    td:first-child { padding-left: 0; text-align: left; }
    td.why { font-family: var(--sans); letter-spacing: 0; color: var(--muted); white-space: normal; }
    td:first-child button { text-align: left; }
    td button { border: 0; border-radius: 6px; background: transparent; min-height: 31px; padding: 0 4px 0 0; gap: 6px; font: 500 12.5px/1.2 var(--sans); width: 100%; justify-content: flex-start; }
    tr { cursor: pointer; }
    tbody tr:hover td, tr.watched td { background: var(--sunk); }
    tr.watched button { font-weight: 650; }
    i { width: 12px; height: 3px; border-radius: 2px; flex: none; }
    ${unsafeCSS(CONTEST_COLOURS.map((colour, row) => `.swatch-${row} { background: var(--map-${colour}); }`).join(" "))}
    tr.watched i { height: 9px; }
    .busy td.time { color: var(--accent-ink); }
    figure { margin: 10px 0 0; }
    figcaption { font-size: 12.5px; margin-bottom: 2px; }
    .plot { height: 140px; }
    @container (max-width: 305px) { .iter { display: none; } }
    @media (pointer: coarse) { td button { min-height: 40px; } }
  `;

  protected override readonly topics = ["contest", "run", "theme", "tab"] as const;
  protected override readonly height = 140;
  #hasTable = false;

  override render(): TemplateResult {
    const { source, contest } = this.store;
    const { found, running, error, start, goal, picking, ground, seconds } = contest;
    const from = start ? place(start) : "where the robot is";
    const click = isTouched() ? word("tap") : word("click");
    return html`
      <h2>Planners, side by side</h2>
      <p>${goal ? "All search for the same path, each for its own time. Choose one to see what it tried." : html`${click === "tap" ? "Tap" : "Click"} the map where the way should lead. The robot stays: this is a contest on paper.`}</p>
      <div class="row ends" role="group" aria-label="What the next ${click} on the map sets">
        <button data-testid="contest-start" aria-pressed=${picking === "start"} title="The next ${click} on the map sets the start" @click=${() => this.#pick("start")}><span>Start</span><span class="num">${from}</span></button>
        <button data-testid="contest-goal" aria-pressed=${picking === "goal"} title="The next ${click} on the map sets the goal" @click=${() => this.#pick("goal")}><span>Goal</span><span class="num">${goal ? place(goal) : t`next ${click}`}</span></button>
      </div>
      <div class="row">
        <label>Among<select data-testid="contest-ground" @change=${(e: Event) => this.client.contest({ ground: valueOf(e) as Ground })}>
          ${GROUNDS.filter((g) => source === "sim" || !g.simOnly).map((g) => html`<option value=${g.ground} .selected=${g.ground === ground}>${g.label}</option>`)}
        </select></label>
        <label>Time for each<select data-testid="contest-seconds" @change=${(e: Event) => this.client.contest({ seconds: Number(valueOf(e)) })}>
          ${TIMES.map((t) => html`<option value=${t} .selected=${t === seconds}>${t} s</option>`)}
        </select></label>
      </div>
      <div class="row">
        ${running
          ? html`<button data-testid="contest-cancel" @click=${() => this.client.send({ kind: "contest-stop" })}>${icons.stop} Cancel</button>`
          : html`<button data-testid="contest-again" ?disabled=${!goal} @click=${() => this.client.contest({})}>${icons.again} Again</button>`}
        <button data-testid="contest-robot" ?disabled=${!start} title="Start where the robot is" @click=${() => this.client.contest({ start: null })}>${icons.follow} From the robot</button>
      </div>
      <div aria-live="polite">${error ? html`<p class="bad" role="alert" data-testid="contest-error">${sentence(t(error))}</p>` : nothing}</div>
      ${found ? this.#table(found) : nothing}
      <figure ?hidden=${!found || !Number.isFinite(found.shortest)} aria-label="Length of each path over the time of its planner"><figcaption>Length over time of computing, m</figcaption><div class="plot"></div></figure>
      ${found ? html`<slam-csv .name=${"planners"} .columns=${() => figuresOf(found)}></slam-csv> <slam-csv .name=${"planners-over-time"} .columns=${() => lengthsOf(found)}></slam-csv>` : nothing}`;
  }

  #table(found: ContestState): TemplateResult {
    const { entrants, isOptimum, disc } = found;
    const hasOutline = entrants.some((e) => e.planner === "outline");
    return html`
      <table data-testid="contest-table" class=${this.store.contest.running ? "busy" : ""}>
        <thead><tr><th scope="col">Planner</th><th scope="col" title="Length of the path, m">m</th><th scope="col" title=${isOptimum ? "Length over that of the visibility graph: there is no shorter path" : "Length over the shortest found"}>${isOptimum ? "/ best" : "/ least"}</th><th scope="col" title="Time of computing">time</th><th class="iter" scope="col" title="Iterations: points drawn, cells expanded, legs looked at">iter.</th><th scope="col" title="Nodes: legs of trees, steps over cells, legs of the graph">nodes</th></tr></thead>
        <tbody>${entrants.map((entrant, row) => this.#row(entrant, row, row === found.watched))}</tbody>
      </table>
      ${entrants.some((e) => e.isStraight) ? html`<p data-testid="contest-straight">Nothing is in the way: the straight line is free.</p>` : nothing}
      ${entrants.map(({ title, leftRooms }) => leftRooms === null ? nothing : html`<p data-testid="contest-fallback">${sentence(title)} searched all cells: ${leftRooms}.</p>`)}
      ${hasOutline ? html`<p data-testid="contest-outline-note">Outline plans for the robot's rectangle, all others for the disc around it, ${fixed(disc, 2)} m wide.</p>` : nothing}
      ${isOptimum || hasOutline || !Number.isFinite(found.shortest) ? nothing : html`<p>Without walls as lines there is no visibility graph: lengths are held against the shortest that was found.</p>`}`;
  }

  #row({ planner, title, isOver, length, ratio, reason, seconds, iterations, tried }: Entrant, row: number, watched: boolean): TemplateResult {
    const outcome = Number.isFinite(length)
      ? html`<td>${fixed(length, 2)}</td><td>${fixed(ratio, 3)}</td>`
      : html`<td class="why" colspan="2" title=${reason?.text ?? ""}>${isOver || !this.store.contest.running ? (reason ? WHY[reason.kind] : "none found") : "looking…"}</td>`;
    return html`<tr class=${watched ? "watched" : ""} data-testid="contest-${planner}" data-over=${isOver} @click=${() => this.client.watch(row)}>
      <td><button aria-pressed=${watched}><i class="swatch-${row}"></i>${sentence(title)}</button></td>
      ${outcome}<td class=${isOver ? "" : "time"}>${time(seconds)}</td><td class="iter">${count(iterations)}</td><td>${count(tried)}</td></tr>`;
  }

  override updated(): void {
    const { found } = this.store.contest;
    // The table answers the request, but on a wide screen it may be below the edge.
    if (found && !this.#hasTable && !isNarrow()) document.querySelector("#paths-panel")?.scrollIntoView({ block: "start" });
    this.#hasTable = found !== null;
    super.updated();
  }

  protected override draw(make: Plotter): uPlot[] {
    const { found } = this.store.contest;
    const host = this.renderRoot.querySelector<HTMLElement>(".plot");
    if (!found || !host || !Number.isFinite(found.shortest) || this.offsetParent === null) return [];
    return [curvesOf(make, found, host, this.frame(host, "s"))];
  }

  #pick(picking: "start" | "goal"): void {
    this.store.set("contest", { contest: { ...this.store.contest, picking } });
  }
}

/** The columns of the table of planners. */
function figuresOf({ entrants }: ContestState): Column[] {
  const numbers = (title: string, unit: string, value: (entrant: Entrant) => number): Column => ({ title, unit, values: entrants.map(value) });
  return [
    { title: "Planner", unit: "", values: entrants.map(({ title }) => sentence(title)) },
    numbers("Length", "m", ({ length }) => length), numbers("Length over the best", "", ({ ratio }) => ratio), numbers("Time", "s", ({ seconds }) => seconds),
    numbers("Iterations", "", ({ iterations }) => iterations), numbers("Nodes", "", ({ tried }) => tried),
    { title: "Why there is no path", unit: "", values: entrants.map(({ reason }) => reason?.text ?? "") },
  ];
}

/** Path lengths as they decreased: a row for each path that was found. */
function lengthsOf({ entrants }: ContestState): Column[] {
  const rows = entrants.flatMap(({ title, curve }) => Array.from({ length: Math.floor(curve.length / 2) }, (_, i) => ({ title: sentence(title), time: curve[2 * i] ?? NaN, length: curve[2 * i + 1] ?? NaN })));
  return [
    { title: "Planner", unit: "", values: rows.map(({ title }) => title) },
    { title: "Time", unit: "s", values: rows.map(({ time }) => time) },
    { title: "Length", unit: "m", values: rows.map(({ length }) => length) },
  ];
}

/** The path length of each planner over time, as a staircase that ends at its total time; that of
    the watched one is thick. */
function curvesOf(make: Plotter, found: ContestState, host: HTMLElement, frame: Omit<uPlot.Options, "series">): uPlot {
  const steps = found.entrants.map(({ curve, seconds }) => {
    const points = new Map<number, number>();
    for (let i = 0; i + 1 < curve.length; i += 2) points.set(Math.max(curve[i] ?? NaN, 1e-4), curve[i + 1] ?? NaN);
    const last = curve.at(-1);
    if (last !== undefined) points.set(Math.max(seconds, 1e-4), last);
    return points;
  });
  const data = make.join(steps.map((points) => [[...points.keys()], [...points.values()]]));
  const stepped = make.paths.stepped?.({ align: 1 });
  const [below, beside] = frame.axes ?? [];
  return new make({
    ...frame, padding: [8, 18, 0, 0],
    series: [{}, ...steps.map((points, row) => {
      const stroke = colourOf(host, `map-${CONTEST_COLOURS[row] ?? "ink"}`);
      return { stroke, width: row === found.watched ? 2.6 : 1.5, ...(stepped ? { paths: stepped } : {}), points: { show: points.size < 40, size: row === found.watched ? 7 : 5, fill: stroke } };
    })],
    scales: { x: { time: false, distr: 3 }, y: { range: (_u, low, high) => [low - 0.05 * (high - low || 1), high + 0.1 * (high - low || 1)] } },
    axes: [{ ...below, splits: (_u, _axis, low, high) => decades(low, high), filter: (_u, splits) => splits, values: (_u, ticks) => ticks.map((t) => time(t)) }, beside ?? {}],
  }, data, host);
}

/** The powers of ten between two positive numbers. */
function decades(low: number, high: number): number[] {
  const [first, last] = [Math.ceil(Math.log10(low) - 1e-9), Math.floor(Math.log10(high) + 1e-9)];
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, i) => 10 ** (first + i));
}

function place([x, y]: readonly [number, number]): string {
  return `${list(fixed(x, 2), fixed(y, 2))} m`;
}

function time(seconds: number): string {
  if (seconds < 0.001) return `${fixed(1e3 * seconds, 1)} ms`;
  if (seconds < 0.9995) return `${fixed(1e3 * seconds, 0)} ms`;
  return `${fixed(seconds, seconds < 9.95 ? 1 : 0)} s`;
}

function count(n: number): string {
  if (n < 10_000) return String(n);
  return n < 1e6 ? `${fixed(n / 1e3, n < 1e5 ? 1 : 0)}k` : `${fixed(n / 1e6, 1)}M`;
}

customElements.define("slam-contest", SlamContest);
