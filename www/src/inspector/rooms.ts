// Rooms and doors: those that were found in the map, doors of the simulated world, and the edits of
// a person.

import { DOOR, DOOR_STRIDE, EDIT, EDIT_STRIDE, LEAF } from "../protocol/module.js";
import { equals, formula, fraction, id, op, row, sub, sum, sup } from "../registration/formula.js";
import { fixed, percent } from "../ui/format.js";
import { roomAt } from "../view/things.js";
import { t } from "../words.js";
import { segment } from "./outlines.js";
import { type Formula, type Figure, GONE, type Known, type Told } from "./told.js";
import { metres, number, place } from "./words.js";

/** A door of the simulated world. */
export function door(index: number, { scene: { doors }, examined }: Known): Told {
  const at = (name: keyof typeof DOOR): number => doors[index * DOOR_STRIDE + DOOR[name]] ?? NaN;
  const title = t`Door ${index + 1}`;
  const [x1, y1, x2, y2] = [at("x1"), at("y1"), at("x2"), at("y2")];
  if (Number.isNaN(x1)) return { title, words: GONE, figures: [], outline: [] };
  const isOpen = at("open") === 1;
  const leaf = leafOf(examined);
  return {
    title,
    fate: isOpen ? "Stands open" : "Stands shut",
    words: at("ordered") === at("open") ? "How it stands is the truth, which only a simulator knows. The robot knows what its map shows of it." : "It is to move, and waits: somebody stands in it.",
    figures: [["Width", metres(Math.hypot(x2 - x1, y2 - y1)), "door-width"], ["From", place(x1, y1), "door-from"], ["To", place(x2, y2), "door-to"], ...leaf.figures],
    formulas: leaf.formulas,
    outline: segment(x1, y1, x2, y2),
  };
}

/** A door that was found in the map, given by its posts. */
export function doorway(posts: readonly number[], { store: { rooms, roomNumbers }, examined }: Known): Told {
  const [x1 = NaN, y1 = NaN, x2 = NaN, y2 = NaN] = posts;
  // Doors are extracted again and again: take the present one whose middle is where the old one had
  // its middle.
  const away = ([x, y]: readonly [number, number]): number => Math.hypot(x - (x1 + x2) / 2, y - (y1 + y2) / 2);
  const found = rooms?.doors.find(({ middle }) => away(middle) < 0.3);
  if (!rooms || !found) return { title: "Doorway", words: GONE, figures: [], outline: [] };
  const leaf = leafOf(examined);
  const [from, to] = found.regions.map((region) => roomNumbers[region]);
  return {
    title: "Doorway",
    fate: found.framed ? "Both posts were seen" : "One post not seen yet",
    words: "A narrow place between two regions of the free floor, found in the map alone.",
    figures: [
      ["Width", metres(found.width), "doorway-width", "From post to post, good to a cell"],
      ["Between", t`regions ${from} and ${to}`, "doorway-regions"],
      ...leaf.figures,
    ],
    formulas: leaf.formulas,
    outline: segment(...(found.posts as [number, number, number, number])),
  };
}

/** Whether a gap is open, as far as the map shows it. */
function leafOf(examined: Known["examined"]): { figures: readonly Figure[]; formulas: readonly Formula[] } {
  const told = examined?.leaf;
  if (!told) return { figures: [], formulas: [] };
  const at = (name: keyof typeof LEAF): number => told[LEAF[name]] ?? NaN;
  const l = at("logOdds");
  return {
    figures: [
      ["p(open) by the map", `${fixed(100 * at("open"), 1)} %`, "leaf-open", "50 % where the map knows nothing of it"],
      ["Cells between the posts", `${at("cells")}`, "leaf-cells", "Without those at the posts"],
      ["Known of them", `${at("known")}`, "leaf-known"],
      ["Sum of their log-odds", fixed(l, 2), "leaf-sum", "Below 0: free"],
    ],
    formulas: [{
      general: formula(row(id("p"), op("("), id("open"), op(")"), equals(), fraction(id("1"), row(id("1"), op("+"), sup(id("e"), row(sum("i"), sub(id("l"), id("i")))))))),
      numbers: formula(row(fraction(id("1"), row(id("1"), op("+"), sup(id("e"), number(l)))), equals(), number(at("open")))),
      source: "Thrun, Burgard & Fox 2005, eq. (9.6): one leaf shuts all cells or none, so they are looks at one question, and log-odds add",
    }],
  };
}

/** A room or a corridor, given by a place in it. */
export function room(x: number, y: number, { store: { rooms, roomNumbers } }: Known): Told {
  const at = rooms && roomAt(rooms, x, y);
  const found = rooms && at !== null ? rooms.regions[at] : undefined;
  if (!rooms || at === null || !found) return { title: "Room", words: GONE, figures: [], outline: [] };
  const { kind, area, width, outlines } = found;
  const doors = rooms.doors.filter(({ regions }) => regions.includes(at)).length;
  const slenderness = area / width ** 2;
  return {
    title: kind === "corridor" ? t`Corridor ${roomNumbers[at]}` : t`Room ${roomNumbers[at]}`,
    words: "A part of the free floor that narrow places bound. Much longer than wide it counts as a corridor, sooner where many doors lead off it.",
    figures: [
      ["Free floor", `${fixed(area, 1)} m²`, "room-area"],
      ["Width between its walls", metres(width), "room-width", "Of the widest circle in it, without furniture"],
      ["Times as long as wide", fixed(slenderness, 1), "room-slenderness"],
      ["Doors", `${doors}`, "room-doors"],
      ["Of all floor that was found", percent(area / rooms.regions.reduce((all, region) => all + region.area, 0)), "room-part"],
    ],
    formulas: [{
      general: formula(row(id("s"), equals(), fraction(id("A"), sup(id("w"), "2")))),
      numbers: formula(row(fraction(number(area), sup(number(width), "2")), equals(), number(slenderness))),
      source: "area over the square of the width: how many squares of its width it is long",
    }],
    outline: outlines.map((ring): [number, number][] => {
      const corners = Array.from({ length: ring.length / 2 }, (_, i): [number, number] => [ring[2 * i] ?? NaN, ring[2 * i + 1] ?? NaN]);
      return [...corners, ...corners.slice(0, 1)];
    }),
  };
}

const EDITED = ["Erased by hand", "Wall, drawn by hand", "Glass, drawn by hand"] as const;
const MEANS = [
  "What was seen here before is forgotten. The robot may see it again.",
  "The map has a wall here because somebody drew it: no beam takes it away.",
  "Nothing is driven through it. Light goes through glass, so beams that say it is free do not take it away.",
] as const;

/** A person's edit, given by its number. */
export function edit(change: number, { scene: { edits } }: Known): Told {
  const rows = Array.from({ length: edits.length / EDIT_STRIDE }, (_, i) => i * EDIT_STRIDE).filter((row) => edits[row + EDIT.number] === change);
  const [first] = rows;
  if (first === undefined) return { title: EDITED[1], words: GONE, figures: [], outline: [] };
  const kind = edits[first + EDIT.kind] ?? 0;
  const sides = rows.map((row): [number, number][] => [[edits[row + EDIT.x1] ?? NaN, edits[row + EDIT.y1] ?? NaN], [edits[row + EDIT.x2] ?? NaN, edits[row + EDIT.y2] ?? NaN]]);
  const length = sides.reduce((all, [a = [NaN, NaN], b = [NaN, NaN]]) => all + Math.hypot(a[0] - b[0], a[1] - b[1]), 0);
  return {
    title: EDITED[kind] ?? EDITED[1],
    words: MEANS[kind] ?? "",
    figures: [["Length", metres(length), "edit-length", "Of all its sides"], ["From", place(...(sides[0]?.[0] ?? [NaN, NaN])), "edit-from"]],
    outline: sides,
  };
}
