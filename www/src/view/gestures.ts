// Translates pointer, wheel, pinch and twist on the map into actions: pan, zoom, turn, tap, hover.

import { turnBetween } from "../angle.js";

export interface GestureHandlers {
  pan(dx: number, dy: number): void;
  zoom(factor: number, x: number, y: number): void;
  /** Turns by an angle, rad, around a point; null: around the middle of the view. Without this
      handler nothing turns. */
  turn?(angle: number, around: readonly [number, number] | null): void;
  tap(x: number, y: number): void;
  hover(x: number, y: number): void;
  leave(): void;
  /** Whether a drag draws, rather than moving the view. */
  draws(): boolean;
  /** A drag that draws: from where it began to where it is now. */
  draw(from: readonly [number, number], to: readonly [number, number]): void;
  /** The drag has ended; with `isDone` false it is cancelled. */
  drawn(isDone: boolean): void;
}

/** Two fingers that turn by less than this only pinch, rad. */
const LEAST_TWIST = 0.15;

/** A press that moves less than this is a tap, CSS pixels. */
const SLOP = 6;

/** Listens on `element`. */
export function listenToGestures(element: HTMLElement, on: GestureHandlers): void {
  const pointers = new Map<number, { x: number; y: number }>();
  let moved = 0;
  let hadTwo = false;
  /** The angle that two fingers have turned, rad. */
  let twist = 0;
  /** Whether the press turns the view. */
  let turns = false;
  /** Where a drag began that draws. */
  let begun: readonly [number, number] | null = null;

  const at = (event: MouseEvent): { x: number; y: number } => {
    const box = element.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };

  const down = (event: PointerEvent): void => {
    if (event.button !== 0 && event.button !== 1) return;
    if (pointers.size === 0) {
      moved = 0;
      hadTwo = false;
    }
    const now = at(event);
    turns = pointers.size === 0 && event.button === 0 && event.shiftKey && on.turn !== undefined;
    begun = pointers.size === 0 && event.button === 0 && !turns && on.draws() ? [now.x, now.y] : null;
    pointers.set(event.pointerId, now);
    if (pointers.size > 1) {
      hadTwo = true;
      twist = 0;
      on.drawn(false);
    }
    element.setPointerCapture(event.pointerId);
  };

  const move = (event: PointerEvent): void => {
    const now = at(event);
    const before = pointers.get(event.pointerId);
    if (!before) {
      if (event.pointerType !== "touch") on.hover(now.x, now.y);
      return;
    }
    const [dx, dy] = [now.x - before.x, now.y - before.y];
    const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
    pointers.set(event.pointerId, now);
    if (other) {
      const spread = (p: { x: number; y: number }): number => Math.hypot(p.x - other.x, p.y - other.y);
      on.pan(dx / 2, dy / 2);
      const [x, y] = [(now.x + other.x) / 2, (now.y + other.y) / 2];
      on.zoom(spread(now) / Math.max(spread(before), 1), x, y);
      const turned = turnBetween(direction(before, other), direction(now, other));
      const wasTwist = Math.abs(twist) >= LEAST_TWIST;
      twist += turned;
      if (wasTwist) on.turn?.(turned, [x, y]);
    } else {
      const wasTap = moved < SLOP;
      moved += Math.hypot(dx, dy);
      if (wasTap && moved < SLOP) return;
      if (begun) on.draw(begun, [now.x, now.y]);
      else if (turns) {
        const middle = { x: element.clientWidth / 2, y: element.clientHeight / 2 };
        on.turn?.(turnBetween(direction(before, middle), direction(now, middle)), null);
      } else on.pan(dx, dy);
    }
  };

  const up = (event: PointerEvent): void => {
    const point = pointers.get(event.pointerId);
    if (!pointers.delete(event.pointerId) || !point) return;
    if (begun && moved >= SLOP) on.drawn(event.type === "pointerup");
    if (event.type === "pointerup" && pointers.size === 0 && !hadTwo && moved < SLOP && event.button === 0) on.tap(point.x, point.y);
  };

  const wheel = (event: WheelEvent): void => {
    event.preventDefault();
    const { x, y } = at(event);
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    on.zoom(Math.exp(-event.deltaY * lines * (event.ctrlKey ? 0.01 : 0.0016)), x, y);
  };

  element.addEventListener("pointerdown", down);
  element.addEventListener("pointermove", move);
  element.addEventListener("pointerup", up);
  element.addEventListener("pointercancel", up);
  element.addEventListener("pointerleave", () => on.leave());
  element.addEventListener("wheel", wheel, { passive: false });
}

/** The direction of a point from another one, on the screen (y down), rad. */
function direction(point: { x: number; y: number }, from: { x: number; y: number }): number {
  return Math.atan2(point.y - from.y, point.x - from.x);
}
