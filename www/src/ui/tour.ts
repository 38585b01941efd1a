// The four steps of the tour, beside the run that they explain.

import { css, nothing, type TemplateResult } from "lit";
import { DoubtHistory, doubtOf } from "../doubt.js";
import { isTouched } from "../screen.js";
import { begin, go, isOwnRun, SPEED, STEPS, type TourStep } from "../tour.js";
import { html, svg } from "../words.js";
import { SlamElement } from "./element.js";
import { length } from "./format.js";
import { icons } from "./icons.js";
import { story } from "./story_card.js";

const TITLES: Readonly<Record<TourStep, string>> = {
  unknown: "This robot has never been here",
  wheels: "Its wheels are not enough",
  doubt: "It knows how sure it is",
  loop: "A known place puts it right",
};

type Length = ReturnType<typeof length>;

/** Visitors who stay this long at the first step are shown what goes wrong there, wall seconds. */
const LINGERS = 15;

/** How long the close view of the robot lasts after its uncertainty has collapsed, wall
    milliseconds: its map slides into place meanwhile. */
const NEAR_MILLIS = 6000;

export class SlamTour extends SlamElement {
  static override styles = [story, css`
    .key { display: inline-block; width: 22px; height: 10px; margin-right: 2px; border-radius: 3px; vertical-align: -1px; }
    .seen { background: var(--map-free); border: 1px solid var(--line-strong); }
    .walls { height: 4px; vertical-align: 2px; background: var(--map-occupied); }
    .scan { width: 14px; height: 0; border-top: 4px dotted var(--map-scan); border-radius: 0; vertical-align: 2px; }
    .way { height: 3px; vertical-align: 3px; background: var(--map-estimate); }
    .truth { height: 0; border-top: 3px dashed var(--map-truth); border-radius: 0; vertical-align: 3px; }
    .wheels { background: var(--map-odometry); }
    .ellipse { border-radius: 50%; border: 2px solid var(--map-estimate); background: color-mix(in srgb, var(--map-estimate) 25%, transparent); }
    figure { margin: 0 0 10px; }
    figcaption { display: flex; justify-content: space-between; gap: 8px; font-size: 12.5px; color: var(--muted); }
    figcaption b { font: 500 13px/1.4 var(--mono); color: var(--ink); }
    figure svg { display: block; width: 100%; height: 48px; border-radius: 8px; background: var(--sunk); }
    polyline { fill: none; stroke: var(--map-estimate); stroke-width: 2; vector-effect: non-scaling-stroke; }
    footer { display: flex; align-items: center; gap: 8px; }
    ol { flex: 1; display: flex; gap: 6px; margin: 0; padding: 0; list-style: none; }
    li { width: 8px; height: 8px; border-radius: 50%; background: var(--line-strong); opacity: .45; }
    li[aria-current] { background: var(--accent); opacity: 1; }
    .next { background: var(--accent); color: var(--on-accent); border-color: transparent; }
    .next:hover { background: var(--accent-ink); border-color: transparent; }
    @media (max-width: 760px) { figure svg { height: 34px; } }
  `];

  protected override readonly topics = ["tour", "frame", "view"] as const;
  readonly #history = new DoubtHistory();
  /** What the uncertainty shrank from and to, when a loop was closed. */
  #collapse: { from: number; to: number } | null = null;
  /** How far that moved the map, m. */
  #moved = 0;
  #time = 0;
  /** Whether the map by odometry was shown by itself, because the first step took long. */
  #isShown = false;

  override connectedCallback(): void {
    super.connectedCallback();
    this.store.on("run", () => {
      // The tour is about its own run: starting another one ends it.
      if (this.store.tour && !isOwnRun(this.store)) go(this.store, null);
    });
    this.store.on("frame", () => this.#follow());
    this.store.on("moved", () => (this.#moved = Math.max(this.#moved, this.store.moved)));
  }

  #follow(): void {
    const { status, tour } = this.store;
    if (!tour || !status) return;
    if (status.time < this.#time) [this.#collapse, this.#moved, this.#isShown] = [null, 0, false];
    this.#time = status.time;
    if (tour === "unknown" && !this.#isShown && (status.finished || status.time >= LINGERS * SPEED)) {
      this.#isShown = true;
      this.store.setLayers({ wheels: true });
    }
    const collapse = this.#history.add(status.time, doubtOf(status));
    // The uncertainty also shrinks when the robot turns back on its own path.
    if (!collapse || this.#collapse || status.loopClosures === 0) return;
    this.#collapse = collapse;
    if (tour !== "doubt" && tour !== "loop") return;
    go(this.store, "loop", true);
    setTimeout(() => {
      // A visitor who has gone on, or moved the view, is left there.
      if (this.store.tour === "loop" && this.store.follow) go(this.store, "loop");
    }, NEAR_MILLIS);
  }

  override render(): TemplateResult | typeof nothing {
    const { tour } = this.store;
    if (!tour) return nothing;
    const at = STEPS.indexOf(tour);
    const next = STEPS[at + 1] ?? null;
    return html`<section aria-label="What SLAM is" data-testid="tour">
      <header><h2 aria-live="polite">${tour === "unknown" && this.store.status?.finished ? "This robot had never been here" : TITLES[tour]}</h2>
        <button class="icon" aria-label="Leave the tour" title="Leave the tour" data-testid="tour-leave" @click=${this.press(() => go(this.store, null))}>${icons.close}</button></header>
      ${this.#words(tour)}
      <footer>
        <ol aria-label="Step ${at + 1} of ${STEPS.length}">${STEPS.map((step) => html`<li aria-current=${step === tour ? "step" : nothing}></li>`)}</ol>
        ${at > 0 ? html`<button data-testid="tour-back" @click=${() => this.#go(STEPS[at - 1] ?? null)}>Back</button>` : nothing}
        <button class=${next || this.#collapse ? "next" : ""} data-testid="tour-next" @click=${next ? () => this.#go(next) : this.press(() => go(this.store, null))}>${next ? "Next" : "Look around"}</button>
      </footer>
    </section>`;
  }

  /** Goes to a step; the last one stays near the robot until the loop is closed. */
  #go(step: TourStep | null): void {
    go(this.store, step, step === "loop" ? !this.#collapse : undefined);
  }

  #words(step: TourStep): TemplateResult {
    const { status } = this.store;
    const off = length(status?.odometryError ?? NaN);
    switch (step) {
      case "unknown":
        return html`${status?.finished
          ? html`<p><i class="key seen"></i> is what it has seen, <i class="key walls"></i> are walls, and <i class="key scan"></i> is what its laser saw last. Nobody told it where it is: it had to find out both at once. That is <b>SLAM</b>, simultaneous localisation and mapping.</p>`
          : html`<p><i class="key seen"></i> is what it has seen so far, <i class="key walls"></i> are walls, and <i class="key scan"></i> is what its laser sees just now. Of all else it knows nothing. Nor does anyone tell it where it is: it has to find out both at once. That is <b>SLAM</b>, simultaneous localisation and mapping.</p>`}
          ${this.store.layers.wheels
            ? html`<p><i class="key wheels"></i> is what its wheels alone would have drawn: wrong by <b>${off.value} ${off.unit}</b>.</p>`
            : html`<p class="muted">Robot and building are simulated, ${SPEED} times as fast as in life.</p>`}`;
      case "wheels":
        return html`<p><i class="key wheels"></i> is what it would draw by its wheels alone. They slip a little at every turn, errors add up, and by now they are wrong by <b>${off.value} ${off.unit}</b>. What the laser sees of walls that it knows puts it right: <i class="key way"></i> is the way that it has come.</p>`;
      case "doubt":
        return html`<p>Seen from near: it is inside the <i class="key ellipse"></i> ellipse with 95 % probability. On the way into the unknown that grows. Walls that come into sight again make it a little smaller; a place where it was long before makes it small at once.</p>${this.#doubt()}`;
      case "loop":
        return this.#collapse ? this.#closed(this.#collapse) : html`${this.#awaited()}${this.#doubt()}`;
    }
  }

  /** What has to happen next; a robot that is steered by hand does not get there by itself. */
  #awaited(): TemplateResult {
    const { status } = this.store;
    if (status?.mode === "explore" && status.finished) return html`<p>This run came to its end before it closed its loop.</p><p><button data-testid="tour-again" @click=${this.press(() => begin(this.store, this.client))}>Begin again</button></p>`;
    if (status && status.mode !== "explore") return html`<p>It no longer finds its way itself, since you took over: bring it round to where it began, or let it go on.</p><p><button data-testid="tour-explore" @click=${this.press(() => this.#letGo())}>Let it explore</button></p>`;
    return html`<p>Once it comes round to where it began, its doubt falls at once, and the whole way between is put straight. Watch the ellipse: it is soon there.</p>`;
  }

  /** Hands the robot back. Steering was in real time; the tour has a speed of its own. */
  #letGo(): void {
    this.client.setSpeed(SPEED);
    this.client.explore();
  }

  /** What closing the loop did. */
  #closed(collapse: { from: number; to: number }): TemplateResult {
    const { store: { layers: { truth }, status } } = this;
    const [from, to, by, off] = [collapse.from, collapse.to, this.#moved, status?.positionError ?? NaN].map(length) as [Length, Length, Length, Length];
    const touch = isTouched();
    const fell = html`Here it met a place that it knew: from ${from.value} ${from.unit} its doubt fell to <b>${to.value} ${to.unit}</b>.`;
    const slid = this.#moved > 0
      ? html`The pieces of its map, for a moment each in a colour of its own, moved into place by up to <b>${by.value} ${by.unit}</b>.`
      : html`The whole way round was put straight.`;
    return html`<p>${fell} ${slid}</p>${this.#doubt()}
      <p><button data-testid="tour-truth" aria-pressed=${truth} @click=${() => this.store.toggleLayer("truth")}>${icons.eye} ${truth ? "Hide the truth" : "Compare with the truth"}</button></p>
      ${truth ? html`<p><i class="key truth"></i> is the truth: the robot is <b>${off.value} ${off.unit}</b> from where it believes to be.</p>`
        : html`<p class="muted">${touch ? "Choose Go to and tap the map: the robot drives there. Look around, and under Run a recorded log of a real building opens." : "Choose Go to and click the map: the robot drives there. Drop a recorded log, and a real building is mapped."}</p>`}`;
  }

  /** How the uncertainty grew and shrank. */
  #doubt(): TemplateResult {
    const { samples } = this.#history;
    const [first, last] = [samples[0], samples.at(-1)];
    if (!first || !last) return html``;
    const most = Math.max(...samples.map((sample) => sample.doubt), 0.1);
    const span = Math.max(last.time - first.time, 1);
    const line = samples.map(({ time, doubt }) => `${(100 * (time - first.time) / span).toFixed(2)},${(30 - 27 * doubt / most).toFixed(2)}`).join(" ");
    const now = length(last.doubt);
    return html`<figure><figcaption><span>Known to within</span><b data-testid="tour-doubt">${now.value} ${now.unit}</b></figcaption>
      <svg viewBox="0 0 100 32" preserveAspectRatio="none" aria-hidden="true">${svg`<polyline points=${line}/>`}</svg></figure>`;
  }
}

customElements.define("slam-tour", SlamTour);
