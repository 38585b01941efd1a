// A wall of the line map: its numbers, what the robot should see of it, how the last scan was
// matched to it, and what would change that match.

import { nothing, type TemplateResult } from "lit";
import { degrees } from "../angle.js";
import { type Candidate, FLIP, FLIP_STRIDE, type Inspection, LANDMARK, LANDMARK_STRIDE, LINE, LINE_STRIDE, type Sighting } from "../protocol/module.js";
import { equals, fn, formula, hat, id, op, row, sup, text } from "../registration/formula.js";
import { fixed } from "../ui/format.js";
import { DECISION_WORDS } from "../ui/match_words.js";
import { html, t } from "../words.js";
import { segment } from "./outlines.js";
import { times } from "./poses.js";
import { type Formula, GONE, type Known, type Told } from "./told.js";
import { angle, lineEquation, matrix, metres, number } from "./words.js";

export function line(wall: number, { store, scene: { lines, landmarks, status }, examined }: Known): Told {
  const first = rowOf(lines, LINE_STRIDE, LINE.id, wall);
  const title = t`Wall ${wall}`;
  if (first === null) return { title, words: GONE, figures: [], outline: [] };
  const at = (name: keyof typeof LINE): number => lines[first + LINE[name]] ?? NaN;
  const [alpha, r, x1, y1, x2, y2] = [at("alpha"), at("r"), at("x1"), at("y1"), at("x2"), at("y2")];
  const [sigmaAlpha, sigmaR] = [Math.sqrt(at("varAlpha")), Math.sqrt(at("varR"))];
  const counted = rowOf(landmarks, LANDMARK_STRIDE, LANDMARK.id, wall);
  const seen = counted === null ? NaN : (landmarks[counted + LANDMARK.confidence] ?? NaN) + 1;
  const formulas: Formula[] = [{
    general: formula(row(id("x"), fn("cos"), id("α"), op("+"), id("y"), fn("sin"), id("α"), equals(), id("r"))),
    numbers: lineEquation(alpha, r),
    source: "TDK 2016 § 3.2: the line by its normal, m",
  }];
  if (status) {
    const { x, y, heading } = status;
    formulas.push({
      general: formula(row(hat(id("z")), equals(), op("("), id("α"), op("−"), id("θ"), op(","), id("r"), op("−"), id("x"), fn("cos"), id("α"), op("−"), id("y"), fn("sin"), id("α"), op(")"))),
      numbers: formula(row(op("("), number(degrees(Math.atan2(Math.sin(alpha - heading), Math.cos(alpha - heading)))), id("°"), op(","), number(r - x * Math.cos(alpha) - y * Math.sin(alpha)), text("\u00a0m"), op(")"))),
      source: "TDK 2016 eq. (3.5): where the robot expects it now, in its own frame",
    });
  }
  const inspection = examined?.inspection ?? null;
  return {
    title,
    fate: at("confirmed") ? "Confirmed" : "Not confirmed",
    figures: [
      ["α", angle(alpha, 2), "line-alpha", "Direction of its normal, from the x axis of the map to the left"],
      ["r", metres(r), "line-r", "Distance from where the map begins"],
      ["σα", angle(sigmaAlpha, 2), "line-sigma-alpha", "Standard deviation"],
      ["σr", metres(sigmaR), "line-sigma-r", "Standard deviation"],
      ["Correlation", fixed(at("covAlphaR") / (sigmaAlpha * sigmaR), 2), "line-correlation", "Of the errors of α and r"],
      ["Known part", metres(Math.hypot(x2 - x1, y2 - y1)), "line-length", "From end to end of what was seen"],
      ["Seen", times(seen), "line-seen", "Its confidence grows by 1 each time it is found again (Pilch 2016 § 3.5.2)"],
    ],
    formulas: [...formulas, ...matched(wall, inspection)],
    more: store.method === "line-ekf" ? association(wall, inspection) : html``,
    outline: segment(x1, y1, x2, y2),
  };
}

/** The row that has `wanted` at `place`: where it begins. */
function rowOf(rows: Float32Array | Float64Array, stride: number, place: number, wanted: number): number | null {
  for (let row = 0; row + stride <= rows.length; row += stride) if (rows[row + place] === wanted) return row;
  return null;
}

const winnerOf = (wall: number, sighting: Sighting): Candidate | undefined => (sighting.decision === "matched" && sighting.wall === wall ? sighting.candidates.find((each) => each.wall === wall) : undefined);

/** d² of the last scan's line that was matched to it. */
function matched(wall: number, inspection: Inspection | null): Formula[] {
  const own = inspection?.sightings.map((sighting) => winnerOf(wall, sighting)).find((candidate) => candidate !== undefined);
  if (!own || !inspection) return [];
  const { deltaAlpha, deltaR, sigmaAlpha, sigmaR, covariance, d2 } = own;
  return [{
    general: formula(row(sup(id("d"), "2"), equals(), sup(id("v"), "T"), sup(id("Z"), "−1"), id("v"), op("≤"), sup(id("g"), "2"))),
    numbers: [
      formula(row(id("v"), equals(), matrix([[deltaAlpha], [deltaR]]), op(","), id("Z"), equals(), matrix([[sigmaAlpha ** 2, covariance], [covariance, sigmaR ** 2]]))),
      formula(row(sup(id("d"), "2"), equals(), number(d2), op(d2 <= inspection.gate ? "≤" : ">"), number(inspection.gate))),
    ],
    source: "TDK 2016 eq. (3.10), (3.12), (3.13): the innovation v (rad, m) of the last scan, and its covariance Z",
  }];
}

/** The outcome for the lines of the last scan that were compared with it. */
function association(wall: number, inspection: Inspection | null): TemplateResult {
  if (!inspection) return html``;
  const own = inspection.sightings.filter((s) => s.wall === wall);
  const rivals = inspection.sightings.filter((s) => s.wall !== wall && s.candidates.some((c) => c.wall === wall));
  if (own.length + rivals.length === 0) return html`<h3>The last scan</h3><p data-testid="line-unseen">It is not in the last scan, nor near any line of it.</p>`;
  return html`<h3>The last scan</h3>
    ${own.map((sighting) => html`<p data-testid="line-match">A line was ${DECISION_WORDS[sighting.decision]}: ${candidates(sighting)}.</p>${flips(sighting)}`)}
    ${rivals.map((sighting) => html`<p data-testid="line-rival">Another line was compared with it and ${DECISION_WORDS[sighting.decision]}${sighting.decision === "matched" ? t` as wall ${sighting.wall}` : ""}: ${candidates(sighting)}.</p>`)}
    ${own.some(({ decision }) => decision === "matched") ? html`<p class="muted">Each by itself, all else the same. The lines of a scan are matched together, so the others may hold this one where it alone would flip (Neira & Tardós 2001).</p>` : nothing}`;
}

function candidates({ candidates: all }: Sighting): string {
  return all.length === 0 ? "no known wall has its direction" : all.map(({ wall, d2 }) => t`d² to wall ${wall} is ${fixed(d2, 1)}`).join(", ");
}

const AXES = [["turned to the right by", "turned to the left by"], ["nearer by", "farther by"]] as const;

/** What would change this match: the nearest values on either side, direction and distance. */
function flips({ flips: rows, decision }: Sighting): TemplateResult {
  if (decision !== "matched") return html``;
  const at = (row: number, place: number): number => rows[row * FLIP_STRIDE + place] ?? NaN;
  const told = AXES.flatMap((sides, axis) => sides.map((words, side) => {
    const row = 2 * axis + side;
    const [shift, rival] = [Math.abs(at(row, FLIP.shift)), at(row, FLIP.wall)];
    if (Number.isNaN(shift)) return html``;
    const by = axis === 0 ? angle(shift, 2) : metres(shift);
    return html`<li><b class="num">${words} ${by}</b>: ${Number.isNaN(rival) ? "it would leave the gate" : t`wall ${rival} would explain it as well`}</li>`;
  }));
  return html`<h4>What would flip this match: had the line been seen</h4><ul data-testid="flips">${told}</ul>`;
}

