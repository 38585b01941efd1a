// The catalogue of all texts of the page, collected from where they are written: templates, `t`,
// tables of words, and the messages of worker and core. Writes pkg/catalogue.ts, whose types
// require each language of src/words/ to be complete, and checks what types do not: that a
// translation has no placeholder or tag that its English sentence lacks.
//
//     node words.mjs              writes and checks
//     node words.mjs --list       prints each sentence with its place
//     node words.mjs --missing hu prints those that a language lacks

import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import * as esbuild from "esbuild";
import { parseSync, visitorKeys } from "oxc-parser";
import { heardFromCore, saidByCore } from "./words_core.mjs";

const here = new URL("./", import.meta.url);
const at = (path) => new URL(path, here);
const LANGUAGES = ["hu", "cs", "pl"];

/** Files without visible text, or with the languages themselves. */
const SAYS_NOTHING = /^(view\/gl\/|words\/|words\.ts|spoken\.ts|offline_worker\/|protocol\/)/;
/** Texts that these files put together reach the page in English, and are recognised there. */
const TELLS = /^(rest\.ts|source\/|worker\.ts|registration\/worker\.ts|local_bridge\.ts)/;

/** A string that reads like text: two words, or one with a capital. */
const READS_LIKE_WORDS = /\p{L}{2}.* .*\p{L}|^\p{Lu}\p{Ll}+[.…:!?]?$/u;
const NO_WORDS = [
  /IBM Plex Mono|sans-serif$/, // a font
  /^(calc|rgba?|var|matrix|url)\(/, // CSS
  /^slamlab /, // a name
  /^drag \{0\}$/, // of one drag in the editor
  /^(take over|took over|take over alone)$/, // between the page and its service worker
  /^\{0\} and \{1\}$/, // the name of two maps
  /^\s*(body|@media|\})/, // CSS in pieces
  /^(home|loop|task) \{0\}$/, // topics of the log
  /^[#.]/, // selectors
  /^(at least $| ?from \{0\}$)/,
  /^[A-Z][a-z]+(Error|Event)$/, // names of the platform
  /^this browser gives no 2D canvas$|^no #\{0\} in the map$|Path2D/, // of faults in the page itself
  /^\{0\} \{1\}px|px$/, // sizes
  /^(Enter|Escape|Space|Shift|Control|Tab|Home|End|Delete|Backspace|Infinity|HEAD|Arrow\w+|Key\w|Digit\d|Page\w+)$/, // keys
  /^image\/|^text\/|^application\//,
];
/** Functions and attributes whose strings are names, not text. */
const NAMES = new Set(["define", "addEventListener", "removeEventListener", "querySelector", "querySelectorAll", "createElement", "createElementNS", "Event", "CustomEvent", "Worker", "getContext", "matchMedia", "warn"]);

const { takeApart, sentenceOf, saysSomething } = await parser();

/** From each sentence to its place. */
const said = new Map();
const heard = new Map();
const faults = [];

for (const file of readdirSync(at("src"), { recursive: true }).map((name) => name.replaceAll("\\", "/")).sort()) {
  if (file.endsWith(".ts") && !file.endsWith(".d.ts") && !SAYS_NOTHING.test(file)) readSource(file);
}
readPage();
for (const text of saidByCore()) put(said, text, "core");
for (const text of heardFromCore()) put(/\{\d+\}/.test(text) ? heard : said, text, "core");
for (const text of heard.keys()) said.delete(text);

const [option, which] = process.argv.slice(2);
if (option === "--list") {
  for (const [kind, all] of [["said", said], ["heard", heard]]) for (const [text, place] of all) console.log(`${kind}\t${place}\t${text}`);
} else {
  writeFileSync(at("pkg/catalogue.ts"), catalogue());
  for (const language of option === "--missing" ? [which] : LANGUAGES) {
    const { SAID, HEARD } = await tables(language);
    if (option === "--missing") for (const text of [...said.keys()].filter((each) => !(each in SAID)).concat([...heard.keys()].filter((each) => !(each in HEARD)))) console.log(text);
    else for (const [text, phrase] of Object.entries({ ...SAID, ...HEARD })) check(language, text, phrase);
  }
}
for (const fault of faults) console.error(fault);
if (faults.length > 0) process.exit(1);

/** The parser that also splits templates in the page. */
async function parser() {
  const built = await esbuild.build({ entryPoints: [at("src/words/template.ts").pathname], write: false, format: "esm", target: "es2022" });
  return importText(built.outputFiles[0].text);
}

async function tables(language) {
  const built = await esbuild.build({ entryPoints: [at(`src/words/${language}.ts`).pathname], bundle: true, write: false, format: "esm", target: "es2022" });
  return importText(built.outputFiles[0].text);
}

function importText(text) {
  return import(`data:text/javascript;base64,${Buffer.from(text).toString("base64")}`);
}

function put(where, text, place) {
  if (!where.has(text)) where.set(text, place);
}

function readPage() {
  const text = readFileSync(at("index.html"), "utf8");
  for (const [, label] of text.matchAll(/aria-label="([^"]+)"/g)) put(said, label, "index.html");
  put(said, /<title>([^<]+)</.exec(text)[1], "index.html");
}

function readSource(file) {
  const code = readFileSync(at(`src/${file}`), "utf8");
  const { program, errors } = parseSync(file, code);
  if (errors.length > 0) throw new Error(`${file}: ${errors[0].message}`);
  const place = (node) => `${file}:${code.slice(0, node.start).split("\n").length}`;

  /** `isSpoken`: at this place a string is visible text, whatever it looks like. */
  const visit = (node, parent, key, isSpoken) => {
    if (Array.isArray(node)) return node.forEach((each) => visit(each, parent, key, isSpoken));
    if (!node || typeof node.type !== "string") return;
    if (node.type.startsWith("TS") && !["TSAsExpression", "TSSatisfiesExpression", "TSNonNullExpression"].includes(node.type)) return;
    if (node.type === "ImportDeclaration" || node.type === "ExportAllDeclaration" || node.type === "ImportExpression") return;
    if (node.type === "TaggedTemplateExpression") return tagged(node);
    if (node.type === "Literal") return literal(node, parent, key, isSpoken);
    if (node.type === "TemplateLiteral") return template(node);
    if (node.type === "CallExpression" && (node.callee.name === "t" || node.callee.name === "word")) return visit(node.arguments, node, "arguments", true);
    const passes = ["ConditionalExpression", "LogicalExpression", "ParenthesizedExpression"].includes(node.type);
    for (const each of visitorKeys[node.type] ?? []) {
      const isTest = node.type === "ConditionalExpression" && each === "test";
      visit(node[each], node, each, passes && !isTest && isSpoken);
    }
  };

  const tagged = (node) => {
    const strings = node.quasi.quasis.map((each) => each.value.cooked);
    const tag = node.tag.name;
    if (tag === "css") return;
    let spoken = new Set();
    if (tag === "html" || tag === "svg") {
      const taken = takeApart(strings);
      ({ spoken } = taken);
      for (const { message } of taken.pieces) if (message !== null) put(said, message, place(node));
    } else if (tag === "t") {
      put(said, sentenceOf(strings), place(node));
      spoken = new Set(strings.keys());
    }
    node.quasi.expressions.forEach((each, i) => visit(each, node, "expressions", spoken.has(i)));
  };

  const literal = (node, parent, key, isSpoken) => {
    const { value } = node;
    if (typeof value !== "string" || !saysSomething(value)) return;
    if ((parent?.type === "Property" && key === "key") || ["BinaryExpression", "SwitchCase", "MemberExpression"].includes(parent?.type)) return;
    if (parent?.type === "CallExpression" || parent?.type === "NewExpression") {
      const name = parent.callee.name ?? parent.callee.property?.name;
      if (NAMES.has(name)) return;
    }
    if (isSpoken || (READS_LIKE_WORDS.test(value) && !NO_WORDS.some((each) => each.test(value)))) put(said, value, place(node));
  };

  const template = (node) => {
    const strings = node.quasis.map((each) => each.value.cooked);
    const sentence = sentenceOf(strings);
    const isWords = /\p{L}{3}/u.test(sentence) && / /.test(sentence.trim()) && !NO_WORDS.some((each) => each.test(sentence));
    if (isWords && strings.length === 1) put(said, sentence, place(node));
    else if (isWords && TELLS.test(file)) put(heard, sentence, place(node));
    else if (isWords) faults.push(`${place(node)}: \`${sentence}\` is put together here: say it by t\`…\``);
    if (!TELLS.test(file)) for (const each of node.expressions.flatMap(choices)) {
      if (each.type === "Literal" && READS_LIKE_WORDS.test(each.value)) faults.push(`${place(each)}: "${each.value}" becomes a part of what is put together here: say that by t\`…\``);
    }
    for (const each of node.expressions) visit(each, node, "expressions", false);
  };

  visit(program, null, "", false);
}

/** The possible values of an expression. */
function choices(node) {
  if (node.type === "ConditionalExpression") return [...choices(node.consequent), ...choices(node.alternate)];
  if (node.type === "LogicalExpression") return [...choices(node.left), ...choices(node.right)];
  return node.type === "ParenthesizedExpression" ? choices(node.expression) : [node];
}

function catalogue() {
  const entries = (all) => [...all.keys()].map((text) => `  ${JSON.stringify(text)}: Phrase<${partsOf(text).map((part) => `Has<${JSON.stringify(part)}>`).join(" & ") || "string"}>;`).join("\n");
  return `// Written by words.mjs: all that the page says.
import type { Phrase } from "../src/words/translator.js";

type Has<T extends string> = \`\${string}\${T}\${string}\`;

/** What is said by templates, \`t\` and tables. */
export interface Said {
${entries(said)}
}

/** What worker and core put together. */
export interface Heard {
${entries(heard)}
}
`;
}

/** Placeholders and tags of a sentence. */
function partsOf(text) {
  return [...new Set([...text.matchAll(/\{\d+\}|<\/?[a-z0-9]+>/g)].map(([part]) => part))];
}

function check(language, text, phrase) {
  const allowed = new Set(partsOf(text));
  const forms = typeof phrase === "string" ? [phrase] : Object.entries(phrase).filter(([name]) => name !== "by").map(([, form]) => form);
  for (const form of forms) {
    const strange = partsOf(form).filter((part) => !allowed.has(part));
    if (strange.length > 0) faults.push(`${language}: "${form}" has ${strange.join(" ")}, which "${text}" has not`);
    if (form.trim() === "") faults.push(`${language}: "${text}" is empty`);
  }
  if (typeof phrase === "string") return;
  if (!allowed.has(`{${phrase.by}}`)) faults.push(`${language}: "${text}" has no {${phrase.by}} to choose a form by`);
  const needed = new Set(new Intl.PluralRules(language).resolvedOptions().pluralCategories);
  for (const category of needed) if (!(category in phrase)) faults.push(`${language}: "${text}" lacks its form "${category}"`);
}
