// A robot that has finished exploring does not look again, so it misses a door that is opened
// later. The page offers to send it there; it then explores on from that place.

import type { Client } from "./client.js";
import { DOOR, DOOR_STRIDE } from "./protocol/module.js";
import type { Store } from "./store.js";
import { t } from "./words.js";

const TOPIC = "door";
/** How long the offer stands, wall milliseconds. */
const ASKED_MILLIS = 20_000;
/** Goals nearer to one another than this count as the same, m. */
const SAME_GOAL = 0.01;

/** Offers to send the robot to doors that are opened once it has finished. */
export function watchDoors(store: Store, client: Client): void {
  let before: ReadonlySet<number> = new Set();
  /** Doors opened since the robot finished. */
  const opened = new Set<number>();
  /** Doors that it is still to visit; null if it was not sent. */
  let left: number[] | null = null;
  /** The last goal that it was sent, and whether it has taken it up. */
  let [goal, isUnderWay] = [[NaN, NaN], false];

  const forget = (): void => {
    opened.clear();
    left = null;
    if (store.toast?.topic === TOPIC) store.set("toast", { toast: null });
  };

  const goOn = (): void => {
    const door = left?.shift();
    if (door === undefined) {
      left = null;
      client.explore();
      return;
    }
    const at = (place: number): number => store.doors[door * DOOR_STRIDE + place] ?? NaN;
    const [x, y] = [(at(DOOR.x1) + at(DOOR.x2)) / 2, (at(DOOR.y1) + at(DOOR.y2)) / 2];
    [goal, isUnderWay] = [[x, y], false];
    client.goTo(x, y);
  };

  const offer = (): void => {
    const [first = 0] = opened;
    const text = opened.size > 1 ? t`${opened.size} doors are open now, and the robot does not know of it.` : t`Door ${first + 1} is open now, and the robot does not know of it.`;
    const go = (): void => {
      left = [...opened];
      opened.clear();
      goOn();
    };
    store.set("toast", { toast: { level: "info", text, topic: TOPIC, stands: ASKED_MILLIS, way: { label: "Let it look", go } } });
  };

  store.on("doors", () => {
    const now = openDoors(store.doors);
    const turned = [...now].filter((door) => !before.has(door));
    const isDone = store.source === "sim" && store.seeking === null && store.status?.finished === true && store.status.mode === "explore";
    before = now;
    for (const door of opened) if (!now.has(door)) opened.delete(door);
    if (!isDone || turned.length === 0) return;
    for (const door of turned) opened.add(door);
    offer();
  });
  store.on("frame", () => {
    const { status } = store;
    if (!status || (left === null && opened.size === 0)) return;
    if (left === null) {
      // Somebody sent it elsewhere, or restarted the run.
      if (!status.finished) forget();
      return;
    }
    const [x = NaN, y = NaN] = goal;
    const isIts = status.mode === "goto" && Math.hypot(status.goalX - x, status.goalY - y) < SAME_GOAL;
    if (isIts && status.finished) goOn();
    else if (isUnderWay && !isIts) left = null;
    else isUnderWay = isIts;
  });
  store.on("run", () => {
    if (store.loading || store.isStopped) forget();
  });
}

function openDoors(doors: ArrayLike<number>): Set<number> {
  const numbers = Array.from({ length: doors.length / DOOR_STRIDE }, (_, door) => door);
  return new Set(numbers.filter((door) => doors[door * DOOR_STRIDE + DOOR.open] === 1));
}
