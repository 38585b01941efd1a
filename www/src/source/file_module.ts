// The module of file formats, loaded once, when it is first asked for.

import type { FileModule } from "./files.js";

let loaded: Promise<FileModule> | null = null;

/** What reads files of others. Where it cannot be loaded, the next file asks for it again. */
export function fileModule(): Promise<FileModule> {
  loaded ??= fetchModule().catch((error: unknown) => {
    loaded = null;
    console.error(error);
    throw new Error("What reads files of this kind could not be loaded. Is the server still there?");
  });
  return loaded;
}

async function fetchModule(): Promise<FileModule> {
  const { load } = await import(new URL("files.js", self.location.href).href) as { load: () => Promise<FileModule> };
  return load();
}
