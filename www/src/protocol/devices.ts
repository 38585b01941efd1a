// Robots and sensors: behind a bridge, and at serial ports of this page.

/** A kind of device that the page can have at a serial port, as the module's table has it. */
export interface DeviceKind {
  /** What the rules know it by. */
  name: string;
  title: string;
  /** What it is good for. */
  about: string;
  /** USB adapters that usually come with it. It works behind any other as well. */
  adapters: readonly { usbVendorId: number; usbProductId: number }[];
}

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

/** To the local bridge, the worker with the rules for a robot at ports of this page. */
export type LocalBridgeCommand =
  /** `driver` leads to the client; over it go the messages of a bridge. */
  | { kind: "begin"; devices: readonly string[]; driver: MessagePort }
  | ({ kind: "line" } & LineEvent)
  /** The person stops the robot; with `cutOff` its motors stay off. */
  | { kind: "stop"; cutOff: boolean }
  /** Has the lines closed, the robot stopped before. */
  | { kind: "end" };

/** And from it. */
export type LocalBridgeAnswer =
  | ({ kind: "line" } & LineWish)
  /** The rules are of no use any more. */
  | { kind: "failed"; text: string };

/** `lost` is tried again, `refused` is not. */
export type Connection = "connecting" | "open" | "lost" | "refused";

export interface Device {
  /** As the bridge was told of it: `rplidar:/dev/ttyUSB0`. */
  name: string;
  /** What it is; empty until it said so. */
  model: string;
  /** waiting, connected, measuring, sending or fault. */
  state: string;
  /** Of a fault: cause and cure. */
  detail: string;
}

/** What a bridge and the robot behind it say of themselves. NaN where nothing is known. */
export interface BridgeState {
  connection: Connection;
  /** Why the connection is not open; empty while it is. */
  fault: string;
  mayDrive: boolean;
  hasLease: boolean;
  /** The robot moves on this page's commands. */
  armed: boolean;
  emergency: boolean;
  /** Who has the right to drive; empty for nobody. */
  driver: string;
  /** Why the robot is not armed. */
  reason: string;
  /** V. */
  battery: number;
  /** From here to the bridge and back, and age of the robot's newest reading there, s. */
  roundTrip: number;
  readingAge: number;
  /** Readings that this page missed. */
  dropped: number;
  watchers: number;
  /** File of the recording; empty for none. Messages that stand in it. */
  recording: string;
  recorded: number;
  devices: Device[];
}
