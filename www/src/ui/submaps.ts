// The submaps of the map as a list, to be shown, looked at, saved and removed; and loaded maps,
// with how well they fit.

import { css, nothing, type TemplateResult } from "lit";
import type { AlignedName } from "../protocol/module.js";
import type { LoadedMap } from "../store.js";
import type { Box } from "../view/camera.js";
import { boundsOf } from "../view/submaps.js";
import { html, t } from "../words.js";
import { SlamElement } from "./element.js";
import { fixed, percent } from "./format.js";
import { icons } from "./icons.js";
import { filesOf } from "./input.js";
import { section } from "./style.js";

/** How a loaded map was aligned. */
const BY: Readonly<Record<AlignedName, string>> = {
  walls: "Walls alone told the place",
  landmarks: "Walls fit more than one place; landmarks told which",
  both: "Walls and landmarks told the same place",
};

export class SlamSubmaps extends SlamElement {
  static override styles = [section, css`
    ul { list-style: none; margin: 0 0 8px; padding: 0; max-height: 280px; overflow-y: auto; scrollbar-width: thin; }
    ul.maps { max-height: none; }
    .row { display: flex; gap: 4px; align-items: center; }
    .name { flex: 1; min-width: 0; justify-content: space-between; border-color: transparent; background: transparent; font-weight: 400; font-size: 13px; padding: 0 8px; min-height: 32px; }
    .name:hover { background: var(--hover); }
    .name[aria-expanded="true"] { background: var(--sunk); border-color: var(--line-strong); }
    .name b { font-weight: 500; overflow: hidden; text-overflow: ellipsis; }
    button.icon { width: 32px; min-height: 32px; border-color: transparent; background: transparent; flex: none; }
    button.icon:hover { background: var(--hover); }
    .off { color: var(--muted); }
    dl { margin: 4px 0 8px; padding: 0 8px 0 16px; font-size: 12.5px; }
    dl div { display: flex; justify-content: space-between; gap: 8px; padding: 2px 0; }
    dt { color: var(--muted); }
    dd { margin: 0; text-align: right; flex: none; }
    .two { display: grid; grid-template-columns: 1fr 1fr; gap: 8px; margin-bottom: 8px; }
    .two.own { padding: 0 8px 4px 16px; }
    .two button, .two .button { padding: 0 6px; font-size: 13px; }
    .two label { display: contents; }
    .fit { margin: 0 8px 8px; padding-left: 8px; border-left: 2px solid var(--line); }
    .fit.good { border-color: var(--map-prior); }
    .undo { width: 100%; margin-bottom: 8px; }
    @media (pointer: coarse) { ul { max-height: 400px; } .name, button.icon { min-height: 44px; } button.icon { width: 44px; } }
  `];

  protected override readonly topics = ["run", "frame", "submaps", "view"] as const;

  override render(): TemplateResult | typeof nothing {
    const { store: { method, loadedMaps }, scene: { submaps } } = this;
    const count = method === "scan-matching" ? submaps.count : 0;
    return html`
      <h2 id="submaps">Submaps and loaded maps</h2>
      ${count > 0 ? this.#submaps(count) : html`<p>${method === "scan-matching" ? "The map is made of submaps: the first one comes with the first scans." : "Only scan matching makes its map of submaps. A map that was saved can be loaded beside any run, and laid on what is drawn."}</p>`}
      ${loadedMaps.length > 0 ? html`<ul class="maps" aria-label="Loaded maps">${loadedMaps.map((map) => this.#loaded(map))}</ul>` : nothing}
      <div class="two">
        <label>
          <input type="file" accept=".smap,.slamlab" multiple data-testid="load-map" aria-label="Load a submap (.smap) or a saved map (.slamlab) and lay it on this map" @change=${(e: Event) => void this.client.files.loadMap(filesOf(e))}>
          <span class="button" title="A submap (.smap) or a saved map (.slamlab), laid on this map if it is found where it lies">${icons.open} Load a map…</span>
        </label>
        ${count > 0 ? this.#all() : nothing}
      </div>`;
  }

  /** A button that shows all submaps, or none. */
  #all(): TemplateResult {
    const isShown = this.store.layers.submaps && this.store.hiddenSubmaps.size === 0;
    const hidden = isShown ? this.#numbers() : [];
    return html`<button data-testid="show-submaps" aria-pressed=${isShown} @click=${() => this.client.hideSubmaps(new Set(hidden))}>${isShown ? icons.hidden : icons.eye} ${isShown ? "Hide all" : "Show all"}</button>`;
  }

  #numbers(): number[] {
    return Array.from({ length: this.scene.submaps.count }, (_, i) => i);
  }

  #submaps(count: number): TemplateResult {
    const { undoable } = this.scene.submaps;
    return html`
      <p data-testid="submaps-summary">${count === 1 ? t`The map is made of ${count} submap.` : t`The map is made of ${count} submaps.`} A click goes there.</p>
      <ul aria-labelledby="submaps">${this.#numbers().map((submap) => this.#item(submap, submap === count - 1))}</ul>
      ${undoable === undefined ? nothing : html`<button class="undo" data-testid="undo-removal" title="With its joins to the others. What the robot saw since stays." @click=${() => this.client.send({ kind: "undo-removal" })}>${icons.undo} Put submap ${undoable} back</button>`}`;
  }

  #item(submap: number, isLast: boolean): TemplateResult {
    const { store: { chosenSubmap }, scene: { submaps } } = this;
    const [isChosen, isShown, keyframes] = [chosenSubmap === submap, this.#isShown(submap), submaps.keyframes(submap)];
    return html`<li><div class="row">
      <button class="name" data-testid="submap-${submap}" aria-expanded=${isChosen} @click=${() => this.#choose(submap)}>
        <b>Submap ${submap}</b><span class="num muted">${isLast ? "in the making" : this.#extent(submap)}</span></button>
      ${this.#eye(isShown, t`submap ${submap}`, `submap-eye-${submap}`, isLast, () => this.#show(submap, !isShown))}
      </div>
      ${isChosen ? html`<dl data-testid="submap-details">
        <div><dt>Keyframes</dt><dd class="num">${keyframes}</dd></div>
        ${isLast ? nothing : html`<div><dt>Pieces of wall</dt><dd class="num">${submaps.extent(submap, "surfaces")}</dd></div>`}
        ${submap === 0 ? nothing : html`<div><dt>Joined to submap ${submap - 1}</dt><dd>${submaps.isLoose(submap) ? "loosely: by motion alone" : "by scans in both"}</dd></div>`}
      </dl>
      <div class="two own">
        <button data-testid="save-submap" ?disabled=${isLast} title="Its points and the way through it (.smap)" @click=${() => this.client.send({ kind: "save-submap", submap })}>${icons.save} Save (.smap)</button>
        <button data-testid="remove-submap" ?disabled=${submap >= submaps.removable} title="${submap >= submaps.removable ? "The robot is in it" : "Take it out of the map, with all that was seen in it. It can be put back."}" @click=${() => this.client.send({ kind: "remove-submap", submap })}>${icons.bin} Delete</button>
      </div>` : nothing}
    </li>`;
  }

  #extent(submap: number): string {
    const { submaps } = this.scene;
    return `${fixed(submaps.extent(submap, "width"), 1)} × ${fixed(submaps.extent(submap, "height"), 1)} m`;
  }

  #eye(isShown: boolean, what: string, id: string, isDisabled: boolean, act: () => void): TemplateResult {
    return html`<button class="icon ${isShown ? "" : "off"}" data-testid=${id} ?disabled=${isDisabled} aria-pressed=${isShown} aria-label="Show ${what} on the map" title="${isShown ? "Hide" : "Show"} ${what} on the map" @click=${act}>${isShown ? icons.eye : icons.hidden}</button>`;
  }

  #isShown(submap: number): boolean {
    return this.store.layers.submaps && !this.store.hiddenSubmaps.has(submap);
  }

  /** If none was drawn, only the requested one is drawn. */
  #show(submap: number, shown: boolean): void {
    const { layers, hiddenSubmaps } = this.store;
    const hidden = new Set(layers.submaps ? hiddenSubmaps : this.#numbers());
    if (shown) hidden.delete(submap);
    else hidden.add(submap);
    this.client.hideSubmaps(hidden);
  }

  #choose(submap: number): void {
    const isChosen = this.store.chosenSubmap === submap;
    this.store.set("submaps", { chosenSubmap: isChosen ? null : submap });
    if (isChosen) return;
    if (submap < this.scene.submaps.surfaces.length) this.#show(submap, true);
    this.#lookAt(this.scene.submaps.bounds(submap));
  }

  #lookAt(box: Box | null): void {
    if (box) this.dispatchEvent(new CustomEvent<Box>("look-at", { detail: box, bubbles: true, composed: true }));
  }

  #loaded(map: LoadedMap): TemplateResult {
    const { id, name, picture, path, alignment, shown, isAligning } = map;
    return html`<li data-testid="loaded-map-${id}"><div class="row">
      <button class="name" ?disabled=${!alignment} title=${alignment ? "Go to it on the map" : ""} @click=${() => alignment && this.#lookAt(boundsOf(path ? picture.way : picture.walls, alignment.pose))}>
        <b>${name}</b><span class="num muted">${path ? t`${path.poses} poses` : picture.submaps === 1 ? t`${picture.points} points` : t`${picture.submaps} submaps`}</span></button>
      ${this.#eye(shown && alignment !== null, name, `loaded-eye-${id}`, !alignment, () => this.client.loadedMaps.show(id, !shown))}
      <button class="icon" data-testid="drop-map-${id}" aria-label="Remove ${name} from the list" title="Remove from the list" @click=${() => this.client.loadedMaps.drop(id)}>${icons.close}</button>
      </div>
      <p class="fit ${alignment ? "good" : ""}" data-testid="fit-${id}">${isAligning ? "Looking where it lies…" : this.#fit(map)}</p>
      ${isAligning ? nothing : html`<div class="two own"><button data-testid="align-map-${id}" title="Look where it lies in the map as it is drawn now" @click=${() => this.client.loadedMaps.align(id)}>${icons.again} Align again</button></div>`}
    </li>`;
  }

  #fit({ alignment, error }: LoadedMap): string {
    if (!alignment) return error === "" ? "It is not laid on this run yet." : t`Not laid on the map: ${error}.`.replace("..", ".");
    if (!("agrees" in alignment)) return alignment.by === "time" ? "Laid on the way of the run so that both come closest, pose by pose at the same times." : "It has no times in common with this run: it begins where the map begins.";
    const { agrees, contradicts, residual, landmarks, by } = alignment;
    const shared = landmarks > 0 ? ` ${landmarks === 1 ? t`Both maps have ${landmarks} landmark in common.` : t`Both maps have ${landmarks} landmarks in common.`}` : "";
    return t`It lies on the map: ${percent(agrees)} of its walls stand on walls, ${Math.max(1, Math.round(100 * residual))}\u00a0cm apart on average; at most ${Math.ceil(100 * contradicts)} % of the walls of either map stand where the other is free. ${BY[by]}.${shared}`;
  }
}

customElements.define("slam-submaps", SlamSubmaps);
