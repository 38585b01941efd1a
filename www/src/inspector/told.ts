// What is shown about any thing: a title, some sentences, figures with units, formulas with their
// numbers inserted, and its outline on the map.

import type { TemplateResult } from "lit";
import type { Examined } from "../protocol.js";
import type { Store } from "../store.js";
import type { Outline } from "../view/layers/layer.js";
import type { Scene } from "../view/scene.js";

/** Name, value with its unit, the identifier that tests use, and the meaning. */
export type Figure = readonly [name: string, value: string, id: string, meaning?: string];

/** For something that was chosen and has since been forgotten, merged or left behind. */
export const GONE = "It is not there any more.";

export interface Formula {
  /** As in its source. */
  readonly general: Element;
  /** With the numbers of this thing. */
  readonly numbers: Element | readonly Element[];
  /** The paper, and the number of the equation in it. */
  readonly source: string;
}

export interface Told {
  readonly title: string;
  /** Its outcome, in a word or two. */
  readonly fate?: string;
  readonly words?: string;
  readonly figures: readonly Figure[];
  readonly formulas?: readonly Formula[];
  readonly more?: TemplateResult;
  readonly outline: Outline;
}

/** The data from which a thing is described. */
export interface Known {
  readonly store: Store;
  readonly scene: Scene;
  /** The run's answer about it, if there is one. */
  readonly examined: Examined | null;
}
