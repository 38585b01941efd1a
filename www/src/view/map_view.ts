// The map: three sheets with a camera that can be panned, zoomed, turned, fitted, and tied to the
// robot. They are drawn with WebGL2, or on 2D canvases if there is none.
//
// | sheet | drawn |
// |---|---|
// | overlays: the robot, what it sees and what it plans | for each picture, unless that takes long |
// | record: trails, submaps, closures | when they have grown, some times a second; or when the view changes |
// | ground: grid and rules | when they change; only the changed part, while the view is the same |
//
// Record and ground take long, and overlays may: at most one slow sheet is drawn for a picture. In
// another order of layers, more is drawn on the quicker sheets (`parts.ts`).

import { html, nothing, type TemplateResult } from "lit";
import { sendByClick } from "../errand.js";
import { withCorner } from "../fence.js";
import { SlamElement } from "../ui/element.js";
import { t } from "../words.js";
import { type Box, Camera, NEAR, union } from "./camera.js";
import { CanvasBulk } from "./canvas_bulk.js";
import { CanvasSurface } from "./canvas_surface.js";
import { freeRoom } from "./free_room.js";
import { listenToGestures } from "./gestures.js";
import { Graphics } from "./graphics.js";
import { isInDoubt, ruleStep } from "./layers/grid.js";
import type { Brush } from "./layers/layer.js";
import { mapStyle } from "./map_style.js";
import { mapTools } from "./map_tools.js";
import { type Palette, readPalette } from "./palette.js";
import { drawSheet } from "./parts.js";
import type { Bulk, Pencil } from "./painter.js";
import type { Scene } from "./scene.js";
import { Sheets } from "./sheets.js";
import { SHEETS, type Surface } from "./surface.js";
import { isDoorOpen, KEY_REACH, REACH, roomAt, type Sight, targetAt, thingsAt } from "./things.js";
import type { Tiles } from "./tiles.js";
import { placeWords } from "./words.js";

/** Rate of the camera's approach to its target: it covers 1 - e^-rate of the way in a second. */
const EASE = 6;
const REFIT_MILLIS = 300;
/** The view is fitted again if it would move by this, CSS pixels, or stretch by this part. A fitted
    view leaves more room than that beside the map. */
const REFIT_SHIFT = 8;
const REFIT_STRETCH = 0.02;
/** Milliseconds between redraws of the record sheet: during a run, and while the map glides. */
const RECORD_MILLIS = 200;
const GLIDING_MILLIS = 30;
/** Longest wait for an idle page before the map is drawn with WebGL2, milliseconds. */
const LONGEST_IDLE = 1000;
/** A map turned by less than this counts as upright, rad. */
const LEAST_ANGLE = 1e-3;
/** Distance from the card at which an uncovered place appears, CSS pixels. */
const UNCOVERED = 40;

/** The two places of an edit in progress, map frame, m. */
type Draft = NonNullable<NonNullable<Brush["edit"]>["draft"]>;

export class SlamMap extends SlamElement {
  static override styles = mapStyle;

  protected override readonly topics = ["view", "run"] as const;
  readonly camera = new Camera();
  /** The map whose view this one copies, if runs are shown side by side. */
  lead: SlamMap | null = null;
  /** Scenes of other runs, included when everything is shown. */
  others: readonly Scene[] = [];

  /** The view keeps showing everything that is known. */
  #auto = true;
  #fitAt = -Infinity;
  #target: { x: number; y: number; scale: number } | null = null;
  #palette: Palette | null = null;
  #sheets: Sheets | null = null;
  #graphics: Graphics | null = null;
  /** Length of the trail on the record sheet. */
  #recordedTrail = 0;
  /** Scale shown by the bar below. */
  #ruledScale = NaN;
  #lastTick = 0;
  #inCycle = false;
  #hasTable = false;
  /** Grows with every change of what is highlighted or chosen. */
  #spotVersion = 0;
  #still = matchMedia("(prefers-reduced-motion: reduce)");
  /** Pictures drawn in the last second, for display and for tests. */
  frames = 0;
  #frameTimes: number[] = [];

  override connectedCallback(): void {
    super.connectedCallback();
    this.#graphics?.begin();
    this.#startTicking();
    this.store.on("theme", () => (this.#palette = null));
    this.store.on("contest", () => {
      this.#spotVersion += 1;
      // With its table the panel covers more of a phone's map.
      const hasTable = this.store.contest.found !== null;
      if (hasTable !== this.#hasTable) requestAnimationFrame(() => this.#resize());
      this.#hasTable = hasTable;
    });
    for (const topic of ["rooms", "spot", "inspection", "chosen", "quality", "submaps"] as const) this.store.on(topic, () => (this.#spotVersion += 1));
    for (const topic of ["tab", "tour", "exhibit", "lesson", "last", "chosen"] as const) this.store.on(topic, () => requestAnimationFrame(() => this.#resize()));
    // The strip of the cycle takes room from a phone's map.
    this.store.on("run", () => {
      if (this.#draft && !this.store.editing) this.#setDraft(null);
      this.#spotVersion += 1;
      if (this.store.inCycle === this.#inCycle) return;
      this.#inCycle = this.store.inCycle;
      requestAnimationFrame(() => this.#resize());
    });
  }

  override firstUpdated(): void {
    listenToGestures(this.#element("pad"), {
      pan: (dx, dy) => this.#leader.#pan(dx, dy),
      zoom: (factor, x, y) => {
        const { store, camera } = this.#leader;
        if (store.follow) [x, y] = camera.toScreen(camera.x, camera.y);
        else this.#leader.#release();
        camera.zoomAt(factor, x, y);
      },
      turn: (angle, around) => {
        const { store, camera } = this.#leader;
        this.#leader.#turnAt(angle, around && !store.follow ? around : camera.toScreen(camera.x, camera.y));
      },
      tap: (x, y) => this.#choose(...this.camera.toMap(x, y)),
      draws: () => this.store.editing !== null,
      draw: (from, to) => this.#setDraft({ from: this.camera.toMap(...from), to: this.camera.toMap(...to) }),
      drawn: (isDone) => this.#endDraft(isDone),
      hover: (x, y) => this.#hover(x, y),
      leave: () => {
        this.#element("hover").toggleAttribute("hidden", true);
        this.#light(null);
      },
    });
    this.#graphics = new Graphics(this.#element("gl") as HTMLCanvasElement, this.store, {
      came: (surface) => this.#drawOn(surface, ""),
      went: (why, isLoss) => {
        this.#drawOn(null, why);
        if (isLoss) this.store.note({ time: this.scene.status?.time ?? 0, level: "warn", text: t`The map is drawn with Canvas 2D for now: ${why}.` });
      },
    });
    const resized = new ResizeObserver(() => this.#resize());
    resized.observe(this);
    // The cards get their text only after the event, and so change their size later.
    for (const told of document.querySelectorAll("#inspector, #tip, #tour")) resized.observe(told);
    this.#sheets = new Sheets(this.#canvases());
    this.#resize();
    // The first picture does not wait for a graphics card.
    const begin = (): void => void (this.isConnected && this.#graphics?.begin());
    if ("requestIdleCallback" in window) requestIdleCallback(begin, { timeout: LONGEST_IDLE });
    else setTimeout(begin, LONGEST_IDLE);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.#graphics?.end();
    this.#drawOn(null, "");
  }

  /** Uses lit's own `html`: when the language changes, the canvases stay, and only their labels
      change. */
  override render(): TemplateResult {
    const { source, editing, fence, inspecting } = this.store;
    return html`
      <canvas id="gl" hidden></canvas>
      <canvas id="ground"></canvas>
      <canvas id="record"></canvas>
      <canvas id="overlays"></canvas>
      <div
        id="pad" class=${editing || fence ? "draws" : inspecting ? "inspects" : source === "replay" ? "plain" : ""} tabindex="0" role="application" data-testid=${this.lead ? "map-beside" : "map"}
        aria-label=${t("Map. Arrow keys drive the robot, Shift with arrow keys moves the view, Q turns it, J turns it upright, plus and minus zoom, Enter sends the robot to the middle of the view, tells what lies there while things are inspected (I), sets start or goal there while the planners are compared, or puts a corner of the geofence there while that is drawn.")}
        @keydown=${this.#key}
      ></div>
      <svg id="cross" viewBox="0 0 25 25" aria-hidden="true"><path d="M12.5 1v8m0 7v8M1 12.5h8m7 0h8" stroke="currentColor" stroke-width="2"/></svg>
      ${this.lead ? nothing : mapTools(this)}
      <div id="foot"><div id="hover" data-testid="hover" hidden></div><div id="scale"><div id="bar"></div><span id="length"></span></div></div>
    `;
  }

  zoom(factor: number): void {
    if (!this.store.follow) this.#auto = false;
    this.#target = null;
    const [x, y] = this.camera.toScreen(this.camera.x, this.camera.y);
    this.camera.zoomAt(factor, x, y);
  }

  /** Shows everything, and keeps doing so while the map grows. */
  fit(): void {
    this.store.set("view", { follow: false });
    this.#auto = true;
    this.#fitAt = -Infinity;
  }

  /** Called with each new rotation of the map, rad. */
  onTurn: (angle: number) => void = () => {};

  /** Turns the map by an angle, to the left, rad; by default to upright. */
  turn(angle = -this.camera.angle): void {
    this.#turnAt(angle, this.camera.toScreen(this.camera.x, this.camera.y));
  }

  #turnAt(angle: number, around: readonly [number, number]): void {
    this.camera.turnAt(angle, ...around);
    // Exactly upright if nearly so.
    if (Math.abs(this.camera.angle) < LEAST_ANGLE) this.camera.angle = 0;
    this.#fitAt = -Infinity;
    this.onTurn(this.camera.angle);
    this.requestUpdate();
  }

  /** Shows a part of the map, and stays there. */
  lookAt(box: Box): void {
    this.#release();
    this.#target = this.camera.fitted(box);
  }

  toggleFollow(): void {
    if (!this.store.follow) {
      this.stayWithRobot(this.camera.scale < 60 ? NEAR : this.camera.scale);
      return;
    }
    this.#release();
  }

  /** Follows the robot, at so many pixels per metre. */
  stayWithRobot(scale: number): void {
    this.store.set("view", { follow: true });
    this.#auto = false;
    this.#target = { x: this.camera.x, y: this.camera.y, scale };
  }

  /** Starts or ends editing the map by drawing on it. */
  toggleEditing(): void {
    if (this.store.method === "scan-matching") this.store.set("run", { editing: this.store.editing ? null : "erase", inspecting: false });
    else this.store.set("toast", { toast: { level: "info", text: "Only a map of scan matching can be changed by hand: choose that method under Run." } });
  }

  /** A new run: drops the old picture at once, and the view, unless it has to stay. */
  restart(keepsView: boolean): void {
    if (!keepsView) {
      if (!this.store.follow) this.#auto = true;
      this.#fitAt = -Infinity;
    }
    this.#jump = true;
    this.#sheets?.forget();
  }

  #jump = true;

  get #leader(): SlamMap {
    return this.lead ?? this;
  }

  #pan(dx: number, dy: number): void {
    this.#release();
    this.camera.panBy(dx, dy);
  }

  #release(): void {
    this.#auto = false;
    this.#target = null;
    if (this.store.follow) this.store.set("view", { follow: false });
  }

  /** While inspecting: describes what lies there, and at the next click on the same place what lies
      under it. Otherwise, in this order: a torn place; a wall, while the filter's tab is open; a
      door; a loop closure or a join; a room, if rooms are shown; or a goal for the robot
      (`errand.ts`). */
  #choose(x: number, y: number, isByKey = false): void {
    if (this.store.editing) {
      // Two taps draw too, and so does Enter at the cross.
      const from = this.#draft?.from;
      this.#setDraft({ from: from ?? [x, y], to: [x, y] });
      if (from) this.#endDraft(true);
      return;
    }
    const [fence, place] = [this.store.fence, this.store.bridge?.map?.place];
    if (fence && place) {
      this.store.set("run", { fence: withCorner(fence, place, [x, y]) });
      return;
    }
    if (this.store.inspecting && !this.store.aiming) {
      this.#inspect(x, y, isByKey ? KEY_REACH : REACH);
      return;
    }
    const { mark, wall, door, room } = targetAt(this.#sight, x, y);
    this.#inspected = [x, y];
    this.store.choose(mark ? [mark] : []);
    if (mark?.kind === "torn") return;
    if (wall !== null && !this.store.aiming) this.store.point({ pinned: wall });
    else if (this.store.comparesPaths && !this.store.aiming) this.client.contest({ [this.store.contest.picking]: [x, y] });
    else if (door !== null) this.client.setDoor(door, !isDoorOpen(this.scene, door));
    else if (mark) return;
    else if (room !== null) this.store.set("rooms", { roomSpot: [x, y] });
    else sendByClick(this.#leader.store, () => this.client.goTo(x, y), isByKey);
  }

  get #sight(): Sight {
    return { store: this.store, scene: this.scene, px: (pixels) => this.camera.px(pixels) };
  }

  /** The place last inspected. */
  #inspected: [number, number] = [NaN, NaN];

  #inspect(x: number, y: number, reach: number): void {
    const { store } = this;
    const [lastX, lastY] = this.#inspected;
    const isThere = Math.hypot(x - lastX, y - lastY) < this.camera.px(reach);
    if (isThere && store.chosen && store.chosen.things.length > 1) return store.choose(store.chosen.things, (store.chosen.at + 1) % store.chosen.things.length);
    this.#inspected = [x, y];
    store.choose(thingsAt(this.#sight, x, y, reach));
  }

  /** Starts or ends inspecting; it begins with the robot and what is near it. */
  toggleInspecting(): void {
    const { store, scene: { status } } = this;
    const inspecting = !store.inspecting;
    store.set("run", { inspecting, editing: null, aiming: false });
    store.choose(inspecting && status ? thingsAt(this.#sight, status.x, status.y, KEY_REACH) : []);
    // The first click describes the nearest thing, even on the robot.
    this.#inspected = [NaN, NaN];
  }

  /** The edit in progress: where it begins, and where it would end. */
  #draft: Draft | null = null;

  #setDraft(draft: Draft | null): void {
    this.#draft = draft;
    this.#spotVersion += 1;
  }

  #endDraft(isDone: boolean): void {
    const [draft, what] = [this.#draft, this.store.editing];
    this.#setDraft(null);
    if (isDone && draft && what) this.client.edit(what, draft.from, draft.to);
  }

  #key(event: KeyboardEvent): void {
    const step = 60;
    const pans: Record<string, [number, number]> = {
      ArrowLeft: [step, 0], ArrowRight: [-step, 0], ArrowUp: [0, step], ArrowDown: [0, -step],
    };
    const pan = event.shiftKey ? pans[event.key] : undefined;
    if (pan) {
      this.#leader.#pan(...pan);
    } else if (event.key === "Enter") {
      this.#choose(this.camera.x, this.camera.y, true);
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }

  #hover(screenX: number, screenY: number): void {
    const [x, y] = this.camera.toMap(screenX, screenY);
    if (this.#draft) this.#setDraft({ ...this.#draft, to: [x, y] });
    const target = targetAt(this.#sight, x, y);
    const { mark, wall, door } = target;
    const readout = this.#element("hover");
    readout.textContent = placeWords(this.#sight, this.#tiles(), target, x, y);
    this.#element("pad").classList.toggle("door", door !== null || mark !== null);
    readout.toggleAttribute("hidden", false);
    this.#light(wall);
  }

  #light(wall: number | null): void {
    this.#element("pad").classList.toggle("wall", wall !== null);
    if (wall !== (this.store.spot.hovered[0] ?? null)) this.store.point({ hovered: wall === null ? [] : [wall] });
  }

  #resize(): void {
    const { clientWidth, clientHeight } = this;
    if (clientWidth === 0 || clientHeight === 0) return;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    Object.assign(this.camera, { width: clientWidth, height: clientHeight, ratio });
    const { inset, card, offer, isLow } = freeRoom(this, this.store);
    this.toggleAttribute("low", isLow);
    // During the tour there are few controls, on a phone only those for the thumb.
    this.toggleAttribute("told", this.store.tour !== null);
    this.style.setProperty("--card", `${card}px`);
    this.style.setProperty("--offer", `${offer}px`);
    const before = this.camera.inset;
    this.camera.inset = inset;
    this.#uncover(before);
    this.#sheets?.resize(this.camera);
    this.#fitAt = -Infinity;
    const cross = this.#element("cross");
    const [x, y] = this.camera.toScreen(this.camera.x, this.camera.y);
    cross.style.setProperty("left", `${x}px`);
    cross.style.setProperty("top", `${y}px`);
  }

  /** Moves the view so that the card does not cover the place it describes, unless the view is
      fitted anyway. */
  #uncover(before: Camera["inset"]): void {
    const { store, camera } = this;
    const { left, top } = camera.inset;
    if (!store.chosen || this.#auto || (left <= before.left && top <= before.top)) return;
    const [x, y] = camera.toScreen(...this.#inspected);
    if (x < left || y < top) camera.panBy(Math.max(0, left + UNCOVERED - x), Math.max(0, top + UNCOVERED - y));
  }

  #startTicking(): void {
    requestAnimationFrame((now) => this.#tick(now));
  }

  #tick(now: number): void {
    if (!this.isConnected) return;
    this.#startTicking();
    const seconds = Math.min((now - this.#lastTick) / 1000, 0.1);
    this.#lastTick = now;
    this.#frameTimes.push(now);
    while ((this.#frameTimes[0] ?? now) < now - 1000) this.#frameTimes.shift();
    this.frames = this.#frameTimes.length;
    if (!this.hasUpdated) return;
    this.scene.animate(performance.timeOrigin + now, this.#still.matches);
    this.#steer(seconds, now);
    this.#paint(now);
    this.client.drawn();
  }

  /** Moves the camera towards what it should show. */
  #steer(seconds: number, now: number): void {
    const { store, scene, camera } = this;
    if (this.lead) {
      const { x, y, scale, angle } = this.lead.camera;
      Object.assign(camera, { x, y, scale, angle });
      return;
    }
    if (this.#auto && now - this.#fitAt > REFIT_MILLIS && scene.status) {
      this.#fitAt = now;
      const { truth, wheels } = store.layers;
      const boxes = [scene, ...this.others].map((each) => each.bounds(truth, wheels));
      const box = boxes.reduce((all, each) => (each ? union(all, each) : all), null);
      const target = box && camera.fitted(box);
      // A view that followed each new cell would never rest.
      if (target && isFar(this.#target ?? camera, target)) this.#target = target;
    }
    if (store.follow && scene.status) {
      this.#target = { x: scene.status.x, y: scene.status.y, scale: this.#target?.scale ?? camera.scale };
    }
    if (!this.#target) return;
    const jump = this.#jump || this.#still.matches;
    const k = jump ? 1 : 1 - Math.exp(-EASE * seconds);
    this.#jump = false;
    camera.x += (this.#target.x - camera.x) * k;
    camera.y += (this.#target.y - camera.y) * k;
    camera.scale *= (this.#target.scale / camera.scale) ** k;
    const close = Math.hypot(this.#target.x - camera.x, this.#target.y - camera.y) * camera.scale < 0.3 && Math.abs(this.#target.scale / camera.scale - 1) < 1e-3;
    if (close) {
      Object.assign(camera, this.#target);
      this.#target = null;
    }
  }

  #canvases(): CanvasSurface {
    return new CanvasSurface((name) => this.#element(name) as HTMLCanvasElement);
  }

  /** Draws the map on this surface from here on; null: on canvases, for the reason `why`. */
  #drawOn(surface: Surface | null, why: string): void {
    const isThere = !surface && this.#sheets?.surface.kind === "canvas";
    if (!isThere) this.#sheets?.moveTo(surface ?? this.#canvases(), this.camera);
    this.store.set("drawing", { drawing: { with: surface?.kind ?? "canvas", why } });
  }

  /** The layers that are drawn: for a robot out of contact, none that changes all the time. */
  get #layers(): SlamMap["store"]["layers"] {
    const { layers, isCutOff } = this.store;
    return isCutOff ? { ...layers, scan: false, found: false, points: false, tracks: false } : layers;
  }

  #paint(now: number): void {
    const { camera, scene, store } = this;
    const palette = (this.#palette ??= readPalette());
    const tiles = this.#tiles();
    tiles.colour(palette, tiles === scene.tiles ? (store.gridView === "three" ? "three" : "continuous") : store.gridView);
    const view = [camera.x, camera.y, camera.scale, camera.angle, camera.width, camera.height, palette.css.ink, store.gridView, JSON.stringify(this.#layers), store.layerOrder.join(), store.comparesPaths].join();
    const lively = scene.submaps.isLively ? now : 0;
    const alive = (store.playing || scene.submaps.isLively) && !this.#still.matches ? now : 0;
    const drawn = this.#sheets?.draw(camera, now, {
      ground: { view: `${view},${tiles === scene.tiles},${scene.wheels.version},${scene.truth.length},${scene.status !== null && isInDoubt(scene.status)}`, content: `${tiles.version}`, within: () => tiles.takeChanged() },
      record: { view: `${view},${this.#spotVersion}`, content: `${scene.version},${lively}`, wait: scene.submaps.glides ? GLIDING_MILLIS : RECORD_MILLIS },
      overlays: { view: `${view},${scene.version},${this.#spotVersion},${this.#recordedTrail},${alive}` },
    }, (sheet) => (context, bulk) => drawSheet(sheet, this.#brush(context, bulk, camera, now / 1000), this.#layers, store.layerOrder));
    if (drawn?.includes("record")) this.#recordedTrail = scene.trailLength;
    if (drawn?.includes("ground") && camera.scale !== this.#ruledScale) this.#scaleBar();
  }

  /** Draws the view into a context that writes a file, in CSS pixels. */
  drawInto(context: CanvasRenderingContext2D): void {
    const camera = Object.assign(new Camera(), this.camera, { ratio: 1 });
    // Animations are frozen; the trail is drawn to its end.
    const brush = { ...this.#brush(context, new CanvasBulk(context, camera, camera.visible), camera, 0), recordedTrail: this.scene.trailLength };
    for (const sheet of SHEETS) drawSheet(sheet, brush, this.#layers, this.store.layerOrder);
  }

  /** The map's picture on the screen, for tests: without elements over the map. */
  picture(): ImageData | null {
    const { width, height, ratio } = this.camera;
    const context = new OffscreenCanvas(Math.round(width * ratio), Math.round(height * ratio)).getContext("2d");
    if (!context || !this.#sheets) return null;
    this.#sheets.surface.copyTo(context, this.camera);
    return context.getImageData(0, 0, context.canvas.width, context.canvas.height);
  }

  #brush(context: Pencil, bulk: Bulk, camera: Camera, time: number): Brush {
    const { scene, store } = this;
    return {
      context, bulk, camera, scene, palette: (this.#palette ??= readPalette()), tiles: this.#tiles(), recordedTrail: this.#recordedTrail,
      time: this.#still.matches ? 0 : time, truth: store.layers.truth, byWheels: store.layers.trails || store.layers.wheels, spot: store.spot, thing: store.thing, outline: store.outline, compared: store.compared,
      sightings: store.inspection?.sightings ?? [], contest: this.#contest(), edit: store.editing && { kind: store.editing, draft: this.#draft },
      rooms: this.#rooms(), tears: store.quality?.tears ?? [], hiddenSubmaps: store.hiddenSubmaps, chosenSubmap: store.chosenSubmap, loadedMaps: store.loadedMaps,
      bridgeMap: { place: store.bridge?.map?.place ?? null, walls: store.bridgeWalls, zones: store.bridge?.map?.geofence.zones ?? [], draft: store.fence },
    };
  }

  /** The grid, or the chosen field of it once that has arrived. */
  #tiles(): Tiles {
    const { tiles, field } = this.scene;
    return field.name !== null && field.name === this.store.gridView ? field.tiles : tiles;
  }

  /** The contest's query, while its panel is open: the robot may have moved on since. */
  #contest(): Brush["contest"] {
    const { comparesPaths, contest } = this.store;
    if (!comparesPaths) return null;
    const { found, start, goal } = contest;
    const begun = found ? [found.ask.ends[0], found.ask.ends[1]] as const : null;
    return { found, start: start ?? begun, goal };
  }

  /** Rooms while they are shown, with the one that contains the chosen place: numbers change as the
      map grows. */
  #rooms(): Brush["rooms"] {
    const { rooms: found, roomNumbers: numbers, roomSpot: spot, layers } = this.store;
    return found && layers.rooms ? { found, numbers, chosen: spot ? roomAt(found, ...spot) : null } : null;
  }

  #scaleBar(): void {
    this.#ruledScale = this.camera.scale;
    const length = ruleStep(this.camera.scale / 3);
    this.#element("bar").style.setProperty("width", `${length * this.camera.scale}px`);
    this.#element("length").textContent = length >= 1 ? `${length} m` : `${Math.round(length * 100)} cm`;
  }

  #element(id: string): HTMLElement {
    const element = this.renderRoot.querySelector<HTMLElement>(`#${id}`);
    if (!element) throw new Error(`no #${id} in the map`);
    return element;
  }
}

type View = Pick<Camera, "x" | "y" | "scale">;

/** Whether two views differ enough to move from one to the other. */
function isFar(one: View, other: View): boolean {
  const shift = Math.hypot(one.x - other.x, one.y - other.y) * other.scale;
  return shift >= REFIT_SHIFT || Math.abs(Math.log(one.scale / other.scale)) >= REFIT_STRETCH;
}

customElements.define("slam-map", SlamMap);
