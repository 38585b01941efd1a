// Robots and sensors: behind a bridge, and at serial ports of this page.

import type { BridgeStatus } from "./module.js";

/** An event at a line, given by its number. */
export interface LineEvent {
  line: number;
  event: "opened" | "bytes" | "broken";
  bytes?: Uint8Array;
  /** When the bytes came, ms since 1970: the worker may have been busy then. */
  came?: number;
  /** Why it broke: cause and remedy. */
  why?: string;
}

/** What a device wants done with its line. */
export interface LineWish {
  line: number;
  /** `well`: if it breaks again, the first retry comes soon. */
  want: "open" | "write" | "dtr" | "well" | "reopen" | "close";
  baud: number;
  bytes: Uint8Array<ArrayBuffer>;
  on: boolean;
}

/** Messages to the local bridge, the worker with the rules for a robot at ports of this page. */
export type LocalBridgeCommand =
  /** `driver` leads to the client, and carries the messages of a bridge. */
  | { kind: "begin"; devices: readonly string[]; driver: MessagePort }
  | ({ kind: "line" } & LineEvent)
  /** The person stops the robot; with `cutOff` its motors stay off. */
  | { kind: "stop"; cutOff: boolean }
  /** Stops the robot, then has the lines closed. */
  | { kind: "end" };

/** Messages from it. */
export type LocalBridgeAnswer =
  | ({ kind: "line" } & LineWish)
  /** The rules have failed for good. */
  | { kind: "failed"; text: string };

/** After `lost` there are retries, after `refused` there are none. */
export type Connection = "connecting" | "open" | "lost" | "refused";

/** The state of the bridge, and of this page's connection to it. */
export interface BridgeState extends BridgeStatus {
  connection: Connection;
  /** Why the connection is not open; empty while it is. */
  fault: string;
}
