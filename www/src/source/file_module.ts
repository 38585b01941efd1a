// The module of file formats, loaded once, on first use.

import type { FileModule } from "./files.js";

let loaded: Promise<FileModule> | null = null;

/** The reader of foreign files. If it cannot be loaded, the next file tries again. */
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
