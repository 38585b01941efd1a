// The rest of the module: functions that a first visit does not call (xtask/src/bin/split-module).
// It is loaded when somebody does more than watch, or at the latest when one of them is called,
// while the worker waits.

/** The exports of the first part for the rest; no flag if the module was not split. */
type First = WebAssembly.Exports & { readonly rest_is_loaded?: WebAssembly.Global<"i32"> };

const url = (): URL => new URL("slamlab_web_rest.wasm", self.location.href);

const missing = (why: string): Error => new Error(`The rest of the program could not be loaded: ${why}. What there is goes on; try again when the server is there.`);

export class Rest {
  readonly #first: First;
  #coming: Promise<void> | null = null;

  /** Registers a module that was just instantiated. */
  constructor(first: unknown) {
    this.#first = first as First;
    // The module calls it by this name (web/src/rest.rs).
    Object.assign(self, { loadRest: () => this.#loadNow() });
  }

  get #isThere(): boolean {
    return this.#first.rest_is_loaded?.value !== 0;
  }

  /** Loads the rest, if it is missing, without blocking the worker. */
  async whole(): Promise<void> {
    if (this.#isThere) return;
    this.#coming ??= this.#load();
    try {
      await this.#coming;
    } finally {
      this.#coming = null;
    }
  }

  async #load(): Promise<void> {
    const response = await fetch(url()).catch(() => {
      throw missing("the server does not answer");
    });
    if (!response.ok) throw missing(`the server answers ${response.status}`);
    const module = await WebAssembly.compile(await response.arrayBuffer());
    if (!this.#isThere) this.#join(module);
  }

  /** In the middle of a call, blocking is the only way. */
  #loadNow(): void {
    if (this.#isThere) return;
    const request = new XMLHttpRequest();
    // A URL of its own: if the same file is already being loaded, a browser's cache would make this
    // request wait for that one, which waits for this worker.
    request.open("GET", new URL("?now", url()), false);
    request.responseType = "arraybuffer";
    try {
      request.send();
    } catch {
      throw missing("the server does not answer");
    }
    if (request.status !== 200) throw missing(`the server answers ${request.status}`);
    this.#join(new WebAssembly.Module(request.response as ArrayBuffer));
  }

  #join(module: WebAssembly.Module): void {
    try {
      new WebAssembly.Instance(module, { first: this.#first });
    } catch (error) {
      if (error instanceof WebAssembly.LinkError) throw new Error("The rest of the program is of another version than this page. Reload the page.");
      throw error;
    }
    this.#first.rest_is_loaded!.value = 1;
  }
}
