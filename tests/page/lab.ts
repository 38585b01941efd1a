// The page in a user's hands: what the tests do and see, in the user's words.
//
// Tests assert what a user sees; `window.slamlab` provides the numbers to wait for.
import { expect, type Locator, type Page } from '@playwright/test';
import { filesIn } from './archive.ts';
import type { BridgeState } from '../../www/src/protocol/devices.ts';
import type { Status } from '../../www/src/protocol/frame.ts';
import type { Grade, Setup } from '../../www/src/protocol/module.ts';

interface Window {
  slamlab: {
    status: Status | null;
    hash: string;
    playing: boolean;
    /** The moment that the run is on its way to, s. */
    seeking: number | null;
    source: string;
    title: string;
    setup: Setup;
    grade: Grade | null;
    method: string;
    /** Highlighted walls. */
    spot: { hovered: number[]; pinned: number | null };
    seq: number;
    blocks: number;
    framesPerSecond: number;
    camera: { x: number; y: number; scale: number; angle: number };
    drawnWith: string;
    toScreen(x: number, y: number): [number, number];
    /** Doors of the simulated world, see DOOR of the protocol. */
    doors: number[];
    /** Ends of a wall, map frame, m: x1 y1 x2 y2. */
    wall(id: number): number[] | null;
  };
}

/** The view counts as still after this time without motion, ms: it is refitted every 300. */
const STANDS = 450;

export type Panel = 'run' | 'status' | 'plots' | 'filter' | 'paths' | 'settings' | 'layers' | 'log';

/** What can be read from the page without a function call. */
export type State = Omit<Window['slamlab'], 'toScreen' | 'wall'>;

export class Lab {
  constructor(readonly page: Page) {}

  /** Opens the page and waits until the robot has looked around. */
  async open(address = '/'): Promise<void> {
    await this.page.goto(address);
    // It begins only once its language is loaded, unless that is English.
    const scans = async () => ((await this.page.evaluate(() => 'slamlab' in window)) ? (await this.state()).status?.scans ?? 0 : 0);
    await expect.poll(scans, 'the robot scans').toBeGreaterThan(0);
  }

  at(id: string): Locator {
    return this.page.getByTestId(id);
  }

  state(): Promise<State> {
    return this.page.evaluate(() => {
      const { slamlab: s } = window as unknown as Window;
      return {
        status: s.status, hash: s.hash, playing: s.playing, seeking: s.seeking, source: s.source, title: s.title, setup: s.setup, grade: s.grade, method: s.method, spot: s.spot, seq: s.seq, blocks: s.blocks,
        framesPerSecond: s.framesPerSecond, camera: s.camera, doors: s.doors, drawnWith: s.drawnWith,
      };
    });
  }

  /** What the page knows of its robot's bridge. */
  bridge(): Promise<BridgeState | null> {
    return this.page.evaluate(() => (window as unknown as { slamlab: { bridge: BridgeState | null } }).slamlab.bridge);
  }

  /** What the page shows; just after a start it has shown nothing yet. */
  async status(): Promise<Status> {
    let status: Status | null = null;
    const seen = async () => (status = (await this.state()).status) !== null;
    await expect.poll(seen, { message: 'the page shows a status', timeout: 30_000, intervals: [20, 50, 100] }).toBe(true);
    return status!;
  }

  /** Polls a number or a word of the status. */
  watch<T>(read: (status: Status) => T, message: string, timeout = 30_000) {
    return expect.poll(async () => read(await this.status()), { message, timeout, intervals: [50, 100, 200] });
  }

  /** On a phone the panels are behind tabs; on a wide screen all are open. */
  async show(panel: Panel): Promise<void> {
    const tab = this.at(`tab-${panel}`);
    if ((await tab.isVisible()) && (await tab.getAttribute('aria-pressed')) !== 'true') await tab.click();
  }

  /** Opens the fold with submaps, saved and prior maps. */
  async showMaps(): Promise<void> {
    await this.show('run');
    if (!(await this.page.locator('slam-maps details').evaluate((fold: HTMLDetailsElement) => fold.open))) await this.at('maps').click();
  }

  /** Closes the sheet of a phone, so that the map is free. */
  async hidePanels(): Promise<void> {
    const open = this.page.locator('slam-tabs [aria-pressed="true"]').filter({ visible: true });
    if (await open.isVisible()) await open.click();
  }

  /** Starts a run in another world, as fast as possible or at the given speed. */
  async enter(world: string, speed = 'Infinity'): Promise<void> {
    await this.at('speed').selectOption(speed);
    await this.show('run');
    await this.at('world').selectOption(world);
    await expect.poll(async () => (await this.state()).setup.world).toBe(world);
    await this.watch((s) => s.scans, 'the run begins').toBeGreaterThan(0);
    await this.hidePanels();
  }

  async speed(factor: string): Promise<void> {
    await this.at('speed').selectOption(factor);
  }

  /** Saves only these by the dialog, once they are collected. */
  async save(...kinds: string[]): Promise<void> {
    await this.show('run');
    await this.at('save').click();
    await this.at('saving-none').click();
    for (const kind of kinds) await this.at(`saving-${kind}`).check();
    await this.at('saving-save').click();
    await expect(this.at('saving')).toBeHidden();
  }

  /** Saves the map for ROS by the dialog: its PGM and its YAML, as the page accepts them. */
  async savedMap(): Promise<{ name: string; mimeType: string; buffer: Buffer }[]> {
    const coming = this.page.waitForEvent('download');
    await this.save('map');
    const files = [...await filesIn(await coming)].map(([name, buffer]) => ({ name, mimeType: '', buffer }));
    expect(files.map(({ name }) => name.replace(/^.*\./, '')).sort(), 'two files come').toEqual(['pgm', 'yaml']);
    return files;
  }

  /** Checks the text of the message; code in it is compared between backticks. */
  async says(words: string | RegExp, what = 'the message'): Promise<void> {
    const read = (): Promise<string | null> => this.at('toast').evaluate((element) => {
      const copy = element.cloneNode(true) as Element;
      for (const code of copy.querySelectorAll('code')) code.replaceWith(`\`${code.textContent}\``);
      return copy.textContent;
    }, undefined, { timeout: 1000 }).catch(() => null);
    const said = expect.poll(read, { message: what, timeout: 10_000, intervals: [50, 100, 200] });
    await (typeof words === 'string' ? said.toContain(words) : said.toMatch(words));
  }

  /** Steps through the things at a place of the map until the inspector shows one of this kind. */
  async inspectAt(kind: string, x: number, y: number): Promise<void> {
    await this.pointAt(x, y, false);
    for (let more = 0; more < 9 && (await this.at(`${kind}-title`).count()) === 0; more += 1) await this.at('inspect-next').click();
    await expect(this.at(`${kind}-title`)).toBeVisible();
  }

  /** Pauses, and waits until the last frame has come. */
  async pause(): Promise<void> {
    // A run that has ended meanwhile stands still, and cannot be paused.
    const ended = async (): Promise<boolean> => (await this.status()).finished;
    // A run that is just ending loses this button.
    if ((await this.state()).playing && !(await ended())) await this.at('play').click({ timeout: 5_000 }).catch(() => {});
    await this.stands();
  }

  /** Waits until the last frame of a run that was paused, or has ended, has come. */
  async stands(): Promise<void> {
    // A frame made while the run stands has no pace: no scan comes after it.
    const isPaused = async (): Promise<boolean> => !(await this.state()).playing && Number.isNaN((await this.status()).realTimeFactor);
    await expect.poll(async () => (await isPaused()) || (await this.status()).finished).toBe(true);
  }

  /** Clicks or taps a point of the map, map frame, m. */
  async pointAt(x: number, y: number, touch: boolean): Promise<void> {
    await this.stillCamera();
    const box = await this.at('map').boundingBox();
    if (!box) throw new Error('the map is not shown');
    const [screenX, screenY] = await this.page.evaluate(
      ([x, y]) => (window as unknown as Window).slamlab.toScreen(x!, y!),
      [x, y],
    );
    if (touch) await this.page.touchscreen.tap(box.x + screenX, box.y + screenY);
    else await this.page.mouse.click(box.x + screenX, box.y + screenY);
  }

  /** The middle of a wall of the line map, m. */
  async wallMiddle(id: number): Promise<[number, number]> {
    const ends = await this.page.evaluate((id) => (window as unknown as Window).slamlab.wall(id), id);
    if (!ends) throw new Error(`there is no wall ${id}`);
    const [x1 = 0, y1 = 0, x2 = 0, y2 = 0] = ends;
    return [(x1 + x2) / 2, (y1 + y2) / 2];
  }

  /** The picture of the map, without elements over it, as the bytes of a PNG. */
  async picture(): Promise<string> {
    return this.page.evaluate(() => {
      const { picture } = (window as unknown as { slamlab: { picture: ImageData } }).slamlab;
      const canvas = Object.assign(document.createElement('canvas'), { width: picture.width, height: picture.height });
      canvas.getContext('2d')!.putImageData(picture, 0, 0);
      return canvas.toDataURL();
    });
  }

  /** The part of the pixels drawn in either of two such pictures that differ clearly; `turned`: the
      second one is upside down, turned around a point. */
  async differing(first: string, second: string, turned: readonly [number, number] | null = null): Promise<{ part: number; drawn: number }> {
    return this.page.evaluate(async ([first, second, turned]) => {
      const pixelsOf = async (url: string): Promise<ImageData> => {
        const image = new Image();
        image.src = url;
        await image.decode();
        const context = Object.assign(document.createElement('canvas'), { width: image.width, height: image.height }).getContext('2d')!;
        context.drawImage(image, 0, 0);
        return context.getImageData(0, 0, image.width, image.height);
      };
      const [a, b] = [await pixelsOf(first), await pixelsOf(second)];
      let [off, drawn] = [0, 0];
      for (let y = 0; y < a.height; y += 1) {
        for (let x = 0; x < a.width; x += 1) {
          const [bx, by] = turned ? [Math.round(2 * turned[0] - x - 1), Math.round(2 * turned[1] - y - 1)] : [x, y];
          if (bx < 0 || by < 0 || bx >= b.width || by >= b.height) continue;
          const [i, j] = [4 * (y * a.width + x), 4 * (by * b.width + bx)];
          // As it looks over a middle grey.
          const seen = (data: Uint8ClampedArray, at: number, k: number): number => 128 + ((data[at + k]! - 128) * data[at + 3]!) / 255;
          if (a.data[i + 3]! > 100 || b.data[j + 3]! > 100) drawn += 1;
          if ([0, 1, 2].some((k) => Math.abs(seen(a.data, i, k) - seen(b.data, j, k)) > 60)) off += 1;
        }
      }
      return { part: off / Math.max(drawn, 1), drawn };
    }, [first, second, turned] as const);
  }

  /** The view glides while the map grows, and is refitted now and then: waits until it has stood
      still for longer than the interval of that. */
  async stillCamera(): Promise<void> {
    let before = '';
    let since = 0;
    await expect.poll(async () => {
      const now = JSON.stringify((await this.state()).camera);
      if (now !== before) since = Date.now();
      before = now;
      return Date.now() - since > STANDS;
    }, { message: 'the view stands still', intervals: [100] }).toBe(true);
  }

  /** Waits until the robot stands: it makes no way in a simulated second, or the run itself stands,
      for example at its goal. */
  async standsStill(): Promise<void> {
    let before = { time: -Infinity, distance: NaN };
    await expect.poll(async () => {
      const { status: s, playing } = await this.state();
      if (!playing) return true;
      if (!s || s.time < before.time + 1) return false;
      const still = s.distance - before.distance < 0.005;
      before = { time: s.time, distance: s.distance };
      return still;
    }, 'the robot stands still').toBe(true);
  }
}

/** Drops files on the page with the events that a browser sends. */
export async function drop(page: Page, name: string, bytes: Uint8Array): Promise<void> {
  const text = Buffer.from(bytes).toString('base64');
  const transfer = await page.evaluateHandle(([name, text]) => {
    const data = new DataTransfer();
    data.items.add(new File([Uint8Array.from(atob(text!), (c) => c.charCodeAt(0))], name!));
    return data;
  }, [name, text]);
  await page.dispatchEvent('body', 'dragenter', { dataTransfer: transfer });
  await expect(page.locator('slam-drop div')).toBeVisible();
  await page.dispatchEvent('body', 'dragover', { dataTransfer: transfer });
  await page.dispatchEvent('body', 'drop', { dataTransfer: transfer });
  await expect(page.locator('slam-drop div')).toBeHidden();
}
