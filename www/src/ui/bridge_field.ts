// A field for the address of a bridge, to be typed, or read by the camera from the code that the
// bridge shows. The page that the bridge serves then replaces this one, because the content
// security policy lets a page talk to its own server only.
//
// A bundle of its own, loaded on demand.

import { css, LitElement, nothing, type TemplateResult } from "lit";
import { pageOf } from "../bridge_page.js";
import { faultOf } from "../fault.js";
import { LANGUAGE_CHANGED } from "../spoken.js";
import { html, t } from "../words.js";
import { icons } from "./icons.js";
import { shared } from "./style.js";

/** Wall milliseconds between two camera pictures that are searched for a code. */
const LOOKS_EVERY = 250;

/** The browsers' reader of codes, for which TypeScript has no types. */
type Detector = new (options: { formats: string[] }) => { detect(source: HTMLVideoElement): Promise<readonly { readonly rawValue: string }[]> };
const detector = (): Detector | null => (globalThis as { BarcodeDetector?: Detector }).BarcodeDetector ?? null;

export class SlamBridgeAddress extends LitElement {
  static override styles = [shared, css`
    form { display: grid; gap: 8px; padding-bottom: 10px; }
    label { display: grid; gap: 4px; font-size: 12.5px; color: var(--muted); }
    input { color: var(--ink); font-size: 14px; }
    .row { display: flex; flex-wrap: wrap; gap: 8px; }
    .row button { flex: 1 1 90px; }
    p { margin: 0; font-size: 12.5px; line-height: 1.5; color: var(--muted); }
    p.bad { color: var(--warn-ink); }
    video { width: 100%; max-height: 40dvh; border-radius: 10px; background: #000; object-fit: cover; }
  `];

  #fault = "";
  #camera: MediaStream | null = null;

  override connectedCallback(): void {
    super.connectedCallback();
    addEventListener(LANGUAGE_CHANGED, () => this.requestUpdate());
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.#rest();
  }

  override render(): TemplateResult {
    // Only pages at a trusted address may ask for a camera.
    const canScan = detector() !== null && navigator.mediaDevices !== undefined;
    return html`<form @submit=${(event: SubmitEvent) => this.#open(event)}>
      <label>Address of the bridge<input type="text" inputmode="url" autocomplete="url" autocapitalize="none" spellcheck="false" data-testid="bridge-address" placeholder="robot.local:8080" @input=${() => this.#tell("")}></label>
      ${this.#fault ? html`<p class="bad" role="alert" data-testid="bridge-address-fault">${this.#fault}</p>` : nothing}
      <div class="row"><button data-testid="bridge-open">${icons.open} Open</button>
        ${canScan ? html`<button type="button" data-testid="bridge-scan" aria-pressed=${this.#camera !== null} @click=${() => void this.#scan()}>${this.#camera ? "Shut the camera" : "Scan its code"}</button>` : nothing}</div>
      ${this.#camera ? html`<video muted playsinline autoplay .srcObject=${this.#camera}></video>` : nothing}
      <p>The bridge prints it when it starts, and as a code by <code>slamlab-bridge token --qr</code>. The page that it serves takes the place of this one.</p>
    </form>`;
  }

  get #field(): HTMLInputElement {
    return this.renderRoot.querySelector("input") as HTMLInputElement;
  }

  #tell(fault: string): void {
    this.#fault = fault;
    this.requestUpdate();
  }

  #open(event: SubmitEvent): void {
    event.preventDefault();
    const page = pageOf(this.#field.value);
    if (page === null) this.#tell(t("An address looks like robot.local:8080, or https://192.168.1.7:8080."));
    else location.assign(page);
  }

  /** The address read is put into the field: the person decides whether to go there. */
  async #scan(): Promise<void> {
    const Codes = detector();
    if (this.#camera || !Codes) return this.#rest();
    try {
      this.#camera = await navigator.mediaDevices.getUserMedia({ video: { facingMode: "environment" } });
      // Somebody closed the panel meanwhile.
      if (!this.isConnected) return this.#rest();
      this.#tell("");
      await this.updateComplete;
      const codes = new Codes({ formats: ["qr_code"] });
      while (this.#camera) {
        await new Promise((done) => setTimeout(done, LOOKS_EVERY));
        const video = this.renderRoot.querySelector("video");
        const found = video && video.readyState >= video.HAVE_CURRENT_DATA ? (await codes.detect(video)).find(({ rawValue }) => pageOf(rawValue) !== null) : undefined;
        if (!found) continue;
        this.#field.value = found.rawValue;
        this.#rest();
      }
    } catch (error) {
      this.#rest();
      this.#tell(t`The camera cannot be used: ${faultOf(error).text}`);
    }
  }

  #rest(): void {
    for (const track of this.#camera?.getTracks() ?? []) track.stop();
    this.#camera = null;
    this.requestUpdate();
  }
}

customElements.define("slam-bridge-address", SlamBridgeAddress);
