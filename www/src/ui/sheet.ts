// The sheets of a phone: each closes by a swipe down, and lies above the steering controls,
// whatever their height.

import { narrowScreen } from "../screen.js";
import type { Store } from "../store.js";

/** A sheet that is pulled down this far closes, CSS pixels. */
const SHUTS = 72;
/** Height of the tabs below the steering controls, CSS pixels. */
const TABS = 51;

export function startSheets(store: Store): void {
  const phone = narrowScreen();
  for (const sheet of document.querySelectorAll<HTMLElement>("#side > section, #legend")) new Drag(sheet, phone, () => store.set("tab", { tab: "" }));

  const dock = document.querySelector<HTMLElement>("#dock");
  const steers = dock?.querySelectorAll<HTMLElement>('[data-place="slam-cycle"], [data-place="slam-timeline"], [data-place="slam-transport"]');
  if (!dock || !steers) return;
  const measure = (): void => {
    if (!phone.matches) return;
    const tops = [...steers].filter(({ offsetHeight }) => offsetHeight > 0).map((part) => part.getBoundingClientRect().top);
    const height = dock.getBoundingClientRect().bottom - Math.min(...tops);
    if (tops.length > 0) document.documentElement.style.setProperty("--dock", `${Math.ceil(height) + TABS}px`);
  };
  const observer = new ResizeObserver(measure);
  for (const part of [dock, ...steers]) observer.observe(part);
}

class Drag {
  /** Where the touch began; null while the sheet scrolls, or something in it is dragged. */
  #from: number | null = null;

  constructor(private readonly sheet: HTMLElement, private readonly phone: MediaQueryList, private readonly shut: () => void) {
    sheet.addEventListener("touchstart", (event) => this.#begin(event), { passive: true });
    sheet.addEventListener("touchmove", (event) => this.#move(event), { passive: true });
    sheet.addEventListener("touchend", (event) => this.#end(event), { passive: true });
    sheet.addEventListener("touchcancel", () => this.#rest(), { passive: true });
  }

  #begin(event: TouchEvent): void {
    const [finger, ...more] = event.touches;
    this.#rest();
    if (!this.phone.matches || !finger || more.length > 0) return;
    const within = event.composedPath().slice(0, event.composedPath().indexOf(this.sheet) + 1).filter((part) => part instanceof Element);
    const isTaken = within.some((part) => part.scrollTop > 0 || part.matches("input[type=range],select,canvas") || getComputedStyle(part).touchAction !== "auto");
    if (!isTaken) this.#from = finger.clientY;
  }

  #move(event: TouchEvent): void {
    const by = this.#by(event.touches[0]);
    // An upward move scrolls, and keeps scrolling.
    if (by < 0 || this.sheet.scrollTop > 0) this.#rest();
    else if (by > 0) this.sheet.style.transform = `translateY(${by}px)`;
  }

  #end(event: TouchEvent): void {
    const shuts = this.#by(event.changedTouches[0]) > SHUTS;
    this.#rest();
    if (shuts) this.shut();
  }

  #by(finger: Touch | undefined): number {
    return this.#from === null || !finger ? 0 : finger.clientY - this.#from;
  }

  #rest(): void {
    this.#from = null;
    this.sheet.style.removeProperty("transform");
  }
}
