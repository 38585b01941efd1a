// The buttons at the right of the map.

import { html, nothing, type TemplateResult } from "lit";
import { degrees } from "../angle.js";
import { icons } from "../ui/icons.js";
import { t } from "../words.js";
import type { SlamMap } from "./map_view.js";

/** Uses lit's own `html`, for the same reason as the map. */
export function mapTools(map: SlamMap): TemplateResult {
  const { follow, source, inspecting, editing, layers, method } = map.store;
  return html`<div id="tools" role="group" aria-label=${t("View")}>
      <button class="icon pinch" title=${t("Zoom in (+)")} aria-label=${t("Zoom in")} @click=${() => map.zoom(1.5)}>${icons.plus}</button>
      <button class="icon pinch" title=${t("Zoom out (−)")} aria-label=${t("Zoom out")} @click=${() => map.zoom(1 / 1.5)}>${icons.minus}</button>
      <button class="icon" title=${t("Show everything (0)")} aria-label=${t("Show everything")} @click=${() => map.fit()}>${icons.fit}</button>
      ${map.camera.angle === 0 ? nothing : html`<button class="icon" data-testid="upright" title=${t("Turn the map upright (J)")} aria-label=${t("Turn the map upright")} @click=${() => map.turn()}>${icons.needle(degrees(map.camera.angle))}</button>`}
      <button class="icon" title=${t("Follow the robot (F)")} aria-label=${t("Follow the robot")} aria-pressed=${follow} @click=${() => map.toggleFollow()}>${icons.follow}</button>
      ${source === "sim" ? html`<button class="icon narrow" data-testid="peek-map" title=${t("Truth")} aria-label=${t("Truth")} aria-pressed=${layers.truth} @click=${() => map.store.toggleLayer("truth")}>${layers.truth ? icons.eye : icons.hidden}</button>` : nothing}
      <button class="icon" data-testid="inspect" title=${t("Inspect: click anything for its numbers (I)")} aria-label=${t("Inspect")} aria-pressed=${inspecting} @click=${() => map.toggleInspecting()}>${icons.inspect}</button>
      ${method === "scan-matching" ? html`<button class="icon" data-testid="edit-map" title=${t("Change the map by hand (E)")} aria-label=${t("Change the map by hand")} aria-pressed=${editing !== null} @click=${() => map.toggleEditing()}>${icons.pencil}</button>` : nothing}
    </div>`;
}
