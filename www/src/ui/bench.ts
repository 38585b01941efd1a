// The drive controller on a bench: its response on a straight drive when the motors differ and
// something pulls at a track.

import { css, type TemplateResult } from "lit";
import { degrees } from "../angle.js";
import type uPlot from "uplot";
import type { Column } from "../csv.js";
import type { BenchResponse, BenchTrial } from "../protocol/module.js";
import { word } from "../spoken.js";
import { html, t } from "../words.js";
import "./csv_button.js";
import { fixed } from "./format.js";
import { valueOf } from "./input.js";
import { colourOf } from "./plot_style.js";
import { type Plotter, SlamPlotted } from "./plotted.js";
import { tool } from "./style.js";

/** Desired speed as a part of the highest, when the pull begins, and the duration, s. */
const TRIAL = { forward: 0.8, pullAt: 2.5, seconds: 5 };

export class SlamBench extends SlamPlotted {
  static override styles = [
    tool,
    css`
      :host { padding-top: 12px; }
      label { display: grid; grid-template-columns: 1fr auto; gap: 2px 8px; font-size: 12.5px; margin-bottom: 8px; }
      input[type="range"] { grid-column: 1 / -1; width: 100%; accent-color: var(--accent); margin: 0; min-height: 24px; }
      .key { display: flex; flex-wrap: wrap; gap: 4px 12px; font-size: 12px; color: var(--muted); margin-bottom: 8px; }
      .key span { display: inline-flex; align-items: center; gap: 5px; }
      .key svg { width: 20px; height: 8px; }
      .plot { height: 130px; }
    `,
  ];

  protected override readonly topics = ["run", "bench", "theme"] as const;
  protected override readonly height = 130;
  #open = false;
  #trial: BenchTrial = { ...TRIAL, mismatch: 0.1, pull: 1 };

  override connectedCallback(): void {
    super.connectedCallback();
    this.store.on("run", () => this.#open && this.#ask());
  }

  override render(): TemplateResult {
    const { source, bench } = this.store;
    const { mismatch, pull } = this.#trial;
    this.toggleAttribute("hidden", source !== "sim");
    return html`<details data-testid="bench" @toggle=${this.#toggle}>
      <summary>Drive controller on the bench</summary>
      <p>A step to ${100 * TRIAL.forward} % of full speed, straight ahead. The controller sees the encoders and corrects the voltages; without it they follow from the wished speed alone.</p>
      <label>Right motor stronger than believed <span class="num">${fixed(100 * mismatch, 0)} %</span>
        <input type="range" min="0" max="30" step="1" data-testid="mismatch" .value=${String(100 * mismatch)} @input=${(e: Event) => this.#change({ mismatch: Number(valueOf(e)) / 100 })}></label>
      <label>Pull at the left track after ${TRIAL.pullAt} s <span class="num">${fixed(pull, 1)} N</span>
        <input type="range" min="0" max="20" step="1" data-testid="pull" .value=${String(10 * pull)} @input=${(e: Event) => this.#change({ pull: Number(valueOf(e)) / 10 })}></label>
      <div class="key">${[["path", "with controller", ""], ["odometry", word("without"), "4 3"], ["truth", word("wished"), "1 3"]].map(([colour, text, dash]) => html`<span><svg viewBox="0 0 20 8" aria-hidden="true"><path d="M0 4h20" stroke="var(--map-${colour})" stroke-width="2" stroke-dasharray=${dash ?? ""}/></svg>${text}</span>`)}</div>
      <figure aria-label="Speeds of both tracks over time"><figcaption><span>Speeds of both tracks, m/s</span></figcaption><div class="plot"></div></figure>
      <figure aria-label="Heading over time"><figcaption><span>Heading, °</span><span class="num" data-testid="bench-heading">${bench ? this.#words(bench) : ""}</span></figcaption><div class="plot"></div></figure>
      ${bench ? html`<slam-csv .name=${"bench"} .columns=${() => columnsOf(bench)}></slam-csv>` : ""}
    </details>`;
  }

  protected override draw(make: Plotter): uPlot[] {
    const { bench } = this.store;
    const [speeds, headings] = this.renderRoot.querySelectorAll<HTMLElement>(".plot");
    if (!bench || !this.#open || !speeds || !headings) return [];
    const n = bench.seconds.length;
    const series = (all: Float64Array, i: number): Float64Array => all.subarray(i * n, (i + 1) * n);
    const inDegrees = (all: Float64Array): Float64Array => all.map(degrees);
    return [
      this.#plot(make, speeds, [bench.seconds, ...[2, 3, 0, 1].map((i) => series(bench.speeds, i)), bench.wished], ["odometry", "odometry", "path", "path", "truth"]),
      this.#plot(make, headings, [bench.seconds, inDegrees(series(bench.headings, 1)), inDegrees(series(bench.headings, 0))], ["odometry", "path"]),
    ];
  }

  #plot(make: Plotter, host: HTMLElement, data: uPlot.AlignedData, colours: readonly string[]): uPlot {
    const dashes: Readonly<Record<string, number[]>> = { odometry: [4, 3], truth: [1, 3], path: [] };
    const series = colours.map((colour) => ({ stroke: colourOf(host, `map-${colour}`), width: 1.6, dash: dashes[colour] ?? [], points: { show: false } }));
    return new make({ ...this.frame(host, "s"), series: [{}, ...series] }, data, host);
  }

  /** Heading at the end, with the controller and without. */
  #words(bench: BenchResponse): string {
    const n = bench.seconds.length;
    const [closed, open] = [bench.headings[n - 1] ?? NaN, bench.headings[2 * n - 1] ?? NaN];
    return t`${fixed(degrees(closed), 1)}° against ${fixed(degrees(open), 0)}°`;
  }

  #toggle(event: Event): void {
    this.#open = (event.currentTarget as HTMLDetailsElement).open;
    if (this.#open) this.#ask();
  }

  #change(patch: Partial<BenchTrial>): void {
    this.#trial = { ...this.#trial, ...patch };
    this.requestUpdate();
    this.#ask();
  }

  #ask(): void {
    this.client.send({ kind: "bench", trial: this.#trial });
  }
}

/** Speeds and headings over time, with the controller and without. */
function columnsOf({ seconds, speeds, headings, wished }: BenchResponse): Column[] {
  const n = seconds.length;
  const of = (all: Float64Array, i: number): Float64Array => all.subarray(i * n, (i + 1) * n);
  const speed = (title: string, i: number): Column => ({ title, unit: "m/s", values: of(speeds, i) });
  const heading = (title: string, i: number): Column => ({ title, unit: "°", values: of(headings, i).map(degrees) });
  return [
    { title: "Time", unit: "s", values: seconds }, { title: "Speed, wished", unit: "m/s", values: wished },
    speed("Speed, left, with controller", 0), speed("Speed, right, with controller", 1), speed("Speed, left, without", 2), speed("Speed, right, without", 3),
    heading("Heading, with controller", 0), heading("Heading, without", 1),
  ];
}

customElements.define("slam-bench", SlamBench);
