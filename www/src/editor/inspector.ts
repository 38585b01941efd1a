// The chosen part in numbers, which can be edited as well as drawn.

import { nothing, type TemplateResult } from "lit";
import { icons } from "../ui/icons.js";
import { isChecked, valueOf } from "../ui/input.js";
import { html } from "../words.js";
import type { Material, Part } from "./drawing.js";
import { middleOf, moved } from "./change.js";
import type { EditorModel } from "./model.js";
import { tidy } from "./snap.js";
import { called, degrees } from "./tools.js";

export const MATERIALS: Readonly<Record<Material, string>> = { opaque: "Wall: reflects well", glass: "Glass: hardly seen", dark: "Dark: seen from near only" };

const radians = (text: string): number => (Number(text) * Math.PI) / 180;

/** A field for a number. Other input is ignored. */
function number(id: string, label: string, unit: string, value: string, step: number, put: (text: string) => void): TemplateResult {
  const change = (event: Event): void => {
    const text = valueOf(event);
    if (text.trim() !== "" && Number.isFinite(Number(text))) put(text);
    else (event.target as HTMLInputElement).value = value;
  };
  return html`<label>${label}, ${unit}<input type="number" step=${step} data-testid="field-${id}" .value=${value} @change=${change}></label>`;
}

const metres = (value: number): string => String(tidy(value));

export function inspector(model: EditorModel): TemplateResult {
  const part = model.chosenPart;
  if (!part) return html`<p class="muted" data-testid="editor-nothing">Nothing is chosen. Take <b>Select</b> and press a part, or go through them with the keys <b>,</b> and <b>.</b></p>`;
  const isMany = part.kind !== "start" && part.kind !== "goal";
  return html`
    <h3 data-testid="editor-chosen">${called(part)}</h3>
    <div class="fields">${place(model, part)}${own(model, part)}</div>
    <div class="row">
      <button data-testid="editor-turn-left" title="Turn by 15° to the left (Q)" @click=${() => model.turn(Math.PI / 12)}>↺ 15°</button>
      <button data-testid="editor-turn-right" title="Turn by 15° to the right (E)" @click=${() => model.turn(-Math.PI / 12)}>↻ 15°</button>
      ${isMany ? html`<button data-testid="editor-duplicate" title="Duplicate (Ctrl + D)" @click=${() => model.duplicate()}>Duplicate</button>` : nothing}
      ${part.kind === "start" ? nothing : html`<button data-testid="editor-delete" title="Delete (Del)" @click=${() => model.remove()}>${icons.bin} Delete</button>`}
    </div>
  `;
}

/** The fields of its middle. */
function place(model: EditorModel, part: Part): TemplateResult {
  const [x, y] = middleOf(part);
  return html`
    ${number("x", "x", "m", metres(x), 0.1, (text) => model.change(moved(part, [Number(text) - x, 0])))}
    ${number("y", "y", "m", metres(y), 0.1, (text) => model.change(moved(part, [0, Number(text) - y])))}
  `;
}

/** The fields that only its kind has. */
function own(model: EditorModel, part: Part): TemplateResult | typeof nothing {
  switch (part.kind) {
    case "goal": return nothing;
    case "start": return number("heading", "heading", "°", degrees(part.value.heading ?? 0), 5, (text) => model.change({ kind: "start", value: { ...part.value, heading: radians(text) } }));
    case "door": {
      const { value } = part;
      return html`<label class="check"><input type="checkbox" data-testid="field-open" .checked=${value.open ?? false} @change=${(event: Event) => model.change({ kind: "door", value: { ...value, open: isChecked(event) } })}>open when the run begins</label>`;
    }
    case "mover": {
      const { value } = part;
      const put = (patch: Partial<typeof value>): void => model.change({ kind: "mover", value: { ...value, ...patch } });
      return html`
        ${number("speed", "speed", "m/s", String(value.speed), 0.1, (text) => put({ speed: Number(text) }))}
        ${number("radius", "radius", "m", String(value.radius), 0.05, (text) => put({ radius: Number(text) }))}
        ${number("pause", "pause", "s", String(value.pause ?? 0), 1, (text) => put({ pause: Number(text) }))}
        <label class="check"><input type="checkbox" data-testid="field-round" .checked=${value.closed ?? false} @change=${(event: Event) => put({ closed: isChecked(event) })}>walks round, not back</label>
      `;
    }
    case "obstacle": {
      const { value } = part;
      const material = html`<label class="wide">surface<select data-testid="field-material" @change=${(event: Event) => model.change({ kind: "obstacle", value: { ...value, material: valueOf(event) as Material } })}>
        ${Object.entries(MATERIALS).map(([name, words]) => html`<option value=${name} .selected=${(value.material ?? "opaque") === name}>${words}</option>`)}
      </select></label>`;
      if (value.shape === "circle") return html`${number("radius", "radius", "m", String(value.radius), 0.05, (text) => model.change({ kind: "obstacle", value: { ...value, radius: Number(text) } }))}${material}`;
      if (value.shape === "polyline") return html`<label class="check"><input type="checkbox" data-testid="field-closed" .checked=${value.closed ?? false} @change=${(event: Event) => model.change({ kind: "obstacle", value: { ...value, closed: isChecked(event) } })}>closed</label>${material}`;
      if (value.shape === "polygon") return material;
      const [width, depth] = value.size;
      return html`
        ${number("width", "width", "m", metres(width), 0.1, (text) => model.change({ kind: "obstacle", value: { ...value, size: [Number(text), depth] } }))}
        ${number("depth", "depth", "m", metres(depth), 0.1, (text) => model.change({ kind: "obstacle", value: { ...value, size: [width, Number(text)] } }))}
        ${number("angle", "angle", "°", degrees(value.angle ?? 0), 5, (text) => model.change({ kind: "obstacle", value: { ...value, angle: radians(text) } }))}
        ${material}
      `;
    }
  }
}
