// A geofence while it is drawn: finished areas and the corners of the next one, in the frame of the
// bridge's map. The map view adds corners, the panel of the bridge does the rest.

import type { FenceZone } from "./protocol/module.js";

export type Place = readonly [number, number, number];

export interface FenceDraft {
  /** Whether the next area is to be kept out of. */
  readonly keepOut: boolean;
  readonly zones: readonly FenceZone[];
  readonly corners: readonly (readonly [number, number])[];
}

/** Adds a corner at a place of this page's map, if `run_map_from_bridge_map` is known. */
export function withCorner(draft: FenceDraft, place: Place, [x, y]: readonly [number, number]): FenceDraft {
  const [dx, dy, cos, sin] = [x - place[0], y - place[1], Math.cos(place[2]), Math.sin(place[2])];
  return { ...draft, corners: [...draft.corners, [cos * dx + sin * dy, cos * dy - sin * dx]] };
}

/** Finishes the area that the corners enclose. */
export function closed(draft: FenceDraft): FenceDraft {
  const corners = draft.corners.map(([x, y]): [number, number] => [x, y]);
  return { ...draft, corners: [], zones: [...draft.zones, { keepOut: draft.keepOut, corners }] };
}

/** Removes the last corner, or reopens the last area. */
export function undone(draft: FenceDraft): FenceDraft {
  if (draft.corners.length > 0) return { ...draft, corners: draft.corners.slice(0, -1) };
  const last = draft.zones.at(-1);
  return last ? { keepOut: last.keepOut, zones: draft.zones.slice(0, -1), corners: last.corners } : draft;
}
