// All robots behind the router on one page: where they are, how they are, and a button to stop
// them.
//
// In: /fleet.json of the bridge, requested again after each answer, so that the newest state is
// shown and nothing queues. Out: /fleet/stop.

import { css, LitElement, nothing, type TemplateResult } from "lit";
import { repeat } from "lit/directives/repeat.js";
import { startLanguage } from "../language.js";
import { word } from "../spoken.js";
import { REASONS } from "../ui/disarm_words.js";
import { DASH, fixed } from "../ui/format.js";
import { shared } from "../ui/style.js";
import { Camera } from "../view/camera.js";
import { type Palette, readPalette } from "../view/palette.js";
import { html, svg, t } from "../words.js";
import { boxOf, colours, draw, type Drawn, type Grid, gridOf, type MapBody, outline, SIGN } from "./draw.js";
import { type Changes, Fleet, type Frame, type Robot, type State } from "./model.js";

/** Time between two requests, ms. */
const ASK = 200;
/** Time after a request that was not answered, ms. */
const ASK_AGAIN = 1000;
/** Timeout of a request, ms. */
const PATIENCE = 5000;
/** Time between two requests for the map of the frame, ms. */
const MAP = 10_000;
/** A click this near to a robot, CSS pixels, chooses it. */
const NEAR = 3 * SIGN;

const WORDS: Readonly<Record<State, string>> = {
  emergency: word("emergency stop"),
  away: word("not at the router"),
  silent: word("silent"),
  alert: word("alert"),
  lost: word("does not know where it is"),
  driving: word("armed"),
  standing: word("standing by"),
};

/** The same shape as on the map. */
const sign = (state: State): TemplateResult => html`<svg viewBox="-1.2 -1.2 2.4 2.4" aria-hidden="true">${svg`<polygon points=${outline(state).map((point) => point.join()).join(" ")}></polygon>`}</svg>`;

export class SlamFleet extends LitElement {
  static override styles = [
    shared,
    css`
      :host { display: grid; grid-template: auto minmax(0, 1fr) / minmax(0, 1fr) 380px; height: 100dvh; background: var(--surface); }
      header { grid-column: 1 / -1; display: flex; flex-wrap: wrap; gap: 8px 16px; align-items: center; padding: 8px 14px; border-bottom: 1px solid var(--line); }
      h1 { margin: 0; font: 600 17px/1.2 var(--sans); }
      header p { margin: 0; color: var(--muted); flex: 1; min-width: 12em; }
      header p b { color: var(--ink); font-weight: 600; }
      .stop { background: var(--danger); border-color: var(--danger); color: #fff; font-weight: 650; }
      .stop:hover { background: var(--danger-hover); border-color: var(--danger-hover); }
      header .stop { min-height: 44px; padding: 0 20px; font-size: 16px; }
      main { position: relative; min-width: 0; min-height: 0; }
      canvas { position: absolute; inset: 0; width: 100%; height: 100%; touch-action: none; }
      .frame { position: absolute; left: 10px; right: 10px; bottom: 10px; max-width: 460px; padding: 8px 10px; border: 1px solid var(--line); border-radius: 10px; background: var(--glass); font-size: 12.5px; color: var(--muted); }
      .frame label { display: block; color: var(--ink); font-weight: 550; }
      aside { display: flex; flex-direction: column; min-height: 0; border-left: 1px solid var(--line); padding: 10px; gap: 8px; }
      ul { list-style: none; margin: 0; padding: 0; overflow-y: auto; flex: 1; }
      li { display: grid; grid-template-columns: minmax(0, 1fr) auto; gap: 4px 8px; align-items: center; border-bottom: 1px solid var(--line); padding: 4px 2px; content-visibility: auto; contain-intrinsic-height: 52px; }
      li[data-chosen] { background: var(--hover); }
      li > button:first-child { display: grid; grid-template-columns: 22px minmax(0, 1fr) auto; text-align: left; justify-content: stretch; gap: 0 6px; border: 0; background: none; min-height: 44px; padding: 0 4px; white-space: normal; }
      li b { overflow: hidden; text-overflow: ellipsis; }
      li small { grid-column: 2 / -1; font-weight: 400; color: var(--muted); font-size: 12.5px; }
      li svg { fill: currentColor; stroke-width: .2; color: var(--warn-ink); }
      [data-state="driving"] svg { color: var(--accent-ink); }
      [data-state="standing"] svg { color: var(--good-ink); }
      [data-state="away"] svg { fill: none; color: var(--muted); }
      .more { grid-column: 1 / -1; padding: 2px 4px 8px 32px; font-size: 13px; overflow-wrap: anywhere; }
      .more p { margin: 0 0 4px; }
      a { color: var(--accent-ink); }
      [role="status"] { min-height: 1.4em; font-size: 13px; }
      .bad { color: var(--warn-ink); font-weight: 600; }
      @media (max-width: 760px) {
        :host { grid-template: auto 42dvh minmax(0, 1fr) / minmax(0, 1fr); }
        header { padding: 8px 10px; }
        header p { flex: 1 0 60%; min-width: 0; font-size: 13px; }
        header .stop { flex: 1; }
        .frame small { display: none; }
        aside { border-left: 0; border-top: 1px solid var(--line); }
      }
    `,
  ];
  static override properties = { search: { state: true }, chosen: { state: true }, said: { state: true }, frameKey: { state: true }, fault: { state: true } };

  declare search: string;
  declare chosen: string | null;
  declare said: string;
  declare frameKey: string;
  declare fault: string;
  readonly #fleet = new Fleet();
  readonly #camera = new Camera();
  #frames: Frame[] = [];
  #palette!: Palette;
  #tone!: Record<State, string>;
  #grid: Grid | null = null;
  #map: { of: string; revision: number; at: number } | null = null;
  #fitted = "";
  /** The motion of each robot to the place last reported. */
  readonly #ways = new Map<string, { from: readonly [number, number, number]; to: readonly [number, number, number]; since: number }>();

  constructor() {
    super();
    [this.search, this.chosen, this.said, this.frameKey, this.fault] = ["", null, "", "", ""];
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.#readColours();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.#readColours();
      this.#map = null;
    });
    addEventListener("keydown", (event) => this.#key(event));
    void this.#askOn();
  }

  override firstUpdated(): void {
    const canvas = this.#canvas;
    new ResizeObserver(() => this.#resize()).observe(canvas);
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.#camera.zoomAt(Math.exp(-event.deltaY / 500), event.offsetX, event.offsetY);
    }, { passive: false });
    let moved = 0;
    canvas.addEventListener("pointerdown", (event) => {
      moved = 0;
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!canvas.hasPointerCapture(event.pointerId)) return;
      moved += Math.hypot(event.movementX, event.movementY);
      this.#camera.panBy(event.movementX, event.movementY);
    });
    canvas.addEventListener("pointerup", (event) => moved < 4 && this.#pick(event.offsetX, event.offsetY));
    const frame = (): void => {
      this.#draw(canvas);
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  get #canvas(): HTMLCanvasElement {
    return this.renderRoot.querySelector("canvas") as HTMLCanvasElement;
  }

  #readColours(): void {
    this.#palette = readPalette();
    this.#tone = colours(this.#palette, getComputedStyle(this));
  }

  #resize(): void {
    const canvas = this.#canvas;
    const ratio = devicePixelRatio;
    Object.assign(this.#camera, { width: canvas.clientWidth, height: canvas.clientHeight, ratio });
    [canvas.width, canvas.height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    this.#fitted = "";
  }

  async #askOn(): Promise<never> {
    for (;;) {
      const begun = performance.now();
      let pause = ASK;
      try {
        const answer = await fetch(`fleet.json?since=${this.#fleet.revision}`, { signal: AbortSignal.timeout(PATIENCE) });
        if (answer.status === 404) this.fault = t("This bridge is at no router: start it with --zenoh, and robots there are shown.");
        else if (!answer.ok) this.fault = await answer.text();
        else {
          this.fault = "";
          this.#take((await answer.json()) as Changes);
        }
        if (!answer.ok) pause = ASK_AGAIN;
      } catch {
        this.fault = t("The bridge does not answer. What is shown is old, and nothing can be stopped from here.");
        pause = ASK_AGAIN;
      }
      this.requestUpdate();
      await new Promise((done) => setTimeout(done, Math.max(0, begun + pause - performance.now())));
    }
  }

  #take(changes: Changes): void {
    const now = performance.now();
    for (const { name, pose } of [...changes.robots, ...changes.moved]) {
      const before = this.#ways.get(name);
      if (!pose) this.#ways.delete(name);
      else if (!before || pose.some((number, n) => number !== before.to[n])) this.#ways.set(name, { from: before ? between(before, now) : pose, to: pose, since: now });
    }
    this.#fleet.take(changes, now);
    this.#frames = this.#fleet.frames();
    if (!this.#frames.some(({ key }) => key === this.frameKey)) this.frameKey = this.#frames[0]?.key ?? "";
    void this.#askForMap(now);
  }

  get #frame(): Frame | undefined {
    return this.#frames.find(({ key }) => key === this.frameKey);
  }

  /** Requests the map of one robot of the frame that is there. */
  async #askForMap(now: number): Promise<void> {
    const frame = this.#frame;
    const from = frame?.robots.find(({ here }) => here);
    if (!frame || !from || (this.#map?.of === frame.key && now - this.#map.at < MAP)) return;
    const before = this.#map?.of === frame.key ? this.#map.revision : -1;
    this.#map = { of: frame.key, revision: before, at: now };
    if (before < 0) this.#grid = null;
    const answer = await fetch(`fleet/map/${encodeURIComponent(from.name)}`).catch(() => null);
    if (!answer?.ok) return;
    const { message } = (await answer.json()) as { message: { Map?: MapBody } };
    const map = message.Map;
    if (!map || map.revision === before) return;
    const grid = await gridOf(map, this.#palette);
    if (this.#map?.of !== frame.key) return;
    [this.#grid, this.#map.revision] = [grid, map.revision];
    this.#fitted = "";
  }

  #drawn(now: number): Drawn[] {
    return (this.#frame?.robots ?? []).flatMap((robot) => {
      const way = this.#ways.get(robot.name);
      return way ? [{ name: robot.name, pose: between(way, now), state: this.#fleet.state(robot, now), chosen: robot.name === this.chosen }] : [];
    });
  }

  #draw(canvas: HTMLCanvasElement): void {
    const context = canvas.getContext("2d", { alpha: false });
    if (!context) return;
    const robots = this.#drawn(performance.now());
    if (this.#fitted !== this.frameKey && this.frameKey) {
      const box = boxOf(this.#grid, robots);
      this.#camera.inset.bottom = (this.renderRoot.querySelector<HTMLElement>(".frame")?.offsetHeight ?? 0) + 10;
      if (box) Object.assign(this.#camera, this.#camera.fitted(box));
      this.#fitted = this.frameKey;
    }
    draw(context, this.#camera, this.#grid, robots, this.#palette, this.#tone);
  }

  #pick(x: number, y: number): void {
    const far = this.#drawn(performance.now()).map(({ name, pose }) => {
      const [sx, sy] = this.#camera.toScreen(pose[0], pose[1]);
      return { name, far: Math.hypot(sx - x, sy - y) };
    });
    const nearest = far.reduce<{ name: string; far: number } | null>((best, one) => (one.far < (best?.far ?? NEAR) ? one : best), null);
    this.#choose(nearest?.name ?? null);
  }

  #choose(name: string | null): void {
    this.chosen = name;
    const frame = this.#frames.find(({ robots }) => robots.some((robot) => robot.name === name));
    if (frame) this.frameKey = frame.key;
    void this.updateComplete.then(() => this.renderRoot.querySelector("li[data-chosen]")?.scrollIntoView({ block: "nearest" }));
  }

  #key(event: KeyboardEvent): void {
    const isTyped = event.composedPath()[0] instanceof HTMLInputElement;
    if (event.key === "Escape") this.#choose(null);
    if (isTyped || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "S") void this.#stop(null);
    else if (event.key === "s" && this.chosen) void this.#stop(this.chosen);
    else if (event.key === "/") {
      event.preventDefault();
      this.renderRoot.querySelector("input")?.focus();
    }
  }

  async #stop(name: string | null): Promise<void> {
    this.said = name === null ? t("Stopping all robots …") : t`Stopping ${name} …`;
    const path = name === null ? "fleet/stop" : `fleet/stop/${encodeURIComponent(name)}`;
    const answer = await fetch(path, { method: "POST", signal: AbortSignal.timeout(PATIENCE) }).catch(() => null);
    if (answer?.ok) this.said = name === null ? t`Stop was sent to all robots. The list shows who has stopped.` : t`Stop was sent to ${name}. The list shows when it has stopped.`;
    else this.said = t`Stop was NOT sent: ${answer ? await answer.text() : t("the bridge does not answer")}`;
  }

  override render(): TemplateResult {
    const now = performance.now();
    const all = this.#fleet.sorted("", now);
    const [armed, urgent] = [all.filter(({ robot }) => robot.here && robot.safety?.armed).length, all.filter(({ state }) => state !== "driving" && state !== "standing").length];
    const here = all.filter(({ robot }) => robot.here).length;
    const shown = this.search ? this.#fleet.sorted(this.search, now) : all;
    return html`
      <header>
        <h1>Fleet</h1>
        <p><b>${t`${here} of ${all.length} robots here`}</b> · ${t`${armed} armed`} · ${t`${urgent} need attention`}</p>
        <a href="./">This bridge's robot</a>
        <button class="stop" aria-keyshortcuts="Shift+S" @click=${() => this.#stop(null)}>Stop all</button>
      </header>
      <main>
        <canvas role="img" aria-label=${t`Map with ${this.#frame?.robots.length ?? 0} robots; the list has all of them`}></canvas>
        ${this.#frame ? this.#frameCard(this.#frame) : html`<p class="frame">No robot says where it is: only one that maps can (--map).</p>`}
      </main>
      <aside aria-label="Robots">
        ${this.fault ? html`<p class="bad" role="alert">${this.fault}</p>` : !this.#fleet.connected && all.length ? html`<p class="bad" role="alert">The bridge has lost the router. What is shown is old, and nothing can be stopped from here.</p>` : nothing}
        ${this.#fleet.leftOut ? html`<p class="bad">There are more robots than can be shown.</p>` : nothing}
        <input type="text" .value=${this.search} placeholder="Search by name" aria-label="Search by name" aria-keyshortcuts="/" @input=${(event: Event) => (this.search = (event.target as HTMLInputElement).value)}>
        <div role="status">${this.said}</div>
        <ul>${repeat(shown, ({ robot }) => robot.name, ({ robot, state }) => this.#row(robot, state, now))}</ul>
      </aside>`;
  }

  #frameCard(frame: Frame): TemplateResult {
    return html`<div class="frame">
      <label>Map
        <select .value=${this.frameKey} @change=${(event: Event) => (this.frameKey = (event.target as HTMLSelectElement).value)}>
          ${this.#frames.map(({ key, file, robots }) => html`<option value=${key} ?selected=${key === this.frameKey}>${file === null ? t`${robots[0]?.name} alone` : t`${file}: ${robots.length} robots`}</option>`)}
        </select>
      </label>
      ${frame.file === null ? html`This robot keeps no map in a file that others could share, so it is drawn alone.` : html`<small>Drawn together are robots whose map is kept in a file of this name. That it is the same map, the page takes from the name.</small>`}
    </div>`;
  }

  #row(robot: Robot, state: State, now: number): TemplateResult {
    const chosen = robot.name === this.chosen;
    const age = this.#fleet.age(robot.heard, now);
    return html`<li data-state=${state} data-name=${robot.name} ?data-chosen=${chosen}>
      <button aria-expanded=${chosen} @click=${() => this.#choose(chosen ? null : robot.name)}>
        ${sign(state)}<b>${robot.name}</b><span class="num">${robot.volts === null ? DASH : t`${fixed(robot.volts, 1)} V`}</span>
        <small>${WORDS[state]}</small>
      </button>
      <button class="stop" ?disabled=${!robot.here} aria-label=${t`Stop ${robot.name}`} @click=${() => this.#stop(robot.name)}>Stop</button>
      ${chosen ? html`<div class="more">${this.#more(robot, age)}</div>` : nothing}
    </li>`;
  }

  #more(robot: Robot, age: number): TemplateResult {
    const { safety, alert, pose } = robot;
    return html`
      <p>${t`heard ${fixed(age, 1)} s ago`}${pose ? html` · <span class="num">${t`x ${fixed(pose[0], 2)} m, y ${fixed(pose[1], 2)} m`}</span>` : nothing}</p>
      ${safety?.armed && safety.driver ? html`<p>${t`driven by ${safety.driver}`}</p>` : nothing}
      ${safety && !safety.armed ? html`<p>${REASONS[safety.reason]}</p>` : nothing}
      ${alert ? html`<p class="bad">${alert.text}</p>` : nothing}
      ${robot.page ? html`<p><a href=${robot.page}>Open its page</a></p>` : html`<p class="muted">It does not say where its page is.</p>`}`;
  }
}

/** Where a robot is drawn between two reports. */
function between({ from, to, since }: { from: readonly [number, number, number]; to: readonly [number, number, number]; since: number }, now: number): readonly [number, number, number] {
  const part = Math.min(1, (now - since) / ASK);
  const turn = Math.atan2(Math.sin(to[2] - from[2]), Math.cos(to[2] - from[2]));
  return [from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1]), from[2] + part * turn];
}

await startLanguage();
customElements.define("slam-fleet", SlamFleet);
