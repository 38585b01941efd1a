// What is said in a template: the template taken apart into what stays as it is and the sentences
// that are translated as a whole. Page and catalogue (words.mjs) take it apart by this alone.
//
// A sentence is what stands together between two tags that part it: text, places for values, and
// inline elements within it. Places are {0}, {1} …; `<b>` without attributes stays itself, an
// inline element with attributes is <0>…</0>, with the attributes that it has in the template.

export interface Piece {
  /** Text and places, in their order. A number is a place of the template. */
  readonly parts: readonly (string | number)[];
  /** The sentence, if it is one. */
  readonly message: string | null;
  /** Of a sentence: which place of the template {0}, {1} … is. */
  readonly places: readonly number[];
  /** Of a sentence: what <0>, <1> … begin with. */
  readonly tags: readonly { readonly name: string; readonly attributes: readonly (string | number)[] }[];
}

export interface Taken {
  readonly pieces: readonly Piece[];
  /** Places in which a string is something said. */
  readonly spoken: ReadonlySet<number>;
}

/** Attributes that people read or hear. */
export const SAID_BY_ATTRIBUTES: ReadonlySet<string> = new Set(["title", "aria-label", "aria-description", "aria-roledescription", "aria-valuetext", "alt", "label", "placeholder"]);
const INLINE: ReadonlySet<string> = new Set(["b", "strong", "i", "em", "kbd", "code", "small", "sub", "sup", "span", "a", "q", "br", "var", "abbr"]);
const VOID: ReadonlySet<string> = new Set(["br", "hr", "img", "input", "link", "meta", "wbr"]);
const NOTHING_SAID: ReadonlySet<string> = new Set(["style", "script"]);
/** Two letters of any script: what has fewer is a sign or a unit, and the same everywhere. */
const SAYS_SOMETHING = /\p{L}{2}/u;

export const saysSomething = (text: string): boolean => SAYS_SOMETHING.test(text.replace(/\{\d+\}|<[^>]*>|&\w+;/g, " "));

type Node = { readonly kind: "text"; readonly text: string } | { readonly kind: "place"; readonly place: number } | Element;
interface Element { readonly kind: "element"; readonly name: string; readonly open: string; readonly close: string; readonly children: Node[] }

/** Stands for a place while a template is one text. */
const MARK = /\u0001(\d+)\u0002/;
const TOKEN = /<!--[\s\S]*?-->|<\/[a-zA-Z][^>]*>|<[a-zA-Z](?:"[^"]*"|'[^']*'|[^>"'])*>|\u0001\d+\u0002|(?:(?!<[a-zA-Z/!])[^\u0001])+/g;
const ATTRIBUTE = /(\s)([a-zA-Z-]+)=(?:"([^"]*)"|\u0001(\d+)\u0002)/g;

export function takeApart(strings: readonly string[]): Taken {
  const text = strings.map((each, i) => (i === 0 ? each : `\u0001${i - 1}\u0002${each}`)).join("");
  const root: Element = { kind: "element", name: "", open: "", close: "", children: nodesOf(text) };
  const out: Piece[] = [];
  const spoken = new Set<number>();
  emitChildren(root, out, spoken);
  return { pieces: out, spoken };
}

/** The text of a sentence that stands alone, as that of `t`. */
export function sentenceOf(strings: readonly string[]): string {
  return strings.map((each, i) => (i === 0 ? each : `{${i - 1}}${each}`)).join("");
}

function nodesOf(text: string): Node[] {
  const stack: { name: string; open: string; children: Node[] }[] = [{ name: "", open: "", children: [] }];
  const top = (): Node[] => stack.at(-1)?.children ?? [];
  const shut = (close: string): void => {
    const { name, open, children } = stack.pop() ?? { name: "", open: "", children: [] };
    top().push({ kind: "element", name, open, close, children });
  };
  for (const [token] of text.matchAll(TOKEN)) {
    const place = MARK.exec(token);
    if (token.startsWith("</")) {
      const name = token.slice(2, -1).trim().toLowerCase();
      if (!stack.some((each) => each.name === name)) {
        top().push({ kind: "element", name: "!", open: token, close: "", children: [] });
        continue;
      }
      while (stack.at(-1)?.name !== name) shut("");
      shut(token);
    } else if (token.startsWith("<!--")) {
      top().push({ kind: "element", name: "!", open: token, close: "", children: [] });
    } else if (token.startsWith("<") && /^<[a-zA-Z]/.test(token)) {
      const name = (/^<([^\s/>\u0001]+)/.exec(token)?.[1] ?? "").toLowerCase();
      if (VOID.has(name) || token.endsWith("/>")) top().push({ kind: "element", name, open: token, close: "", children: [] });
      else stack.push({ name, open: token, children: [] });
    } else if (place && token.length === place[0].length) {
      top().push({ kind: "place", place: Number(place[1]) });
    } else {
      top().push({ kind: "text", text: token });
    }
  }
  while (stack.length > 1) shut("");
  return top();
}

function emitChildren({ name, children }: Element, out: Piece[], spoken: Set<number>): void {
  if (NOTHING_SAID.has(name)) {
    for (const child of children) emitNode(child, out, spoken);
    return;
  }
  let run: Node[] = [];
  const flush = (): void => {
    emitRun(run, out, spoken);
    run = [];
  };
  for (const child of children) {
    if (child.kind !== "element" || isInline(child)) {
      run.push(child);
    } else {
      flush();
      emitNode(child, out, spoken);
    }
  }
  flush();
}

function isInline({ name, children }: Element): boolean {
  return INLINE.has(name) && children.every((child) => child.kind !== "element" || isInline(child));
}

/** Text of its own makes a sentence of what stands together; without, each element says what it
    says. */
function emitRun(run: readonly Node[], out: Piece[], spoken: Set<number>): void {
  if (!run.some((node) => node.kind === "text" && saysSomething(node.text))) {
    for (const node of run) emitNode(node, out, spoken);
    return;
  }
  const first = run.findIndex((node) => node.kind !== "text" || node.text.trim() !== "");
  const last = run.findLastIndex((node) => node.kind !== "text" || node.text.trim() !== "");
  for (const node of run.slice(0, first)) emitNode(node, out, spoken);
  const sentence = new Sentence(spoken);
  for (const node of run.slice(first, last + 1)) sentence.add(node);
  const { lead, piece, trail } = sentence.done();
  out.push(plain(lead), piece, plain(trail));
  for (const node of run.slice(last + 1)) emitNode(node, out, spoken);
}

function emitNode(node: Node, out: Piece[], spoken: Set<number>): void {
  if (node.kind === "text") {
    out.push(plain(node.text));
  } else if (node.kind === "place") {
    spoken.add(node.place);
    out.push(plain(node.place));
  } else {
    emitTag(node.open, out, spoken);
    emitChildren(node, out, spoken);
    if (node.close !== "") out.push(plain(node.close));
  }
}

/** A tag, and what its attributes say. */
function emitTag(open: string, out: Piece[], spoken: Set<number>): void {
  let from = 0;
  for (const match of open.matchAll(ATTRIBUTE)) {
    const [whole, space = "", name = "", value, place] = match;
    if (!SAID_BY_ATTRIBUTES.has(name)) continue;
    const at = match.index + space.length;
    out.push(plain(...partsOf(open.slice(from, at))));
    from = match.index + whole.length;
    if (place !== undefined) {
      spoken.add(Number(place));
      out.push(plain(`${name}=`, Number(place)));
      continue;
    }
    const parts = partsOf(value ?? "");
    const places = parts.filter((part) => typeof part === "number");
    for (const each of places) spoken.add(each);
    const message = parts.map((part) => (typeof part === "number" ? `{${places.indexOf(part)}}` : part)).join("");
    out.push(plain(`${name}="`), { parts, message: saysSomething(message) ? message : null, places, tags: [] }, plain('"'));
  }
  out.push(plain(...partsOf(open.slice(from))));
}

class Sentence {
  readonly #parts: (string | number)[] = [];
  readonly #places: number[] = [];
  readonly #tags: { name: string; attributes: (string | number)[] }[] = [];
  #text = "";

  constructor(private readonly spoken: Set<number>) {}

  add(node: Node): void {
    if (node.kind === "text") {
      this.#parts.push(node.text);
      this.#text += node.text;
      return;
    }
    if (node.kind === "place") {
      this.spoken.add(node.place);
      this.#parts.push(node.place);
      this.#text += `{${this.#places.push(node.place) - 1}}`;
      return;
    }
    const attributes = node.open.slice(1 + node.name.length, -1);
    this.#parts.push(...partsOf(node.open));
    const isBare = attributes.trim() === "" || attributes.trim() === "/";
    const name = isBare ? node.name : String(this.#tags.push({ name: node.name, attributes: partsOf(attributes) }) - 1);
    this.#text += `<${name}>`;
    for (const child of node.children) this.add(child);
    this.#parts.push(node.close);
    if (node.close !== "") this.#text += `</${name}>`;
  }

  /** White space at either end belongs to the template. */
  done(): { lead: string; piece: Piece; trail: string } {
    const lead = /^\s*/.exec(this.#text)?.[0] ?? "";
    const trail = /\s*$/.exec(this.#text)?.[0] ?? "";
    const message = this.#text.trim().replace(/\s+/g, " ");
    const parts = [...this.#parts];
    if (typeof parts[0] === "string") parts[0] = parts[0].trimStart();
    const end = parts.length - 1;
    const last = parts[end];
    if (typeof last === "string") parts[end] = last.trimEnd();
    return { lead, piece: { parts, message, places: this.#places, tags: this.#tags }, trail };
  }
}

const plain = (...parts: (string | number)[]): Piece => ({ parts, message: null, places: [], tags: [] });

function partsOf(text: string): (string | number)[] {
  return text.split(/(\u0001\d+\u0002)/).map((part) => {
    const place = MARK.exec(part);
    return place ? Number(place[1]) : part;
  });
}
