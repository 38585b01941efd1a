// A connection to a bridge, or to devices at ports of this page. A run begins when the other end
// has named its robot, and again whenever the robot restarts.

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
  /** The run that shows the robot, and the count of the robot's starts when it began. */
  #shown: { run: Run; begun: number } | null = null;
  #twin: boolean;

  constructor(private readonly player: Player, { title, token, method, priorMap, cycle, settings, twin, goingOn }: ConversationSetup, wire: Wire) {
    this.#twin = twin;
    const name = navigator.userAgent.includes("Mobile") ? "phone" : "browser";
    const module = (this.#module = goingOn(WebRun.connect({ name, token, method, priorMap: needsPriorMap(method) ? priorMap : null, cycle, settings })));
    let link: Link | null = null;
    const moved = (): void => {
      // The other end may send messages while its link is still being created.
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

  /** Applies to the present robot, and to those that the bridge may name later. */
  configure(settings: SettingValues): void {
    this.#module.configure(settings);
  }

  /** Starts a new twin if `on`, or removes the present one. */
  setTwin(on: boolean): void {
    this.#twin = on;
    this.#shown?.run.setTwin(on);
  }

  /** Sends a command to the bridge itself, at once. */
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
