// The matching explained: the lines of the last scan, what each was compared with, and the outcome.

import { css, nothing, type TemplateResult } from "lit";
import { degrees } from "../angle.js";
import type { Candidate, Decision, Gate, Inspection, Sighting } from "../protocol/module.js";
import type { Column } from "../csv.js";
import { html, svg, t } from "../words.js";
import "./csv_button.js";
import { SlamElement } from "./element.js";
import { fixed } from "./format.js";
import { DECISION_WORDS } from "./match_words.js";

const GATE_WORDS: Readonly<Record<Gate, string>> = {
  match: "inside the gate",
  near: "between the gates",
  far: "another wall",
  beyond: "same line, another part",
};

export class SlamMatches extends SlamElement {
  static override styles = css`
    :host { margin-top: 16px; }
    header { display: flex; justify-content: space-between; align-items: center; gap: 8px; margin-bottom: 6px; }
    header button { min-height: 28px; padding: 0 10px; font-size: 12.5px; }
    p { margin: 0 0 8px; font-size: 12.5px; color: var(--muted); }
    ul { list-style: none; margin: 0; padding: 0; }
    li > button { width: 100%; justify-content: start; white-space: normal; text-align: left; font-weight: 400; font-size: 13px; line-height: 1.3; border-color: transparent; background: transparent; padding: 4px 8px; min-height: 32px; }
    li > button:hover { background: var(--hover); }
    .dot { width: 9px; height: 9px; border-radius: 50%; flex: none; border: 2px solid var(--muted); }
    .matched { border-color: var(--good); background: var(--good); }
    .added { border-color: var(--map-truth); background: var(--map-truth); }
    .card { padding: 10px 12px; margin-bottom: 8px; border: 1px solid var(--line); border-radius: 12px; background: var(--sunk); font-size: 13px; }
    .card b { font-weight: 600; }
    table { width: 100%; border-collapse: collapse; margin-top: 6px; font-size: 12.5px; }
    th { text-align: left; font-weight: 500; color: var(--muted); padding: 2px 0; }
    td { padding: 3px 6px 3px 0; border-top: 1px solid var(--line); vertical-align: top; }
    td.num, th.num { text-align: right; white-space: nowrap; }
    tr.winner td { font-weight: 600; }
    td small { display: block; font-weight: 400; color: var(--muted); font-size: 11.5px; }
    .ruler { width: 100%; height: 34px; margin-top: 6px; overflow: visible; stroke-width: 1.5; }
    .ruler line { stroke: var(--line-strong); }
    .ruler text { fill: var(--muted); stroke: none; font: 500 11px/1 var(--mono); text-anchor: middle; }
    .ruler circle { fill: var(--muted); stroke: var(--sunk); }
    .ruler circle.winner { fill: var(--good); }
    @media (pointer: coarse) { li > button { min-height: 44px; } }
  `;

  protected override readonly topics = ["inspection", "spot", "run"] as const;

  override render(): TemplateResult {
    const { inspection, spot, method } = this.store;
    this.toggleAttribute("hidden", method !== "line-ekf");
    const sightings = inspection?.sightings ?? [];
    const own = sightings.filter((s) => s.wall === spot.pinned);
    const rival = sightings.filter((s) => s.wall !== spot.pinned && s.candidates.some((c) => c.wall === spot.pinned));
    return html`<header><h2>Why this match?</h2>${spot.pinned === null ? nothing : html`<button data-testid="unpin" @click=${() => this.store.point({ pinned: null })}>All lines</button>`}</header>
      ${spot.pinned === null ? this.#all(sightings) : this.#wall(spot.pinned, [...own, ...rival], inspection)}`;
  }

  #all(sightings: readonly Sighting[]): TemplateResult {
    const count = (decision: Decision): number => sightings.filter((s) => s.decision === decision).length;
    const dropped = sightings.length - count("matched") - count("added");
    return html`<p data-testid="matches">The last scan shows ${sightings.length} lines: ${count("matched")} recognised, ${count("added")} new, ${dropped} not used. Choose one here, or click a wall on the map.</p>
      ${this.#points()}
      <ul>${sightings.map((s) => {
        const wall = s.wall ?? s.candidates[0]?.wall ?? null;
        return html`<li><button ?disabled=${wall === null} @click=${() => this.store.point({ pinned: wall })}
          @pointerenter=${() => this.store.point({ hovered: wall === null ? [] : [wall] })} @pointerleave=${() => this.store.point({ hovered: [] })}>
          <i class="dot ${s.decision}"></i><span>${s.wall === null ? "" : html`wall <b>${s.wall}</b> `}${DECISION_WORDS[s.decision]}${s.decision === "matched" ? html` <span class="muted num">d² ${fixed(distanceOf(s), 1)}</span>` : ""}</span></button></li>`;
      })}</ul>`;
  }

  /** The outcome for corners and posts, if they are landmarks. */
  #points(): TemplateResult | typeof nothing {
    const [seen = 0, recognised = 0, added = 0] = this.store.inspection?.pointsSeen ?? [];
    if (seen === 0) return nothing;
    return html`<p data-testid="points-matched">And ${seen} corners and posts: ${recognised} recognised, ${added} new, ${seen - recognised - added} not used.</p>`;
  }

  #wall(wall: number, sightings: readonly Sighting[], inspection: Inspection | null): TemplateResult {
    if (!inspection || sightings.length === 0) {
      return html`<div class="card" data-testid="match"><b>Wall ${wall}</b> is not in the last scan, nor near any line of it.</div>`;
    }
    return html`${sightings.map((s) => html`<div class="card" data-testid="match">
      <b>${s.wall === null ? "A line of the last scan" : t`Wall ${s.wall}`}</b>: ${DECISION_WORDS[s.decision]}.
      ${s.candidates.length === 0 ? html`<p>No known wall has its direction.</p>` : html`${this.#ruler(s, inspection)}${this.#table(s)}`}
    </div>`)}`;
  }

  /** Squared distances on one axis with both gates. */
  #ruler(s: Sighting, { gate, newGate }: Inspection): TemplateResult {
    const most = newGate * 1.2;
    const at = (d2: number): string => `${(100 * Math.min(d2, most)) / most}%`;
    const mark = (d2: number, text: string): TemplateResult<2> => svg`<line x1=${at(d2)} x2=${at(d2)} y1="2" y2="16"/><text x=${at(d2)} y="29">${text}</text>`;
    return html`<svg class="ruler" aria-hidden="true">
      <line x1="0" x2="100%" y1="16" y2="16"/>${mark(gate, t`gate ${fixed(gate, 1)}`)}${mark(newGate, t`new ${fixed(newGate, 0)}`)}
      ${s.candidates.map((c) => svg`<circle cx=${at(c.d2)} cy="16" r="4.5" class=${isWinner(s, c) ? "winner" : ""}/>`)}
    </svg>`;
  }

  #table(s: Sighting): TemplateResult {
    return html`<table>
      <thead><tr><th>candidate</th><th class="num">d²</th><th class="num">Δα</th><th class="num">Δr</th></tr></thead>
      <tbody>${s.candidates.map((c) => html`<tr class=${isWinner(s, c) ? "winner" : ""} @pointerenter=${() => this.store.point({ hovered: [c.wall] })} @pointerleave=${() => this.store.point({ hovered: [] })}>
        <td>wall ${c.wall}${isWinner(s, c) ? " ✓" : ""}<small>${GATE_WORDS[c.gate]}${c.gap > 0 ? t`, ${fixed(c.gap, 2)} m apart` : ""}</small></td>
        <td class="num">${fixed(c.d2, 1)}</td>
        <td class="num">${fixed(degrees(c.deltaAlpha), 1)}°<small>σ ${fixed(degrees(c.sigmaAlpha), 1)}°</small></td>
        <td class="num">${fixed(100 * c.deltaR, 1)} cm<small>σ ${fixed(100 * c.sigmaR, 1)} cm</small></td>
      </tr>`)}</tbody>
    </table>
    <slam-csv .name=${"candidates"} .columns=${() => columnsOf(s)}></slam-csv>`;
  }
}

function columnsOf({ candidates }: Sighting): Column[] {
  const numbers = (title: string, unit: string, value: (candidate: Candidate) => number): Column => ({ title, unit, values: candidates.map(value) });
  return [
    numbers("Wall", "", ({ wall }) => wall), numbers("d²", "", ({ d2 }) => d2), numbers("Δα", "°", ({ deltaAlpha }) => degrees(deltaAlpha)), numbers("σ of Δα", "°", ({ sigmaAlpha }) => degrees(sigmaAlpha)),
    numbers("Δr", "m", ({ deltaR }) => deltaR), numbers("σ of Δr", "m", ({ sigmaR }) => sigmaR), numbers("Gap", "m", ({ gap }) => gap),
  ];
}

function isWinner(s: Sighting, c: Candidate): boolean {
  return s.decision === "matched" && s.wall === c.wall;
}

function distanceOf(s: Sighting): number {
  return s.candidates.find((c) => isWinner(s, c))?.d2 ?? NaN;
}

customElements.define("slam-matches", SlamMatches);
