// The page's address, and the part behind it: the link of a run, a lesson, or an experiment. It
// also receives the link of the run that is shown.

import type { Client } from "./client.js";
import { exhibit, exhibitAt } from "./gallery.js";
import { lessonAt, teach } from "./lessons.js";
import { addressOfLink, isLink, isOwnAddress, isSaid, isSharedWorld, MOST_ADDRESS, MOST_MESSAGE, saidOf } from "./link.js";
import type { Store } from "./store.js";
import { t } from "./words.js";

export class PageAddress {
  /** Name of the lesson that begins as soon as the list of lessons is known. */
  #wanted: string | null = null;

  constructor(private readonly client: Client, private readonly store: Store) {}

  /** Begins what the part after the `#` names; `false` if it names nothing. */
  open(hash: string): boolean {
    if (isLink(hash)) {
      this.client.follow(hash);
      return true;
    }
    const lesson = lessonAt(hash);
    if (lesson !== null) {
      this.#lesson(lesson);
      return true;
    }
    const found = exhibitAt(hash);
    if (found === null) {
      if (isSaid(hash) && !isSharedWorld(hash)) this.client.refuse(t`The address ends in ${saidOf(hash)}, which names no run, lesson, experiment or world of this page.`);
      return false;
    }
    if (typeof found !== "string") {
      exhibit(this.store, this.client, found);
      return true;
    }
    this.client.refuse(t`There is no experiment ${found}. Under Experiments (G) stand all that there are.`);
    return false;
  }

  /** The list of lessons is known. */
  offered(): void {
    if (this.#wanted !== null) this.#lesson(this.#wanted);
    this.#wanted = null;
  }

  /** Begins a lesson as soon as the list of lessons is known. */
  #lesson(name: string): void {
    const { lessons } = this.store.offer;
    if (lessons.length === 0) {
      this.#wanted = name;
      return;
    }
    const lesson = lessons.find((each) => each.name === name);
    if (lesson) return teach(this.store, this.client, lesson);
    this.client.refuse(t`There is no lesson ${name}. Under Experiments (G) stand all that there are.`);
    if (!this.client.hasRun) this.client.start();
  }

  /** Puts a link into the address and on the clipboard. */
  async give(link: string): Promise<void> {
    const address = addressOfLink(link);
    const letters = address.length;
    if (link.length > MOST_ADDRESS) {
      this.client.warn(t`The link would have ${letters} letters, more than an address takes: the world in it is large. Save the run as a file instead: dropped onto this page it does the run again.`);
      return;
    }
    history.replaceState(null, "", address);
    try {
      await navigator.clipboard.writeText(address);
      if (letters > MOST_MESSAGE) {
        this.client.warn(t`The link is copied, but it has ${letters} letters, and many messengers cut a message at ${MOST_MESSAGE}. Saved as a file it can be sent as well: dropped onto this page it does the run again.`);
        return;
      }
      this.store.set("toast", { toast: { level: "good", text: isOwnAddress(location.hostname)
        ? "The link is copied: it does this run again, to the bit, with all that you did. It leads to this computer: for others write the address of a page of slamlab that they reach in place of what stands before the #."
        : "The link is copied: it does this run again, to the bit, with all that you did." } });
    } catch {
      // The clipboard needs permission and TLS.
      this.store.set("toast", { toast: { level: "info", text: "The link stands in the address of this page: it does this run again, with all that you did." } });
    }
  }
}
