// The rest of the module: functions that a first visit does not run (xtask/src/bin/split-module).
// It comes when somebody does more than watch, or at the latest, while the worker waits, at the
// first call of one of them.

/** What the first part exports for the rest; no flag where the module is whole. */
type First = WebAssembly.Exports & { readonly rest_is_loaded?: WebAssembly.Global<"i32"> };

const url = (): URL => new URL("slamlab_web_rest.wasm", self.location.href);

const missing = (why: string): Error => new Error(`The rest of the program could not be loaded: ${why}. What there is goes on; try again when the server is there.`);

export class Rest {
  readonly #first: First;
  #coming: Promise<void> | null = null;

  /** Takes care of a module that was just instantiated. */
  constructor(first: unknown) {
    this.#first = first as First;
    // The module calls it by this name (web/src/rest.rs).
    Object.assign(self, { loadRest: () => this.#loadNow() });
  }

  get #isThere(): boolean {
    return this.#first.rest_is_loaded?.value !== 0;
  }

  /** Loads it, if it is not there, while the worker goes on. */
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

  /** In the middle of a call there is nothing else to do than to wait. */
  #loadNow(): void {
    if (this.#isThere) return;
    const request = new XMLHttpRequest();
    // By a name of its own: while the same file is on its way here, a browser's cache would have
    // this wait for it, and that for this worker.
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
