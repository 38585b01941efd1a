// Composes the page: store, scene, client, components, keys. No logic here.

import { bundle } from "./bundle.js";
import { Client } from "./client.js";
import { exhibitAt } from "./gallery.js";
import { keepLastRun } from "./last_run.js";
import { current as currentLesson, lessonAt } from "./lessons.js";
import { watchDoors } from "./door_watch.js";
import { startGamepad } from "./gamepad.js";
import { startKeyboard } from "./keyboard.js";
import { startLanguage } from "./language.js";
import { isSharedWorld, linkFile } from "./link.js";
import { Keyframes } from "./keyframes.js";
import { keepForOffline, lookForNewer, renewFirst } from "./offline.js";
import { fileName, mapPicture } from "./save.js";
import type { PageKind, SlamSaving } from "./ui/saving.js";
import type { SlamArchive } from "./ui/archive.js";
import type { SlamCharts } from "./ui/charts.js";
import type { SavedFile } from "./protocol/module.js";
import { CLOSURE_STRIDE, EDIT_STRIDE, HYPOTHESIS_STRIDE, POINT_STRIDE, REFINDING_STRIDE, type FieldName } from "./protocol/module.js";
import { Store } from "./store.js";
import { startSheets } from "./ui/sheet.js";
import { startTheme, switchTheme } from "./theme.js";
import { keepTab, keepTurn, keepView } from "./visit.js";
import "./ui/bench.js";
import "./ui/bridge.js";
import "./ui/cable.js";
import "./ui/agreement.js";
import { SlamCycle } from "./ui/cycle.js";
import "./ui/doors.js";
import "./ui/drop.js";
import type { SlamElement } from "./ui/element.js";
import "./ui/edit.js";
import "./ui/elsewhere.js";
import "./ui/gamepad.js";
import "./ui/header.js";
import "./ui/exhibit.js";
import "./ui/last_run.js";
import "./ui/lesson.js";
import { SlamGallery } from "./ui/gallery.js";
import "./ui/poses.js";
import "./ui/topics.js";
import { SlamHelp } from "./ui/help.js";
import "./ui/legend.js";
import "./ui/log.js";
import "./ui/maps.js";
import "./ui/methods.js";
import "./ui/moved.js";
import "./ui/next.js";
import "./ui/plots.js";
import "./ui/quality.js";
import "./ui/refinding.js";
import "./ui/renewal.js";
import "./ui/rooms.js";
import "./ui/setup.js";
import "./ui/status.js";
import "./ui/stick.js";
import "./ui/tabs.js";
import "./ui/timeline.js";
import "./ui/tip.js";
import "./ui/toast.js";
import "./ui/tour.js";
import "./ui/twin.js";
import { SlamTransport } from "./ui/transport.js";
import type { SlamEditor } from "./editor/editor.js";
import type { SlamRace } from "./race/race.js";
import type { SlamRegistration } from "./registration/lab.js";
import type { Box } from "./view/camera.js";
import { landmarksOf } from "./view/layers/landmarks.js";
import { wallEnds } from "./view/layers/spot.js";
import { tracksOf } from "./view/layers/tracks.js";
import { SlamMap } from "./view/map_view.js";
import { readPalette } from "./view/palette.js";
import { Scene } from "./view/scene.js";

await startLanguage();

const store = new Store();
const scene = new Scene();
const client = new Client(store, scene);
startTheme(store);
keepView(store);
keepLastRun(store, client);
watchDoors(store, client);

/** Creates each component at its place in index.html. */
for (const slot of document.querySelectorAll<HTMLElement>("[data-place]")) {
  slot.append(Object.assign(document.createElement(slot.dataset["place"] ?? ""), { store, scene, client }));
}

/** The component of this name; index.html has a place for each. */
const component = <T extends SlamElement>(tag: string): T => document.querySelector(tag) as unknown as T;
const map = component<SlamMap>("slam-map");
keepTurn(map);
const transport = component<SlamTransport>("slam-transport");
const cycle = component<SlamCycle>("slam-cycle");
const help = component<SlamHelp>("slam-help");
const gallery = component<SlamGallery>("slam-gallery");

/** Scans of this run, for the lab. */
const keyframes = new Keyframes();
store.on("frame", () => store.status && keyframes.take(store.status, scene.scan));

client.onStart = (isAgain) => {
  map.restart(isAgain);
  keyframes.clear();
};

/** The worker sends the filter's state only while its tab is open, and the matrix only while it is
    visible. */
let matrixInSight = false;
const requestInspection = (): void => client.send({ kind: "inspect", on: store.tab === "filter", matrix: matrixInSight });
new IntersectionObserver((entries) => {
  const inSight = entries.at(-1)?.isIntersecting ?? false;
  if (inSight === matrixInSight) return;
  matrixInSight = inSight;
  requestInspection();
}).observe(component("slam-correlations"));
store.on("tab", () => {
  requestInspection();
  if (store.tab !== "filter") store.point({ hovered: [], pinned: null });
});

/** It also sends rooms, points of the scan, the map by odometry alone and fields of the grid only
    while they are shown. */
const asked = { rooms: false, points: false, wheels: false, field: null as FieldName | null };
function askForLayers(): void {
  const { gridView: view, layers } = store;
  const field = view === "continuous" || view === "three" || !layers.grid ? null : view;
  if (field !== asked.field) client.send({ kind: "field", name: (asked.field = field) });
  for (const kind of ["rooms", "points", "wheels"] as const) {
    if (layers[kind] === asked[kind]) continue;
    asked[kind] = layers[kind];
    if (kind === "rooms" && !layers.rooms) store.set("rooms", { rooms: null, roomSpot: null });
    client.send({ kind, on: layers[kind] });
  }
}
store.on("view", askForLayers);
askForLayers();
client.onRestart = () => {
  Object.assign(asked, { rooms: false, points: false, wheels: false, field: null });
  askForLayers();
  requestInspection();
};

/** The registration lab, over everything else; its code is loaded when it is first opened. */
let lab: SlamRegistration | null = null;
async function showLab(): Promise<void> {
  if (client.robot.mayBeDriven) client.stop();
  if (!lab) {
    if (!(await bundle(store, "registration.js", "The registration lab"))) return;
    lab ??= Object.assign(document.createElement("slam-registration") as SlamRegistration, { store, keyframes, onClose: hideLab });
  }
  setBehind(true);
  document.body.append(lab);
  lab.focus();
}
function hideLab(): void {
  lab?.rest();
  lab?.remove();
  setBehind(false);
  dispatchEvent(new Event("focus-map"));
}

/** The contents of the tabs of filter, paths and settings are loaded when one of them is first
    chosen. */
let panels: Promise<unknown> | null = null;
store.on("tab", () => {
  if (store.tab !== "filter" && store.tab !== "paths" && store.tab !== "settings") return;
  panels ??= bundle(store, "panels.js", "This panel").then((part) => {
    if (!part) panels = null;
    // Only now does it take up room.
    else store.notify("tab");
  });
});

/** The inspector shows what was chosen on the map; its code is loaded the first time. */
let inspector: Promise<unknown> | null = null;
store.on("chosen", () => {
  document.body.toggleAttribute("data-inspected", store.chosen !== null);
  if (!store.chosen) return;
  inspector ??= bundle(store, "inspector.js", "The inspector").then((part) => {
    if (part) document.querySelector("#inspector")?.append(Object.assign(document.createElement("slam-inspector"), { store, scene, client }));
    else inspector = null;
  });
});

/** Runs beside the one that is shown, loaded in the same way. */
let race: SlamRace | null = null;
const besideIt = (): { store: Store; scene: Scene; client: Client; map: SlamMap } => {
  const parts = { store: new Store(), scene: new Scene() };
  const run = { ...parts, client: new Client(parts.store, parts.scene, true) };
  return { ...run, map: Object.assign(document.createElement("slam-map") as SlamMap, run) };
};
async function showRace(): Promise<void> {
  if (!race) {
    if (!(await bundle(store, "race.js", "The comparison of runs"))) return;
    race ??= Object.assign(document.createElement("slam-race") as SlamRace, { store, scene, client, map, beside: besideIt });
    document.body.append(race);
    await race.updateComplete;
  }
  race.show();
}

/** What can be saved, and what is in an archive, loaded in the same way. */
let saving: SlamSaving | null = null;
async function showSaving(): Promise<void> {
  if (!saving) {
    if (!(await bundle(store, "saving.js", "The list of what can be saved"))) return;
    saving ??= Object.assign(document.createElement("slam-saving") as SlamSaving, { store, scene, client, make: made });
    document.body.append(saving);
    await saving.updateComplete;
  }
  if (!saving.shown) saving.show();
}
let archive: SlamArchive | null = null;
client.files.onArchive = (file) => void openArchive(file);
async function openArchive(file: File): Promise<void> {
  if (!archive) {
    if (!(await bundle(store, "archive.js", "The part that opens archives"))) return;
    archive ??= Object.assign(document.createElement("slam-archive") as SlamArchive, { store, scene, client });
    document.body.append(archive);
    await archive.updateComplete;
  }
  await archive.open(file);
}

/** The world editor, loaded in the same way. The run waits behind it. */
let editor: SlamEditor | null = null;
let goesOn = false;
async function showEditor(link: string | null = null): Promise<void> {
  if (client.robot.mayBeDriven) client.stop();
  if (!editor?.isConnected) goesOn = store.source === "sim" && store.playing;
  if (goesOn) client.send({ kind: "pause" });
  if (!editor) {
    if (!(await bundle(store, "editor.js", "The world editor"))) {
      if (goesOn) client.send({ kind: "play" });
      return;
    }
    // The editor reads the link of the address by itself.
    link = null;
    editor ??= Object.assign(document.createElement("slam-editor") as SlamEditor, { store, client, onClose: hideEditor });
  }
  setBehind(true);
  document.body.append(editor);
  editor.focus();
  if (link !== null) await editor.openLink(link);
}
function hideEditor(): void {
  editor?.remove();
  setBehind(false);
  if (goesOn) client.send({ kind: "play" });
  dispatchEvent(new Event("focus-map"));
}

/** Makes what lies behind the lab unreachable, and removes its messages. */
function setBehind(isBehind: boolean): void {
  store.set("toast", { toast: null });
  for (const behind of document.querySelectorAll<HTMLElement>("#stage, #side")) behind.inert = isBehind;
}

// During the tour the panels wait.
store.on("tour", () => document.body.toggleAttribute("data-tour", store.tour !== null));

addEventListener("show-help", () => help.show());
addEventListener("show-gallery", () => gallery.show());
addEventListener("show-race", () => void showRace());
addEventListener("show-editor", () => (editor?.isConnected ? hideEditor() : void showEditor()));
addEventListener("show-registration", () => (lab?.isConnected ? hideLab() : void showLab()));
addEventListener("focus-map", () => map.renderRoot.querySelector<HTMLElement>("#pad")?.focus({ preventScroll: true }));
addEventListener("show-robot", (event) => {
  const pixelsPerMetre = (event as CustomEvent<number | null>).detail;
  if (pixelsPerMetre === null) map.fit();
  else map.stayWithRobot(pixelsPerMetre);
});
addEventListener("look-at", (event) => map.lookAt((event as CustomEvent<Box>).detail));
addEventListener("show-saving", () => void showSaving());

/** By how much a key turns the view, rad. */
const TURN_STEP = Math.PI / 12;

const byHand = {
  drive: (forward: number, turn: number): void => {
    if (store.source !== "replay") client.drive(forward, turn);
  },
  stop: (): void => client.stop(),
};
startSheets(store);
startGamepad({ ...byHand, show: (gamepad) => store.set("gamepad", { gamepad }) });
startKeyboard({
  ...byHand,
  busy: () => help.shown || (saving?.shown ?? false) || (archive?.shown ?? false) || gallery.shown || (race?.shown ?? false) || (lab?.isConnected ?? false) || (editor?.isConnected ?? false),
  steers: () => store.source !== "replay",
  escape: () => {
    if (store.inspecting) map.toggleInspecting();
    else if (store.chosen) store.choose([]);
    else if (store.editing || store.fence || store.aiming) store.set("run", { editing: null, fence: null, aiming: false });
    else return false;
    // With a real robot, any Esc stops it.
    return store.source !== "bridge";
  },
  once: {
    p: () => client.send({ kind: store.playing ? "pause" : "play" }),
    n: () => client.send({ kind: "step" }),
    b: () => client.back(),
    "[": () => transport.shift(-1),
    "]": () => transport.shift(1),
    1: () => client.manual(),
    2: () => client.aim(),
    3: () => client.explore(),
    4: () => store.source !== "replay" && client.setCycle(!store.setup.cycle),
    ".": () => cycle.next(),
    "+": () => map.zoom(1.25),
    "=": () => map.zoom(1.25),
    "-": () => map.zoom(0.8),
    0: () => map.fit(),
    q: (shift) => map.turn(shift ? -TURN_STEP : TURN_STEP),
    j: () => map.turn(),
    f: () => map.toggleFollow(),
    e: () => map.toggleEditing(),
    i: () => {
      map.toggleInspecting();
      if (store.inspecting) dispatchEvent(new Event("focus-map"));
    },
    r: () => client.again(),
    m: () => void showSaving(),
    // Celej's key for it; with a robot to steer it needs Shift.
    a: () => void showSaving(),
    c: () => void showRace(),
    g: () => gallery.show(),
    y: () => void showSaving(),
    k: () => store.source === "sim" && client.copyLink(),
    l: () => void showLab(),
    o: () => void showEditor(),
    t: () => switchTheme(store),
    x: () => store.source === "sim" && store.toggleLayer("truth"),
    "?": () => help.show(),
  },
});

/** Files that the page itself makes of a run. */
async function made(kind: PageKind): Promise<SavedFile[]> {
  const stem = fileName(store.title);
  if (kind === "csv") return [...document.querySelectorAll<SlamCharts>("slam-plots, slam-consistency, slam-agreement, slam-twin")].flatMap((charts) => charts.table?.() ?? []);
  if (kind === "link") {
    const link = store.source === "sim" ? await client.linkOf(store.started) : null;
    return link === null ? [] : [linkFile(`${stem}-experiment.url`, link)];
  }
  if (kind === "png") {
    const blob = await mapPicture(scene.tiles, readPalette().css.unknown);
    return blob ? [{ name: `${stem}-picture.png`, mime: blob.type, bytes: new Uint8Array(await blob.arrayBuffer()) }] : [];
  }
  const drawing = await drawn();
  return drawing === null ? [] : [{ name: `${stem}-view.svg`, mime: "image/svg+xml", bytes: new TextEncoder().encode(drawing) }];
}

/** The view as a drawing, with the layers that are on. */
async function drawn(): Promise<string | null> {
  const part = await bundle(store, "svg_context.js", "The part that writes drawings") as typeof import("./view/svg_context.js") | null;
  if (!part) return null;
  const { width, height } = map.camera;
  const context = new part.SvgContext(width, height, readPalette().css.unknown);
  map.drawInto(context);
  return context.getSerializedSvg();
}

const OF_THE_STORE = ["status", "hash", "playing", "seeking", "source", "title", "setup", "method", "spot", "contest", "bridge", "cycle", "tuning", "rooms", "thing", "moved", "quality", "seq", "loadedMaps", "log", "grade", "offline", "renewal"] as const;
/** The latest figures, for tests and the console. */
const figures = {
  get fit() { return store.fit.fit; },
  get twin() { return store.twin.columns.map((column) => column.at(-1) ?? NaN); },
  get doors() { return [...store.doors]; },
  get materials() { return [...new Set(scene.materials)]; },
  /** The robot as it is drawn now. */
  get drawn() { return scene.status && { time: scene.status.time, x: scene.status.x, y: scene.status.y, heading: scene.status.heading }; },
  get framesPerSecond() { return map.frames; },
  get blocks() { return scene.tiles.size; },
  get camera() { return { x: map.camera.x, y: map.camera.y, scale: map.camera.scale, angle: map.camera.angle }; },
  /** WebGL2 or canvas. */
  get drawnWith() { return store.drawing.with; },
  get picture() { return map.picture(); },
  /** Number of points found in the last scan. */
  get points() { return scene.points.length / POINT_STRIDE; },
  /** Landmarks of the filter: number, kind, place and confidence. */
  get landmarks() { return landmarksOf(scene.landmarks); },
  /** Number of gates for which the rate of landmarks found again is known, one row each. */
  get refinding() { return scene.refinding.length / REFINDING_STRIDE; },
  /** Number and place of the tracked moving things. */
  get tracks() { return tracksOf(scene.tracks); },
  get takenOut() { return scene.takenOut.length / 2; },
  /** Number of places where the robot may be; 0 if it is localised. */
  get hypotheses() { return scene.hypotheses.length / HYPOTHESIS_STRIDE; },
  /** Number of sides of the edits. */
  get edits() { return scene.edits.length / EDIT_STRIDE; },
  /** The probability of an obstacle at a point, 0 to 1; null if nothing is known. */
  probabilityAt: (x: number, y: number) => scene.tiles.probabilityAt(x, y),
  /** Where a hit of the last scan lies, map frame, m. */
  hit: (beam: number): [number, number] => [scene.scan[2 * beam] ?? NaN, scene.scan[2 * beam + 1] ?? NaN],
  get submaps() { return { count: scene.submaps.count, outcomes: [...scene.submaps.outcomes], glides: scene.submaps.glides }; },
  get hiddenSubmaps() { return [...store.hiddenSubmaps]; },
  /** The pose at which a submap is drawn, x y heading. */
  submap: (number: number) => [...scene.submaps.shown(number)],
  /** The two submaps of a loop closure. */
  closureOf: (row: number) => [...scene.submaps.closures.subarray(row * CLOSURE_STRIDE, row * CLOSURE_STRIDE + 2)],
  wall: (id: number) => wallEnds(scene.lines, id),
  /** Runs beside the one that is shown. */
  get beside() { return race?.figures ?? []; },
  /** Pixels of the canvas at which a map point is drawn. */
  toScreen: (x: number, y: number) => map.camera.toScreen(x, y),
};
for (const name of OF_THE_STORE) Object.defineProperty(figures, name, { get: () => store[name], enumerable: true });
Object.defineProperty(window, "slamlab", { value: Object.freeze(figures) });

// The address was changed while the page is open.
addEventListener("hashchange", () => isSharedWorld(location.hash) && void showEditor(location.hash));
addEventListener("hashchange", () => client.address.open(location.hash) || store.set("exhibit", { exhibit: null }));
// Beginning something else leaves the experiment, and its address.
store.on("exhibit", () => {
  if (!store.exhibit && exhibitAt(location.hash) !== null) history.replaceState(null, "", location.pathname + location.search);
});

// It also leaves a lesson: one that was under way, or an unknown one. One that is about to begin
// stays.
let taught: string | null = null;
for (const topic of ["run", "lesson"] as const) {
  store.on(topic, () => {
    const isLoading = store.loading !== "" || store.offer.lessons.length === 0;
    const given = lessonAt(location.hash);
    const running = currentLesson(store);
    if (running) {
      taught = running.lesson.name;
    } else if (!isLoading && given !== null && (given === taught || !store.offer.lessons.some(({ name }) => name === given))) {
      taught = null;
      history.replaceState(null, "", location.pathname + location.search);
    }
  });
}

// Nobody may steer a robot from a hidden page.
document.addEventListener("visibilitychange", () => {
  if (document.hidden && client.robot.mayBeDriven) client.stop();
});

// A bridge that is back may be of another build than the page.
let isOpen = false;
store.on("bridge", () => {
  const wasOpen = isOpen;
  isOpen = store.bridge?.connection === "open";
  if (isOpen && !wasOpen) void lookForNewer(store);
});

keepTab(store);
keepForOffline(store);
void renewFirst().then((isRenewed) => {
  if (isRenewed) return;
  void client.begin();
  if (isSharedWorld(location.hash)) void showEditor();
});
