// One language: looks up what is said in English.

import type { TemplateResult } from "lit";
import type { Language } from "../spoken.js";
import { type Piece, saysSomething, sentenceOf, takeApart, type Taken } from "./template.js";

/** A sentence in as many forms as the language has for the number in one of its places. */
export interface Forms<T extends string = string> {
  /** The place of the number. */
  readonly by: number;
  readonly one?: T;
  readonly few?: T;
  readonly many?: T;
  readonly other: T;
}
export type Phrase<T extends string = string> = T | Forms<T>;
export type Table = Readonly<Record<string, Phrase>>;

/** What told sentences are remembered, so that they are looked for once. */
const MOST_REMEMBERED = 2000;

/** What is wrong with a file, behind its name, in which nothing is a sentence. */
const NAMED_FILE = /^(\S+\.[A-Za-z]\w*): ([\s\S]+)$/;

interface Pattern { readonly start: string; readonly end: string; readonly expression: RegExp; readonly key: string }
interface Made { readonly strings: TemplateStringsArray; readonly places: readonly number[] }

export class Translator {
  readonly decimalMark: string;
  readonly #plural: Intl.PluralRules;
  readonly #templates = new WeakMap<TemplateStringsArray, { taken: Taken; made: Map<string, Made> }>();
  /** The English of what index.html says. */
  readonly #said = new Map<Element, string>();
  readonly #told = new Map<string, string>();
  readonly #patterns: readonly Pattern[];

  /** `heard`: sentences of `table` that are put together elsewhere, in worker or core, and come
      as they are. */
  constructor(readonly language: Language, private readonly table: Table, heard: readonly string[]) {
    this.#plural = new Intl.PluralRules(language);
    this.decimalMark = new Intl.NumberFormat(language).formatToParts(1.5).find(({ type }) => type === "decimal")?.value ?? ".";
    this.#patterns = heard.map(patternOf).sort((a, b) => wordsOf(b) - wordsOf(a));
  }

  /** What is told, in this language; as it is where it is nothing of ours, as a name of a file. */
  say(english: string): string {
    const entry = this.#entry(english);
    if (entry !== undefined) return this.#form(entry, []);
    if (!saysSomething(english)) return english;
    const told = this.#told.get(english);
    if (told !== undefined) return told;
    if (this.#told.size >= MOST_REMEMBERED) this.#told.clear();
    const said = this.#hear(english) ?? this.#atOtherPlace(english) ?? english;
    this.#told.set(english, said);
    return said;
  }

  compose(strings: readonly string[], values: readonly unknown[]): string {
    const sentence = sentenceOf(strings);
    const said = values.map((value) => this.#value(value));
    return fill(this.#form(this.#entry(sentence) ?? sentence, said), said);
  }

  /** What `make` makes of a template whose sentences are those of this language. */
  template<T extends TemplateResult<1> | TemplateResult<2>>(make: (strings: TemplateStringsArray, ...values: unknown[]) => T, strings: TemplateStringsArray, values: readonly unknown[]): T {
    let known = this.#templates.get(strings);
    if (!known) this.#templates.set(strings, (known = { taken: takeApart(strings), made: new Map() }));
    const { taken, made } = known;
    const chosen = taken.pieces.map((piece) => this.#choose(piece, values));
    const key = chosen.filter(({ form }) => form !== "").map(({ form }) => form).join(" ");
    let ready = made.get(key);
    if (!ready) made.set(key, (ready = build(taken.pieces.map((piece, i) => laid(piece, chosen[i]?.text ?? null)))));
    return make(ready.strings, ...ready.places.map((place) => (taken.spoken.has(place) ? this.#spoken(values[place]) : values[place])));
  }

  /** Says what index.html says by itself. */
  enter(): void {
    this.#said.set(document.head, document.title);
    document.title = this.say(document.title);
    for (const part of document.querySelectorAll("#stage [aria-label], #side, #side [aria-label]")) {
      const english = part.getAttribute("aria-label") ?? "";
      this.#said.set(part, english);
      part.setAttribute("aria-label", this.say(english));
    }
  }

  /** Leaves it as it was. */
  leave(): void {
    for (const [part, english] of this.#said) {
      if (part === document.head) document.title = english;
      else part.setAttribute("aria-label", english);
    }
    this.#said.clear();
  }

  #choose({ message, places }: Piece, values: readonly unknown[]): { text: string | null; form: string } {
    const entry = message === null ? undefined : this.#entry(message);
    if (entry === undefined || typeof entry === "string") return { text: entry ?? null, form: "" };
    const form = this.#category(values[places[entry.by] ?? -1]);
    return { text: entry[form] ?? entry.other, form };
  }

  #entry(english: string): Phrase | undefined {
    return Object.hasOwn(this.table, english) ? this.table[english] : undefined;
  }

  #form(entry: Phrase, values: readonly string[]): string {
    if (typeof entry === "string") return entry;
    return entry[this.#category(values[entry.by])] ?? entry.other;
  }

  #category(value: unknown): "one" | "few" | "many" | "other" {
    const text = String(value).replace(this.decimalMark, ".").replace(/\s/g, "");
    const number = Number(/^\D*?([\d.]+)/.exec(text)?.[1] ?? NaN);
    const category = Number.isFinite(number) ? this.#plural.select(number) : "other";
    return category === "zero" || category === "two" ? "other" : category;
  }

  #spoken(value: unknown): unknown {
    return typeof value === "string" ? this.say(value) : value;
  }

  #value(value: unknown): string {
    return typeof value === "string" ? this.say(value) : String(value);
  }

  /** With a capital, what has none in the table, for it begins a sentence here. */
  #atOtherPlace(english: string): string | null {
    const first = english.charAt(0);
    if (first === first.toLowerCase()) return null;
    const within = first.toLowerCase() + english.slice(1);
    const entry = this.#entry(within);
    const said = entry === undefined ? this.#hear(within) : this.#form(entry, []);
    return said === null ? null : said.charAt(0).toUpperCase() + said.slice(1);
  }

  /** A sentence that was put together elsewhere. */
  #hear(english: string): string | null {
    const [, name, rest = ""] = NAMED_FILE.exec(english) ?? [];
    const told = name === undefined ? rest : this.say(rest);
    if (told !== rest) return `${name}: ${told}`;
    for (const { start, end, expression, key } of this.#patterns) {
      if (!english.startsWith(start) || !english.endsWith(end)) continue;
      const match = expression.exec(english);
      if (!match) continue;
      const values: string[] = [];
      for (const [name, value] of Object.entries(match.groups ?? {})) values[Number(name.slice(1))] = this.#heardValue(value);
      return fill(this.#form(this.table[key] ?? key, values), values);
    }
    return null;
  }

  #heardValue(value: string): string {
    return /^-?\d+\.\d+$/.test(value) ? value.replace(".", this.decimalMark) : this.say(value);
  }
}

const fill = (sentence: string, values: readonly string[]): string => sentence.replace(/\{(\d+)\}/g, (place, i) => values[Number(i)] ?? place);

/** How much of a sentence is its own: the more, the surer it is meant. */
const wordsOf = ({ key }: Pattern): number => key.replace(/\{\d+\}/g, "").length;

function patternOf(key: string): Pattern {
  const literal = key.split(/\{\d+\}/);
  const seen = new Set<string>();
  const source = key.replace(/[.*+?^$()|[\]\\]/g, "\\$&").replace(/\{(\d+)\}/g, (_, i: string) => {
    if (seen.has(i)) return `\\k<p${i}>`;
    seen.add(i);
    return `(?<p${i}>[\\s\\S]*?)`;
  });
  return { key, start: literal[0] ?? "", end: literal.at(-1) ?? "", expression: new RegExp(`^${source}$`) };
}

/** A piece as it is laid into the template: its sentence in another language, or as it is. */
function laid({ parts, places, tags }: Piece, text: string | null): readonly (string | number)[] {
  if (text === null) return parts;
  return text.split(/(\{\d+\}|<\/?\d+>)/).flatMap((part): readonly (string | number)[] => {
    const place = /^\{(\d+)\}$/.exec(part);
    if (place) return [places[Number(place[1])] ?? part];
    const tag = /^<(\/?)(\d+)>$/.exec(part);
    const { name, attributes } = tags[Number(tag?.[2] ?? -1)] ?? {};
    if (!tag || name === undefined || !attributes) return [part];
    return tag[1] === "/" ? [`</${name}>`] : [`<${name}`, ...attributes, ">"];
  });
}

function build(pieces: readonly (readonly (string | number)[])[]): Made {
  const strings = [""];
  const places: number[] = [];
  for (const part of pieces.flat()) {
    if (typeof part === "number") {
      places.push(part);
      strings.push("");
    } else {
      strings[strings.length - 1] += part;
    }
  }
  // lit takes only what looks like the strings of a template.
  return { strings: Object.assign(strings, { raw: strings }) as unknown as TemplateStringsArray, places };
}
