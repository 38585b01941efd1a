// Robots and sensors: behind a bridge, and at serial ports of this page.

import type { BridgeStatus } from "./module.js";

/** What happened at a line, by its number. */
export interface LineEvent {
  line: number;
  event: "opened" | "bytes" | "broken";
  bytes?: Uint8Array;
  /** When they came, ms since 1970: the worker may be busy when they do. */
  came?: number;
  /** Why it broke: cause and cure. */
  why?: string;
}

/** What the device at a line wants done with it. */
export interface LineWish {
  line: number;
  /** `well`: the next time that it breaks it is tried again soon. */
  want: "open" | "write" | "dtr" | "well" | "reopen" | "close";
  baud: number;
  bytes: Uint8Array<ArrayBuffer>;
  on: boolean;
}

/** To the worker with the rules for a robot at ports of this page. */
export type NearCommand =
  /** `driver` leads to the one who maps and drives; what goes over it are a bridge's messages. */
  | { kind: "begin"; devices: readonly string[]; driver: MessagePort }
  | ({ kind: "line" } & LineEvent)
  /** The person stops the robot; with `cutOff` its motors stay off. */
  | { kind: "stop"; cutOff: boolean }
  /** Has the lines closed, the robot stopped before. */
  | { kind: "end" };

/** And from it. */
export type NearAnswer =
  | ({ kind: "line" } & LineWish)
  /** The rules are of no use any more. */
  | { kind: "failed"; text: string };

/** `lost` is tried again, `refused` is not. */
export type Connection = "connecting" | "open" | "lost" | "refused";

/** What the bridge, and this page's connection to it, say of themselves. */
export interface BridgeState extends BridgeStatus {
  connection: Connection;
  /** Why the connection is not open; empty while it is. */
  fault: string;
}
