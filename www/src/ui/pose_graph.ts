// A pose graph from a foreign file (.g2o): as it was in the file, and solved.

import { css, nothing, type TemplateResult } from "lit";
import { downloadAll } from "../save.js";
import { Camera } from "../view/camera.js";
import { readPalette } from "../view/palette.js";
import { html } from "../words.js";
import { SlamElement } from "./element.js";
import { DASH } from "./format.js";
import { icons } from "./icons.js";
import { picture, section } from "./style.js";

export class SlamPoseGraph extends SlamElement {
  static override styles = [section, picture, css`
    canvas { background: var(--map-free); }
    .two { display: grid; grid-template-columns: 1fr 1fr; gap: 8px; }
    i { display: inline-block; width: 18px; height: 0; border-top: 2px solid; vertical-align: middle; }
    i.before { border-top-style: dashed; color: var(--map-odometry); }
    i.after { color: var(--map-estimate); }
  `];

  protected override readonly topics = ["graph"] as const;
  #shown: typeof this.store.solvedGraph = null;

  override connectedCallback(): void {
    super.connectedCallback();
    new ResizeObserver(() => this.#paint()).observe(this);
    for (const topic of ["theme", "tab"] as const) this.store.on(topic, () => this.#paint());
  }

  override render(): TemplateResult | typeof nothing {
    const { solvedGraph } = this.store;
    if (!solvedGraph) return nothing;
    const { name, graph: { poses, edges, chi2Before, chi2After, converged, iterations, leftOut } } = solvedGraph;
    return html`
      <h2 id="pose-graph">Pose graph</h2>
      <p data-testid="graph-says"><b>${name}</b>: ${poses} poses, ${edges} edges. χ² ${chi2(chi2Before)} as the file has them, ${chi2(chi2After)} solved in ${iterations} steps.</p>
      ${converged ? nothing : html`<p class="bad">The last step still mattered: it may not be the best that there is.</p>`}
      ${leftOut.length > 0 ? html`<p>Left out: ${leftOut.join(", ")}.</p>` : nothing}
      <canvas data-testid="graph-picture" role="img" aria-label="The edges of the pose graph, as its file has them and solved"></canvas>
      <p><i class="before"></i> as the file has them <i class="after"></i> solved</p>
      <div class="two">
        <button data-testid="graph-save" @click=${() => this.#save()}>${icons.save} Solved (.g2o)</button>
        <button data-testid="graph-close" @click=${() => this.store.set("graph", { solvedGraph: null })}>${icons.close} Close</button>
      </div>`;
  }

  override updated(): void {
    const { solvedGraph } = this.store;
    if (solvedGraph && solvedGraph !== this.#shown) requestAnimationFrame(() => this.scrollIntoView({ block: "nearest" }));
    this.#shown = solvedGraph;
    this.#paint();
  }

  #save(): void {
    const { solvedGraph } = this.store;
    if (!solvedGraph) return;
    const name = solvedGraph.name.replace(/\.g2o$/i, "-solved.g2o");
    downloadAll([{ name, mime: "text/plain", bytes: solvedGraph.graph.file }]);
  }

  #paint(): void {
    const canvas = this.renderRoot.querySelector("canvas");
    const context = canvas?.getContext("2d");
    const graph = this.store.solvedGraph?.graph;
    if (!canvas || !context || !graph || canvas.clientWidth === 0) return;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const camera = Object.assign(new Camera(), { width: canvas.clientWidth, height: canvas.clientHeight, ratio });
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.clientHeight * ratio);
    Object.assign(camera, camera.fitted(boxOf([graph.before, graph.after])));
    const { css } = readPalette();
    context.scale(ratio, ratio);
    const lines = [[graph.before, css.odometry, [4, 3], 1], [graph.after, css.estimate, [], 1.5]] as const;
    for (const [ends, colour, dash, width] of lines) {
      context.beginPath();
      for (let i = 0; i + 3 < ends.length; i += 4) {
        context.moveTo(...camera.toScreen(ends[i] ?? 0, ends[i + 1] ?? 0));
        context.lineTo(...camera.toScreen(ends[i + 2] ?? 0, ends[i + 3] ?? 0));
      }
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.setLineDash([...dash]);
      context.stroke();
    }
  }
}

/** With enough digits to distinguish one graph from another. */
function chi2(value: number): string {
  return Number.isFinite(value) ? String(Number(value.toPrecision(5))) : DASH;
}

function boxOf(lists: readonly Float32Array[]): { minX: number; minY: number; maxX: number; maxY: number } {
  const box = { minX: Infinity, minY: Infinity, maxX: -Infinity, maxY: -Infinity };
  for (const ends of lists) {
    for (let i = 0; i + 1 < ends.length; i += 2) {
      const [x, y] = [ends[i] ?? 0, ends[i + 1] ?? 0];
      box.minX = Math.min(box.minX, x);
      box.maxX = Math.max(box.maxX, x);
      box.minY = Math.min(box.minY, y);
      box.maxY = Math.max(box.maxY, y);
    }
  }
  return box.minX <= box.maxX ? box : { minX: -1, minY: -1, maxX: 1, maxY: 1 };
}

customElements.define("slam-pose-graph", SlamPoseGraph);
