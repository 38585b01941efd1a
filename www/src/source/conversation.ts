// A conversation with a bridge, or with devices at ports of this page: a run begins when the other
// end has named its robot, and again whenever the robot did.

import { WebRun } from "../../pkg/slamlab_web.js";
import { post } from "../answer.js";
import type { LiveSetup } from "../protocol.js";
import { needsPriorMap } from "../protocol/methods.js";
import type { SettingValues } from "../protocol/module.js";
import type { Link, LinkEvents } from "./link.js";
import type { Player } from "./player.js";
import { Run } from "./run.js";

export interface ConversationSetup extends LiveSetup {
  title: string;
  token: string;
  /** The run, in the saved map if its method can go on in one. */
  goingOn: (run: WebRun) => WebRun;
}

/** Makes the link for a module. */
export type Wire = (module: WebRun, events: LinkEvents) => Link;

export class Conversation {
  readonly #module: WebRun;
  readonly link: Link;
  /** The run that shows it, and which beginning of the robot that is. */
  #shown: { run: Run; begun: number } | null = null;
  #twin: boolean;

  constructor(private readonly player: Player, { title, token, method, priorMap, cycle, settings, twin, goingOn }: ConversationSetup, wire: Wire) {
    this.#twin = twin;
    const name = navigator.userAgent.includes("Mobile") ? "phone" : "browser";
    const module = (this.#module = goingOn(WebRun.connect({ name, token, method, priorMap: needsPriorMap(method) ? priorMap : null, cycle, settings })));
    let link: Link | null = null;
    const moved = (): void => {
      // The other end may speak while its link is being made.
      if (!link) return;
      if (module.begun() !== (this.#shown?.begun ?? 0)) {
        const run = new Run(module, { kind: "bridge", title, method }, "");
        run.setTwin(this.#twin);
        this.#shown = { run, begun: module.begun() };
        player.begin(run, { setup: null, playing: true });
      }
      if (!this.#shown || player.run !== this.#shown.run) return;
      this.#shown.run.update(NaN);
      player.changed();
    };
    link = this.link = wire(module, { moved, state: (state, walls) => post({ kind: "bridge", state, walls }) });
  }

  /** Of the robot that is there, and of those that the bridge may name later. */
  configure(settings: SettingValues): void {
    this.#module.configure(settings);
  }

  /** With a twin another one begins here. */
  setTwin(on: boolean): void {
    this.#twin = on;
    this.#shown?.run.setTwin(on);
  }

  /** A command to the bridge itself; it goes out at once. */
  say(act: (module: WebRun) => void): void {
    act(this.#module);
    this.link.flush();
    this.link.stir();
  }

  close(): void {
    if (this.#shown && this.player.run === this.#shown.run) this.player.run = null;
    this.link.close();
    this.#module.free();
    post({ kind: "bridge", state: null, walls: new Float32Array(0) });
  }
}
