// The world editor: it lies over the map, and its code is loaded when it is first opened. The
// drawing is a world file; the core decides whether a robot can be in it.

import { LitElement, nothing, type TemplateResult } from "lit";
import type { Client } from "../client.js";
import { faultOf } from "../fault.js";
import { isSharedWorld } from "../link.js";
import type { WorldFault } from "../protocol/module.js";
import { download } from "../save.js";
import { ifAllowed } from "../storage.js";
import type { Store } from "../store.js";
import { icons } from "../ui/icons.js";
import { filesOf, valueOf } from "../ui/input.js";
import { shared } from "../ui/style.js";
import { takeDrops } from "../ui/own_drops.js";
import { html, t } from "../words.js";
import type { WorldDesk } from "../world_desk.js";
import { worldTitle } from "../worlds.js";
import "./board.js";
import type { EditorBoard } from "./board.js";
import { type Drawing, EMPTY, type Material, parsed, written } from "./drawing.js";
import { inspector, MATERIALS } from "./inspector.js";
import { EditorModel } from "./model.js";
import { isOpenWorld } from "./open_world.js";
import { sharedHash, sharedWorld } from "./share.js";
import { layout } from "./style.js";
import { type ToolName, TOOLS } from "./tools.js";

/** The key under which the browser keeps the drawing. */
const KEPT = "slamlab-drawing";
/** Idle time before a drawing is checked and kept, wall milliseconds. */
const REST = 200;
/** A run that has lasted longer is not ended without a question, s. */
const LONG_RUN = 60;

export class SlamEditor extends LitElement implements WorldDesk {
  static override styles = [shared, layout];

  /** Set by the creator of the element. */
  store!: Store;
  client!: Client;
  onClose: () => void = () => {};
  readonly #model = new EditorModel();
  /** The number of the last requested check, and the file to be opened, if it is of one. */
  #number = 0;
  #opening: { number: number; name: string; text: string; skipped: readonly string[] } | null = null;
  /** The built-in world that was asked for, until it comes or something else is opened. */
  #asked: string | null = null;
  /** The number of the last link. */
  #links = 0;
  /** What to do when that file is opened, or refused. */
  #next: (() => void) | null = null;
  #resting = 0;
  #checked: Drawing | null = null;
  #seenThrough: { readonly drawing: Drawing; readonly isOpen: boolean } | null = null;
  #judged: Drawing | null = null;
  /** A run is to begin as soon as the drawing is judged; with a question first, or without. */
  #runsThen: "perhaps" | "surely" | null = null;
  #isFirst = true;
  #isBegun = false;
  #asksToEnd = false;
  #note: { text: string; isBad: boolean } | null = null;

  constructor() {
    super();
    this.#model.on(() => this.#changed());
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.setAttribute("role", "dialog");
    this.setAttribute("aria-label", t("World editor"));
    this.tabIndex = -1;
    this.client.files.desk = this;
    this.#asksToEnd = false;
    if (!this.#isBegun) this.#listen();
    this.#isBegun = true;
    document.addEventListener("keydown", this.#keyOfNobody);
    // If the reader of worlds could not be loaded, it is requested again.
    if (this.#isFirst) this.#openFirst();
  }

  #listen(): void {
    this.store.on("theme", () => this.#board?.recolour());
    this.addEventListener("keydown", (event) => this.#key(event));
    this.addEventListener("keyup", (event) => event.key === "Alt" && this.#holdOff(false));
    takeDrops(this, (files) => void this.client.files.openAll(files));
  }

  /** Opens the first drawing. Nothing can be drawn before, or it would be lost. */
  #openFirst(): void {
    const kept = ifAllowed(() => localStorage.getItem(KEPT));
    const linked = isSharedWorld(location.hash) ? location.hash : null;
    // The last drawing is one undo step behind that of the link.
    this.#next = kept && linked ? () => void this.openLink(linked) : null;
    if (kept) this.open("your last drawing", kept, []);
    else if (linked) void this.openLink(linked);
    else this.#openPresent();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    document.removeEventListener("keydown", this.#keyOfNobody);
    if (this.client.files.desk === this) this.client.files.desk = null;
  }

  /** Opens the world of a link for editing, unless another link is opened meanwhile. */
  async openLink(hash: string): Promise<void> {
    // What was said of an earlier link is no longer true.
    if (this.#links > 0) this.#say("");
    this.#asked = null;
    const link = ++this.#links;
    try {
      const text = await sharedWorld(hash);
      if (link === this.#links) this.open("the world of the link", text, []);
    } catch (error) {
      if (link !== this.#links) return;
      const { text } = faultOf(error);
      this.#say(text, true);
      // The world of the run is opened instead, and brings its own message.
      this.client.refuse(text);
      if (this.#isFirst) this.#openPresent();
    }
  }

  get #board(): EditorBoard | null {
    return this.renderRoot.querySelector("editor-board");
  }

  /** Opens the world of the run behind the editor. */
  #openPresent(): void {
    const { source, started } = this.store;
    if (source !== "sim") return this.open("an empty floor", written(EMPTY), []);
    if (started.worldJson !== null) this.open(started.world, started.worldJson, []);
    else this.#ask(started.world);
  }

  #ask(world: string): void {
    this.#asked = world;
    this.client.send({ kind: "world-file", world });
  }

  openAsked(world: string, text: string): void {
    if (world === this.#asked) this.open(world, text, []);
  }

  open(name: string, text: string, skipped: readonly string[]): void {
    this.#asked = null;
    this.#opening = { number: ++this.#number, name, text, skipped };
    this.client.send({ kind: "check-world", text, number: this.#number });
  }

  judge(number: number, fault: WorldFault | null): void {
    if (number !== this.#number) return;
    const opening = this.#opening;
    if (opening?.number === number) {
      this.#opening = null;
      const next = this.#next;
      this.#next = null;
      if (next) queueMicrotask(next);
      if (fault?.part === "file") {
        this.#say(`${opening.name}: ${fault.text}`, true);
        if (this.#isFirst && !next) this.#openPresent();
        this.#model.notify();
        return;
      }
      const drawing = parsed(opening.text);
      this.#checked = drawing;
      if (this.#isFirst) this.#model.begin(drawing);
      else this.#model.open(drawing);
      if (!this.#isFirst || opening.skipped.length > 0) this.#say(opening.skipped.length > 0 ? t`${opening.name}: left out ${opening.skipped.join(", ")}.` : "", true);
      this.#isFirst = false;
      this.#board?.fit();
    }
    this.#model.fault = fault;
    this.#judged = this.#checked;
    this.#model.notify();
    const runs = this.#runsThen;
    this.#runsThen = null;
    if (runs) this.#run(runs === "surely");
  }

  #say(text: string, isBad = false): void {
    this.#note = text === "" ? null : { text, isBad };
    this.requestUpdate();
  }

  #changed(): void {
    this.requestUpdate();
    clearTimeout(this.#resting);
    if (this.#model.drawing !== this.#checked) this.#resting = setTimeout(() => this.#check(), REST);
  }

  /** Has the drawing checked, and keeps it. */
  #check(): void {
    const { drawing } = this.#model;
    // A file being opened is judged first; it may be the very drawing that is kept.
    if (this.#isFirst || this.#opening || drawing === this.#checked) return;
    this.#checked = drawing;
    const text = written(drawing);
    const isKept = ifAllowed(() => {
      localStorage.setItem(KEPT, text);
      return true;
    });
    if (!isKept) this.#say("This browser has no room for the drawing, or keeps nothing: save it as a file before you leave the page.", true);
    // From here on the link in the address would be that of another drawing.
    if (isSharedWorld(location.hash)) history.replaceState(null, "", location.pathname + location.search);
    this.client.send({ kind: "check-world", text, number: ++this.#number });
  }

  #holdOff(isOff: boolean): void {
    this.#model.isHeldOff = isOff;
  }

  /** Keys pressed while nothing has the focus, as after a click beside the fields. */
  readonly #keyOfNobody = (event: KeyboardEvent): void => {
    if (event.target === document.body) this.#key(event);
  };

  #key(event: KeyboardEvent): void {
    const target = event.composedPath()[0];
    const isField = target instanceof HTMLInputElement || target instanceof HTMLSelectElement;
    if (event.key === "Alt") {
      event.preventDefault();
      return this.#holdOff(true);
    }
    if (event.key === "Escape") {
      event.preventDefault();
      if (this.#model.draft) this.#model.cancel();
      else if (this.#model.chosen) this.#model.choose(null);
      else this.onClose();
      return;
    }
    if (isField || this.#isFirst) return;
    const act = event.ctrlKey || event.metaKey ? this.#withControl(event) : KEYS[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act(this.#model, this.#board);
  }

  #withControl({ key, shiftKey }: KeyboardEvent): Act | undefined {
    const name = key.toLowerCase();
    if (name === "z") return shiftKey ? (model) => model.redo() : (model) => model.undo();
    if (name === "y") return (model) => model.redo();
    if (name === "d") return (model) => model.duplicate();
    return undefined;
  }

  /** Begins a run in the drawing. A run that has lasted for long is not ended without a
      question. */
  #run(isSure: boolean): void {
    const { drawing, fault } = this.#model;
    if (drawing !== this.#judged) {
      this.#runsThen = isSure ? "surely" : "perhaps";
      return this.#check();
    }
    if (fault) return;
    const { source, status } = this.store;
    if (!isSure && (source !== "sim" || (status?.time ?? 0) > LONG_RUN)) {
      this.#asksToEnd = true;
      this.requestUpdate();
      return;
    }
    this.client.start({ world: drawing.name || "my world", worldJson: written(drawing), mode: "explore" });
    this.onClose();
  }

  #save(): void {
    const { drawing } = this.#model;
    download(new Blob([written(drawing)], { type: "application/json" }), `${drawing.name.replace(/[^\w-]+/g, "-") || "world"}.json`);
  }

  async #share(): Promise<void> {
    try {
      const hash = await sharedHash(written(this.#model.drawing));
      history.replaceState(null, "", `${location.pathname}${location.search}${hash}`);
    } catch (error) {
      return this.#say(faultOf(error).text, true);
    }
    try {
      await navigator.clipboard.writeText(location.href);
      this.#say("The link is copied: it opens this drawing.");
    } catch {
      // The clipboard needs permission and TLS.
      this.#say("The link stands in the address of this page: it opens this drawing.");
    }
  }

  #beginWith(event: Event): void {
    const world = valueOf(event);
    (event.target as HTMLSelectElement).value = "";
    if (world === "(empty)") {
      this.#model.open({ ...EMPTY });
      this.#board?.fit();
    } else if (world === "(present)") this.#openPresent();
    else this.#ask(world);
  }

  /** Whether the walls have a gap, by the last check: not while something is moved. */
  #isOpen(): boolean {
    const drawing = this.#checked;
    if (!drawing) return false;
    if (this.#seenThrough?.drawing !== drawing) this.#seenThrough = { drawing, isOpen: isOpenWorld(drawing) };
    return this.#seenThrough.isOpen;
  }

  override render(): TemplateResult {
    const model = this.#model;
    const { tool, draft, fault } = model;
    // Errors of the drawing come first.
    const isOpen = !fault && !draft && this.#isOpen();
    return html`
      <div class="page">
        <div class="head">
          <h2>Draw a world</h2>
          <div class="tools" role="toolbar" ?inert=${this.#isFirst} aria-label="Tools">
            ${(Object.entries(TOOLS) as [ToolName, (typeof TOOLS)[ToolName]][]).map(([name, { title, key }]) => html`
              <button data-testid="tool-${name}" title="${title} (${key})" aria-pressed=${tool === name} @click=${() => model.take(name)}>${title}</button>`)}
          </div>
          <div class="grow"></div>
          <button class="icon" data-testid="editor-undo" aria-label="Undo" title="Undo (Ctrl + Z)" ?disabled=${!model.canUndo} @click=${() => model.undo()}>${icons.undo}</button>
          <button class="icon" data-testid="editor-redo" aria-label="Redo" title="Redo (Ctrl + Shift + Z)" ?disabled=${!model.canRedo} @click=${() => model.redo()}>${REDO}</button>
          <button class="icon" aria-label="Show the whole drawing" title="Show the whole drawing (0)" @click=${() => this.#board?.fit()}>${icons.fit}</button>
          <button class="run" data-testid="editor-run" ?disabled=${fault !== null || this.#isFirst} @click=${() => this.#run(false)}>${icons.play} Run in it</button>
          <button class="icon" data-testid="editor-close" aria-label="Close the editor; the drawing is kept" title="Close; the drawing is kept (Esc)" @click=${() => this.onClose()}>${icons.close}</button>
        </div>
        <editor-board .model=${model} ?inert=${this.#isFirst}></editor-board>
        <div class="side" ?inert=${this.#isFirst}>
          ${this.#asksToEnd ? html`
            <div class="said bad" role="alert" data-testid="editor-ends">
              <p>The present run and the map that it has drawn end with it.</p>
              <div class="row">
                <button class="run" data-testid="editor-run-surely" @click=${() => this.#run(true)}>Begin in the drawing</button>
                <button @click=${() => { this.#asksToEnd = false; this.requestUpdate(); }}>Keep the run</button>
              </div>
            </div>` : nothing}
          ${fault ? html`
            <div class="said bad" role="alert">
              <p data-testid="editor-fault">${fault.text[0]?.toUpperCase()}${fault.text.slice(1)}.</p>
              ${model.wrong ? html`<div class="row"><button data-testid="editor-show-fault" @click=${() => model.showWrong()}>Show it</button></div>` : nothing}
            </div>` : nothing}
          ${this.#note ? html`<p class="said ${this.#note.isBad ? "bad" : ""}" role="status" data-testid="editor-note">${this.#note.text}</p>` : nothing}
          ${isOpen ? html`<p class="said" role="status" data-testid="editor-open">The walls around the robot have a gap: it can leave the building, and explore without an end.</p>` : nothing}
          <p data-testid="editor-hint"><b>${TOOLS[tool].title}.</b> ${TOOLS[tool].words}</p>
          ${draft && TOOLS[draft.tool].takes === "many" ? html`
            <div class="row">
              <button data-testid="editor-done" @click=${() => model.finish(false)}>Done</button>
              ${draft.points.length > 2 ? html`<button data-testid="editor-close-shape" @click=${() => model.finish(true)}>Join to the first</button>` : nothing}
              <button data-testid="editor-cancel" @click=${() => model.cancel()}>Cancel</button>
            </div>` : nothing}
          ${tool === "wall" || tool === "box" || tool === "post" ? html`
            <label>Surface of what is drawn
              <select data-testid="editor-material" @change=${(e: Event) => { model.material = valueOf(e) as Material; model.notify(); }}>
                ${Object.entries(MATERIALS).map(([name, words]) => html`<option value=${name} .selected=${model.material === name}>${words}</option>`)}
              </select>
            </label>` : nothing}
          <label class="check"><input type="checkbox" data-testid="editor-snap" .checked=${model.snaps} @change=${(e: Event) => { model.snaps = (e.target as HTMLInputElement).checked; }}><span>Snap to ends, right angles and the grid <span class="muted">(N; Alt holds it off)</span></span></label>
          ${tool === "select" ? html`<hr><div>${inspector(model)}</div>` : nothing}
          <hr>
          <label>Name<input type="text" maxlength="60" data-testid="editor-name" .value=${this.#isFirst ? "" : model.drawing.name} @change=${(e: Event) => model.rename(valueOf(e))}></label>
          <label>Begin with
            <select data-testid="editor-begin" @change=${(e: Event) => this.#beginWith(e)}>
              <option value="" selected>another world…</option>
              <option value="(empty)">an empty floor</option>
              ${this.store.source === "sim" ? html`<option value="(present)">the world of this run</option>` : nothing}
              ${this.store.offer.worlds.map((world) => html`<option value=${world}>${worldTitle(world)}</option>`)}
            </select>
          </label>
          <div class="row">
            <label class="file"><input type="file" data-testid="editor-file" multiple aria-label="Open a world (.json), a floor plan (.svg) or a map" @change=${(e: Event) => void this.client.files.openAll(filesOf(e))}><span class="button">${icons.open} Open…</span></label>
            <button data-testid="editor-save" title="Save the world as a file (.json)" @click=${() => this.#save()}>${icons.save} Save</button>
            <button data-testid="editor-share" title="Copy a link that opens this drawing" @click=${() => void this.#share()}>${icons.link} Link</button>
          </div>
        </div>
      </div>
    `;
  }
}

type Act = (model: EditorModel, board: EditorBoard | null) => void;

const REDO = html`<svg viewBox="0 0 24 24" aria-hidden="true"><path d="M15.5 5 20 9.5 15.5 14"/><path d="M19.5 9.5H10a5 5 0 0 0 0 10h3"/></svg>`;

const KEYS: Readonly<Record<string, Act>> = {
  ...Object.fromEntries((Object.entries(TOOLS) as [ToolName, { key: string }][]).map(([name, { key }]) => [key.toLowerCase(), (model: EditorModel, board: EditorBoard | null) => {
    model.take(name);
    board?.canvas.focus({ preventScroll: true });
  }])),
  delete: (model) => model.remove(),
  backspace: (model) => (model.draft ? model.undo() : model.remove()),
  q: (model) => model.turn(Math.PI / 12),
  e: (model) => model.turn(-Math.PI / 12),
  ",": (model) => model.chooseNext(-1),
  ".": (model) => model.chooseNext(1),
  n: (model) => {
    model.snaps = !model.snaps;
    model.notify();
  },
  "+": (_, board) => board?.zoom(1.25),
  "=": (_, board) => board?.zoom(1.25),
  "-": (_, board) => board?.zoom(0.8),
  0: (_, board) => board?.fit(),
};

customElements.define("slam-editor", SlamEditor);
