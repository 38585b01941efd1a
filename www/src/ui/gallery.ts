// The gallery: a dozen experiments, each started by a click.

import { css, nothing, type TemplateResult } from "lit";
import { EXAMPLE, openExample } from "../example.js";
import { addressOf, type Exhibit, exhibit, EXHIBITS } from "../gallery.js";
import { addressOf as addressOfLesson, passed, teach } from "../lessons.js";
import type { LessonInfo, MethodName } from "../protocol/module.js";
import { isNarrow } from "../screen.js";
import { html, t } from "../words.js";
import { worldTitle } from "../worlds.js";
import { dialog, SlamDialog } from "./dialog.js";
import { icons } from "./icons.js";

export class SlamGallery extends SlamDialog {
  static override styles = [dialog, css`
    dialog { width: min(940px, calc(100vw - 24px)); }
    ul { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(260px, 100%), 1fr)); gap: 10px; margin: 6px 0 0; padding: 0; list-style: none; }
    li { display: grid; }
    li button { display: grid; align-content: start; justify-items: start; justify-content: stretch; grid-template-columns: minmax(0, 1fr); gap: 4px; width: 100%; height: 100%; padding: 13px 15px; white-space: normal; text-align: left; border-radius: 14px; }
    b { font-weight: 620; font-size: 15px; }
    small { font-size: 13px; line-height: 1.4; color: var(--muted); font-weight: 400; }
    h3:not(#title) { margin: 20px 0 0; }
    .done { color: var(--good); }
    .made { margin-top: 3px; font: 500 11.5px/1.3 var(--mono); color: var(--muted); }
  `];

  protected override readonly topics = ["run"] as const;

  override render(): TemplateResult {
    return html`<dialog aria-labelledby="title" data-testid="gallery" @click=${(e: Event) => e.target === e.currentTarget && this.close()}>
      <header><h3 id="title">Experiments and lessons</h3><button class="icon" aria-label="Close" @click=${() => this.close()}>${icons.close}</button></header>
      <p>Each is a run that is set up so that one thing is seen. It begins at once; what to watch stands beside the map.</p>
      <ul>${EXHIBITS.map((each) => html`<li><button data-testid="exhibit-${each.name}" @click=${() => this.#begin(each)}>
        <b>${each.title}</b><small>${each.about}</small><span class="made">${this.#made(each)}</span></button></li>`)}
        <li><button data-testid="exhibit-recording" @click=${() => this.#open()}>
          <b>A recording is mapped</b><small>What a lidar and wheels logged on a drive all round a ring, simulated too: there is no truth to compare with, as in a recording of yours</small><span class="made">${EXAMPLE} · ${this.#title("scan-matching")}</span></button></li></ul>
      <h3>Lessons</h3>
      <p>Each is a run with a fault. Find the setting or the method that mends it: figures say whether it is, and the map whether you can see it.</p>
      <ul>${this.store.offer.lessons.map((each, place) => this.#lesson(each, place))}</ul>
    </dialog>`;
  }

  #lesson(lesson: LessonInfo, place: number): TemplateResult {
    return html`<li><button data-testid="lesson-${lesson.name}" @click=${() => this.#teach(lesson)}>
      <b>${place + 1}. ${lesson.title}</b><small>${lesson.task}</small><span class="made">${this.#made(lesson)}${passed().has(lesson.name) ? html` · <span class="done">✓ mended</span>` : nothing}</span></button></li>`;
  }

  #teach(lesson: LessonInfo): void {
    this.#clear();
    if (location.hash === addressOfLesson(lesson)) teach(this.store, this.client, lesson);
    else location.hash = addressOfLesson(lesson);
  }

  /** On a phone, closes panels that would cover the map and the card. */
  #clear(): void {
    this.close();
    if (isNarrow()) this.store.set("tab", { tab: "" });
  }

  /** World, sensor and method, by their names in the choosers. */
  #made({ setup }: Pick<Exhibit, "setup"> | LessonInfo): string {
    const { sensors } = this.store.offer;
    const sensor = sensors.find(({ name }) => name === setup.sensor)?.title ?? setup.sensor;
    const method = this.#title(setup.method);
    return [worldTitle(setup.world), sensor, method].map((words) => t(words)).join(" · ");
  }

  #title(method: MethodName): string {
    return this.store.offer.methods.find(({ name }) => name === method)?.title ?? method;
  }

  #open(): void {
    this.#clear();
    void openExample(this.store, this.client);
  }

  /** Experiments have addresses that can be passed on; the page reacts to the address. */
  #begin(each: Exhibit): void {
    this.#clear();
    if (location.hash === addressOf(each)) exhibit(this.store, this.client, each);
    else location.hash = addressOf(each);
  }
}

customElements.define("slam-gallery", SlamGallery);
