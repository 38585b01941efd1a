// A conversation with a bridge, or with devices at ports of this page: a run begins when the other end has said who it is, and anew
// whenever the robot did.

import { WebRun } from "../../pkg/slamlab_web.js";
import { post } from "../answer.js";
import type { KnownMap, MethodName } from "../protocol/module.js";
import type { Link, LinkEvents } from "./link.js";
import type { Player } from "./player.js";
import { Run } from "./run.js";

export interface Who {
  title: string;
  token: string;
  method: MethodName;
  known: KnownMap | null;
}

export class Conversation {
  readonly #module: WebRun;
  readonly #player: Player;
  readonly #link: Link;
  /** The run that shows it, and which beginning of the robot that is. */
  #shown: { run: Run; begun: number } | null = null;

  /** `prepare` sets up each run that begins. */
  constructor(player: Player, { title, token, method, known }: Who, wire: (module: WebRun, events: LinkEvents) => Link, prepare: (run: Run) => void) {
    this.#player = player;
    const name = navigator.userAgent.includes("Mobile") ? "phone" : "browser";
    const module = (this.#module = WebRun.connect({ name, token, method, known: method === "known-map" ? known : null, seed: 1 }));
    let link: Link | null = null;
    const moved = (): void => {
      // The other end may speak while its link is being made.
      if (!link) return;
      if (module.begun() !== (this.#shown?.begun ?? 0)) {
        const run = new Run(module, { kind: "bridge", title, method }, "");
        prepare(run);
        this.#shown = { run, begun: module.begun() };
        player.begin(run, { setup: null, playing: true });
      }
      if (!this.#shown || player.run !== this.#shown.run) return;
      this.#shown.run.look(NaN);
      player.changed();
    };
    link = this.#link = wire(module, { moved, state: (state) => post({ kind: "bridge", state }) });
  }

  get link(): Link {
    return this.#link;
  }

  /** A command to the bridge itself; it goes out at once. */
  say(act: (module: WebRun) => void): void {
    act(this.#module);
    this.#link.flush();
    this.#link.stir();
  }

  close(): void {
    if (this.#shown && this.#player.run === this.#shown.run) this.#player.run = null;
    this.#link.close();
    this.#module.free();
    post({ kind: "bridge", state: null });
  }
}
