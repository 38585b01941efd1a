// Submaps, pose graph and loop closures: layers, a map that is straightened, a click that explains;
// and two methods on one log.
import { apart } from '../../www/src/compared.ts';
import { type Figures, WHY } from '../../www/src/ui/closure_words.ts';
import type { SubmapsChange } from '../../www/src/protocol/frame.ts';
import { CLOSURE, CLOSURE_STRIDE, type ClosureOutcome, SUBMAP, SUBMAP_STRIDE } from '../../www/src/protocol/module.ts';
import { Submaps } from '../../www/src/view/submaps.ts';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';
import { record, RING } from './recording.ts';

/** A lap of a long ring, and the beginning of a second one. */
const LAPS = { name: 'laps.clf', mimeType: 'text/plain', buffer: Buffer.from(record(1150, RING).text) };

interface Inside {
  submaps: { count: number; outcomes: string[]; glides: boolean };
  submap(number: number): [number, number, number];
  closureOf(row: number): [number, number];
  moved: number;
}

const inside = <T>(lab: Lab, read: (inside: Inside) => T): Promise<T> =>
  lab.page.evaluate((read) => (0, eval)(`(${read})`)((window as unknown as { slamlab: Inside }).slamlab) as T, read.toString());

async function map(lab: Lab): Promise<void> {
  await lab.open();
  await lab.show('run');
  await lab.at('file').setInputFiles(LAPS);
  await expect.poll(async () => (await lab.state()).source, 'the recording is shown').toBe('replay');
}

async function mapped(lab: Lab, timeout = 60_000): Promise<void> {
  await lab.watch((s) => s.finished, 'the recording ends', timeout).toBe(true);
}

test('a loop closes before the eyes, and a click on it says its residual and why', { tag: '@phone' }, async ({ lab, page, isMobile }) => {
  test.setTimeout(120_000);
  await map(lab);
  await expect(lab.at('moved'), 'by how much the map moved').toContainText(/Loop closed: the map moved by up to [\d.]+ m/, { timeout: 60_000 });
  await mapped(lab);
  const accepted = await inside(lab, ({ submaps }) => submaps.outcomes.filter((o) => o === 'proved' || o === 'known-before').length);
  expect(accepted, 'each loop that was closed is shown').toBe((await lab.status()).loopClosures);
  expect(accepted).toBeGreaterThan(0);
  // The closure whose ends lie farthest apart: no other is at its middle.
  const middle = await inside(lab, ({ submaps, submap, closureOf }) => {
    const ends = submaps.outcomes.map((_, row) => closureOf(row).map((number) => submap(number)) as [number, number, number][]);
    const length = ([a, b]: [number, number, number][]) => Math.hypot(a![0] - b![0], a![1] - b![1]);
    const [a, b] = ends.sort((one, other) => length(other) - length(one))[0]!;
    return [(a![0] + b![0]) / 2, (a![1] + b![1]) / 2] as [number, number];
  });
  await lab.hidePanels();
  await lab.pointAt(...middle, !!isMobile);
  await expect(lab.at('closure')).toContainText(/Submap \d+ in submap \d+/);
  await expect(lab.at('closure-fate')).toHaveText('Accepted');
  await expect(lab.at('closure-why')).toContainText(/No search was needed|proved: this place and those that agree with it are worth [\d.]+ submaps?, where [\d.]+ were asked for/);
  await expect(lab.at('closure-off')).toContainText(/^[\d.]+ c?m, [\d.]+°$/);
  await expect(lab.at('closure-chi2')).toContainText(/^[\d.]+/);
  await expect(lab.at('closure-overlap')).toContainText('%');
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  await lab.at('closure').getByRole('button', { name: 'Close' }).click();
  await expect(lab.at('closure')).toHaveCount(0);
});

test('submaps and the pose graph are layers, and only methods with submaps have them', async ({ lab }) => {
  await lab.open();
  await expect(lab.at('layer-closures'), 'the line filter has none').toHaveCount(0);
  await map(lab);
  await mapped(lab);
  expect(await inside(lab, ({ submaps }) => submaps.count)).toBeGreaterThan(2);
  await lab.show('layers');
  await expect(lab.at('layer-closures')).toBeChecked();
  const record = (): Promise<string> => lab.page.evaluate(() => document.querySelector('slam-map')!.shadowRoot!.querySelector<HTMLCanvasElement>('#record')!.toDataURL());
  await lab.stillCamera();
  let before = await record();
  for (const name of ['submaps', 'graph']) {
    await expect(lab.at(`layer-${name}`)).not.toBeChecked();
    await lab.at(`layer-${name}`).check();
    await expect.poll(record, `${name} are drawn`).not.toBe(before);
    before = await record();
  }
});

test('a click on a join of the pose graph says its residual, and whether it was matched', { tag: '@phone' }, async ({ lab, page, isMobile }) => {
  test.setTimeout(120_000);
  await map(lab);
  await mapped(lab);
  await lab.show('layers');
  await lab.at('layer-graph').check();
  // Loop closures lie over it.
  await lab.at('layer-closures').uncheck();
  const count = await inside(lab, ({ submaps }) => submaps.count);
  const ends = await Promise.all([1, 2].map((number) => lab.page.evaluate((n) => (window as unknown as { slamlab: Inside }).slamlab.submap(n), number)));
  expect(count).toBeGreaterThan(3);
  await lab.hidePanels();
  await lab.stillCamera();
  const middle = [0, 1].map((axis) => (ends[0]![axis]! + ends[1]![axis]!) / 2) as [number, number];
  await lab.pointAt(...middle, !!isMobile);
  await expect(lab.at('join')).toContainText('Submap 1 to submap 2');
  await expect(lab.at('join-kind')).toHaveText('Matched');
  await expect(lab.at('join-off')).toContainText(/^[\d.]+ (c|m)?m, [\d.]+°$/);
  await expect(lab.at('join-chi2')).toContainText(/^[\d.]+/);
  await expect(lab.at('join-known')).toContainText(/^±[\d.]+ c?m, [\d.]+°$/);
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  await lab.at('join').getByRole('button', { name: 'Close' }).click();
  await expect(lab.at('join')).toHaveCount(0);
});

test('where a click drives, it is meant for a line only where that is really hit', async ({ lab, page }) => {
  test.setTimeout(120_000);
  await lab.open();
  await lab.show('run');
  await lab.at('method').selectOption('scan-matching');
  await expect.poll(async () => (await lab.state()).method).toBe('scan-matching');
  await lab.speed('20');
  await expect.poll(() => inside(lab, ({ submaps }) => submaps.count), { message: 'there are submaps', timeout: 60_000 }).toBeGreaterThan(3);
  await lab.show('layers');
  await lab.at('layer-graph').check();
  await lab.at('layer-closures').uncheck();
  await lab.at('stop').click();
  await expect(lab.at('caption')).toContainText('click the map');
  const ends = await Promise.all([1, 2].map((number) => page.evaluate((n) => (window as unknown as { slamlab: Inside }).slamlab.submap(n), number)));
  const [a, b] = ends as [[number, number, number], [number, number, number]];
  const middle = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2] as const;
  await lab.stillCamera();
  // A place beside the join, where it used to catch the click.
  const [length, away] = [Math.hypot(b[0] - a[0], b[1] - a[1]), 6 / (await lab.state()).camera.scale];
  await lab.pointAt(middle[0] - away * (b[1] - a[1]) / length, middle[1] + away * (b[0] - a[0]) / length, false);
  await lab.watch((s) => s.mode, 'the robot drives there').toBe('goto');
  await expect(lab.at('join')).toHaveCount(0);
  await lab.at('stop').click();
  await lab.watch((s) => s.mode, 'it is stopped').toBe('manual');
  await lab.pointAt(...middle, false);
  await expect(lab.at('join')).toContainText('Submap 1 to submap 2');
  expect((await lab.status()).mode, 'and goes nowhere').toBe('manual');
});

test('where motion is to be reduced, the map does not glide', async ({ lab, page }) => {
  await page.emulateMedia({ reducedMotion: 'reduce' });
  await map(lab);
  await page.evaluate(() => {
    const seen = { glides: false };
    Object.assign(window, { seen });
    const look = (): void => {
      seen.glides ||= (window as unknown as { slamlab: Inside }).slamlab.submaps.glides;
      requestAnimationFrame(look);
    };
    // After the frames of the page itself.
    requestAnimationFrame(look);
  });
  await mapped(lab);
  expect(await inside(lab, ({ moved }) => moved), 'a loop was closed').toBeGreaterThan(0);
  expect(await page.evaluate(() => (window as unknown as { seen: { glides: boolean } }).seen.glides)).toBe(false);
});

test('two methods map one log, and their ways are laid over one another', { tag: '@phone' }, async ({ lab }) => {
  test.setTimeout(120_000);
  await map(lab);
  await mapped(lab);
  await lab.show('status');
  await expect(lab.at('method-scan-matching')).toContainText('shown');
  await expect(lab.at('method-odometry')).toContainText('Run');
  await lab.at('run-odometry').click();
  await expect.poll(async () => (await lab.state()).method).toBe('odometry');
  await mapped(lab);
  await expect(lab.at('method-odometry')).toContainText('shown');
  // Odometry drifts by metres in a lap, see `record`.
  const metres = async (): Promise<number> => parseFloat(await lab.at('apart-scan-matching').innerText());
  expect(await metres()).toBeGreaterThan(0.2);
  await lab.show('layers');
  await expect(lab.at('layer-compared')).toBeChecked();
  await lab.show('status');
  // Another log has nothing to be compared with.
  await lab.show('run');
  await lab.at('file').setInputFiles({ ...LAPS, name: 'other.clf' });
  await expect.poll(async () => (await lab.state()).title).toBe('other.clf');
  await expect(lab.at('layer-compared')).toHaveCount(0);
});

test('a placement that others overruled was so when it was judged, and may agree now', () => {
  const said = (chi2: number): string => WHY['placed-elsewhere']({ chi2 } as Figures);
  expect(said(1e4)).toMatch(/^When it was judged, .* did not go with theirs\.$/);
  expect(said(1.4)).toContain('as it lies now, they do not differ');
});

/** A trail along the x axis at 1 m/s, y to the side, with a point at each of these times. */
function trail(y: number, ...times: number[]): Float32Array {
  return Float32Array.from(times.flatMap((time) => [NaN, NaN, 0, 0, time, y, 0, time]));
}

test('ways are compared at the same times, as long as both go', () => {
  const { rms, most } = apart(trail(0, 0, 1, 4, 10), trail(0.5, 0, 2, 3, 9, 30));
  expect(rms).toBeCloseTo(0.5, 6);
  expect(most).toBeCloseTo(0.5, 6);
  expect(apart(trail(0, 0, 1), new Float32Array(0)).rms).toBeNaN();
});

/** Submaps at these places, x y heading. */
function placed(...poses: [number, number, number][]): SubmapsChange {
  const none = new Float32Array(0);
  return { version: 0, poses: Float32Array.from(poses.flatMap(([x, y, heading]) => {
    const row = new Array<number>(SUBMAP_STRIDE).fill(NaN);
    [row[SUBMAP.x], row[SUBMAP.y], row[SUBMAP.heading], row[SUBMAP.loose], row[SUBMAP.keyframes]] = [x, y, heading, 0, 1];
    return row;
  })), lengths: new Uint32Array(0), surfaces: none, extents: none, removable: 0, undoable: undefined, closures: none, outcomes: [], renumbered: [] };
}

test('submaps glide from where they were drawn, and a new one comes along', () => {
  const submaps = new Submaps();
  expect(submaps.take(placed([0, 0, 0], [2, 0, 0]), 0)).toBe(0);
  // The second turns to the left about the first; a third was begun a metre ahead of it.
  expect(submaps.take(placed([0, 0, 0], [0, 2, Math.PI / 2], [0, 3, Math.PI / 2]), 1000)).toBeCloseTo(Math.sqrt(8), 5);
  const at = (wall: number, submap: number): number[] => {
    submaps.animate(wall, false);
    return submaps.shown(submap).map((number) => Math.round(number * 1000) / 1000 + 0);
  };
  expect(at(1000, 1)).toEqual([2, 0, 0]);
  expect(at(1000, 2)).toEqual([3, 0, 0]);
  expect(at(1300, 1)).toEqual([1, 1, Math.round(Math.PI * 250) / 1000]);
  expect(submaps.ahead, 'the grid still shows the old place').toBe(true);
  // A motion too small to be reported, during a glide: the glide continues from there.
  submaps.take(placed([0, 0, 0], [0, 2.01, Math.PI / 2], [0, 3, Math.PI / 2]), 1300);
  expect(at(1300, 1)[0]).toBe(1);
  expect(at(1900, 1).slice(0, 2)).toEqual([0, 2.01]);
  submaps.redrawn();
  expect(submaps.ahead).toBe(false);
  // With `still`, it is there at once.
  submaps.take(placed([0, 0, 0], [5, 5, 0], [0, 3, 0]), 5000);
  submaps.animate(5000, true);
  expect([submaps.glides, ...submaps.shown(1)]).toEqual([false, 5, 5, 0]);
});

/** A placement for each pair of submaps. */
function compared(placed: SubmapsChange, ...pairs: [old: number, next: number, outcome: ClosureOutcome, isLoop: boolean][]): SubmapsChange {
  const closures = new Float32Array(pairs.length * CLOSURE_STRIDE).fill(NaN);
  pairs.forEach(([old, next,, isLoop], row) => {
    closures[row * CLOSURE_STRIDE + CLOSURE.loopClosed] = Number(isLoop);
    closures[row * CLOSURE_STRIDE + CLOSURE.old] = old;
    closures[row * CLOSURE_STRIDE + CLOSURE.new] = next;
  });
  return { ...placed, closures, outcomes: pairs.map(([,, outcome]) => outcome) };
}

test('of what is accepted, only what closes a loop stands out', () => {
  const submaps = new Submaps();
  const way = placed([0, 0, 0], [4, 0, 0], [8, 0, 0], [4, 0, 0], [0, 0, 0]);
  submaps.take(compared(way, [0, 2, 'known-before', false], [1, 3, 'known-before', true], [0, 4, 'proved', true], [0, 1, 'proved', false], [0, 3, 'rivals', false], [0, 4, 'revoked', false]), 0);
  expect(submaps.fates).toEqual(['neighbour', 'accepted', 'accepted', 'neighbour', 'waiting', 'revoked']);
  submaps.animate(0, false);
  expect(submaps.fresh.rows).toEqual([1, 2]);
});
