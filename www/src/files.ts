// Opens files that a person gives: what happens with them depends on what they are.

import { chosen, type Content } from "./chosen.js";
import type { Client } from "./client.js";
import { faultOf } from "./fault.js";
import { linkIn } from "./link.js";
import type { GivenBytes, Topics } from "./protocol.js";
import type { MethodName, PosesAs, SourceKind } from "./protocol/module.js";
import type { Store, Toast } from "./store.js";
import { t } from "./words.js";
import type { WorldDesk } from "./world_desk.js";

/** A file of poses, and what they are to a recording. */
export interface PosesOf {
  readonly file: File;
  readonly are: PosesAs;
}

/** A recording, the chosen topics (null: all that it has), and poses that came with it. */
export interface Recording {
  readonly file: File;
  readonly topics: Topics | null;
  readonly poses: PosesOf | null;
}

/** Offered with a refusal of a file: the list of what can be opened. */
const OPENABLE: NonNullable<Toast["way"]> = { label: "What can be opened", go: () => void dispatchEvent(new Event("show-openable")) };

export class Files {
  /** The world editor, while it is open: a world read then is drawn on, not driven in. */
  desk: WorldDesk | null = null;
  /** Called when a ZIP archive is to be opened. */
  onArchive: (file: File) => void = () => {};
  /** The recording that is shown, and the one that is being read. */
  #shown: Recording | null = null;
  #opening: Recording | null = null;
  /** Names of the files that were given last. */
  #names: readonly string[] = [];

  constructor(private readonly client: Client, private readonly store: Store) {
  }

  /** The recording that is shown. */
  get recording(): Recording | null {
    return this.#shown;
  }

  /** A run begins. Returns whether it is of the recording that was shown before. */
  begins(next: SourceKind): boolean {
    if (next !== "replay") return false;
    const isSame = this.store.source === "replay" && this.#shown?.file === this.#opening?.file;
    this.#shown = this.#opening;
    return isSame;
  }

  /** Opens files that were dropped or chosen together. */
  async openAll(files: readonly File[]): Promise<void> {
    this.#names = files.map(({ name }) => name);
    const given = await chosen(files);
    if (given.kind === "refused") this.client.warn(given.text, OPENABLE);
    else if (given.kind === "building") await this.#read("build", given.name, given.files);
    else if (given.kind === "archive") this.onArchive(given.file);
    else if (given.kind === "poses") await this.#openPoses(given.poses, given.log);
    else if (given.kind === "file") await this.#openAs(given.content, given.file);
  }

  /** What to offer if one of the given files was refused with these words. */
  wayOutOf(text: string): Toast["way"] {
    return this.#names.some((name) => text.startsWith(`${name}: `)) ? OPENABLE : undefined;
  }

  /** Restarts the run with a prior map, which may also be a world. */
  async openKnown(files: readonly File[]): Promise<void> {
    const given = await chosen(files);
    if (given.kind === "refused") this.client.warn(given.text);
    else if (given.kind === "archive") this.client.warn(t`${given.file.name} is an archive: unpack it, and give the map that is in it.`);
    else if (given.kind === "poses") this.client.warn(t`${given.poses.name} holds poses: nothing can be found by them. Give a map.`);
    else if (given.kind === "building") await this.#read("read-prior-map", given.name, given.files);
    else if (given.kind === "file") await this.#read("read-prior-map", given.file.name, files);
  }

  /** Merges a saved map into the present one. */
  async mergeMap(files: readonly File[]): Promise<void> {
    const [file] = files;
    if (!file) return;
    await this.#reading(file.name, async () => {
      const bytes = await file.arrayBuffer();
      this.store.set("run", { loading: file.name });
      this.client.send({ kind: "merge-map", name: file.name, bytes }, [bytes]);
    });
  }

  /** Opens a map beside the run, to be aligned with the drawn map. */
  async loadMap(files: readonly File[]): Promise<void> {
    for (const file of files) await this.#openBeside("load-map", file);
  }

  /** Maps a recorded log. If it is of ROS and has several topics of a kind, and none are chosen,
      asks for them. */
  async open(recording: Recording, method: MethodName = "scan-matching"): Promise<void> {
    const { file, topics, poses: given } = recording;
    await this.#reading(file.name, async () => {
      const { setup, tuning } = this.store;
      const { name } = file;
      const bytes = await file.arrayBuffer();
      const poses = given && { name: given.file.name, are: given.are, bytes: new Uint8Array(await given.file.arrayBuffer()) };
      this.store.set("run", { reading: { name, done: 0 } });
      this.client.send({ kind: "replay", name, bytes, topics, method, settings: setup.settings, twin: tuning.twin, priorMap: setup.priorMap, poses }, [bytes]);
      this.#opening = recording;
    });
  }

  /** Maps the recording whose topics were asked for, with these topics. */
  openTopics(topics: Topics): void {
    this.store.set("run", { asked: null });
    if (this.#opening) void this.open({ ...this.#opening, topics });
  }

  /** Answers what the given poses are. */
  async posesAre(are: PosesAs | "path"): Promise<void> {
    const { posesAsked, method } = this.store;
    this.store.set("run", { posesAsked: null });
    if (!posesAsked) return;
    const { poses: file, log } = posesAsked;
    if (are === "path") await this.#openBeside("load-path", file);
    else if (log) await this.open({ file: log, topics: null, poses: { file, are } });
    else if (this.#shown) await this.open({ ...this.#shown, poses: { file, are } }, method);
  }

  async #openAs(content: Content, file: File): Promise<void> {
    if (content === "log") return this.open({ file, topics: null, poses: null });
    if (content === "link") return this.#openLink(file);
    await this.#reading(file.name, async () => {
      const { client, desk } = this;
      const { name } = file;
      const bytes = await file.arrayBuffer();
      if (content === "world" && desk) desk.open(name, new TextDecoder().decode(bytes), []);
      else if (content === "world") client.start({ world: name, worldJson: new TextDecoder().decode(bytes), mode: "explore" });
      else if (content === "preset") client.send({ kind: "preset", name, bytes }, [bytes]);
      else if (content === "graph") client.send({ kind: "solve-graph", name, bytes }, [bytes]);
      else client.send({ kind: "go-on", name, bytes }, [bytes]);
    });
  }

  /** Poses alone are a path beside the run. If the run is of a recording, they may also be its
      odometry or its truth, just as poses given together with a log. */
  async #openPoses(poses: File, log: File | null): Promise<void> {
    if (log || (this.store.source === "replay" && this.#shown)) this.store.set("run", { posesAsked: { poses, log } });
    else await this.#openBeside("load-path", poses);
  }

  async #openBeside(kind: "load-map" | "load-path", file: File): Promise<void> {
    await this.#reading(file.name, async () => {
      const bytes = await file.arrayBuffer();
      this.client.send({ kind, name: file.name, bytes }, [bytes]);
    });
  }

  async #openLink(file: File): Promise<void> {
    await this.#reading(file.name, async () => {
      const link = linkIn(await file.text());
      if (link === null) this.client.warn(t`${file.name} leads to another page: there is no experiment in it.`);
      else this.client.follow(link);
    });
  }

  async #read(kind: "build" | "read-prior-map", name: string, files: readonly File[]): Promise<void> {
    await this.#reading(name, async () => {
      const given = files.map(async (file): Promise<GivenBytes> => ({ name: file.name, bytes: await file.arrayBuffer() }));
      this.client.send({ kind, name, files: await Promise.all(given) });
    });
  }

  /** Does `work`, which reads a file: it may have gone since it was chosen. */
  async #reading(name: string, work: () => Promise<void>): Promise<void> {
    this.store.set("toast", { toast: null });
    try {
      await work();
    } catch (error) {
      this.client.warn(t`${name} could not be read: ${faultOf(error).text}`);
    }
  }
}
