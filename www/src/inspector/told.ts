// What is told of a thing, whatever it is: a title, some sentences, its figures with their units,
// formulas with their numbers put in, and where it lies on the map.

import type { TemplateResult } from "lit";
import type { Examined } from "../protocol.js";
import type { Store } from "../store.js";
import type { Outline } from "../view/layers/layer.js";
import type { Scene } from "../view/scene.js";

/** Name, value with its unit, the name that tests know it by, and what it means. */
export type Figure = readonly [name: string, value: string, id: string, meaning?: string];

/** Of what was chosen once and was forgotten, merged or left since. */
export const GONE = "It is not there any more.";

export interface Formula {
  /** As its source has it. */
  readonly general: Element;
  /** With the numbers of this thing. */
  readonly numbers: Element | readonly Element[];
  /** The paper, and the number of the equation in it. */
  readonly source: string;
}

export interface Told {
  readonly title: string;
  /** What became of it, in a word or two. */
  readonly fate?: string;
  readonly words?: string;
  readonly figures: readonly Figure[];
  readonly formulas?: readonly Formula[];
  readonly more?: TemplateResult;
  readonly outline: Outline;
}

/** What it can be told from. */
export interface Known {
  readonly store: Store;
  readonly scene: Scene;
  /** What the run said of it, if it was asked and has answered. */
  readonly examined: Examined | null;
}
