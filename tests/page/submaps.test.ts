// The list of submaps and loaded maps: shown, looked at, saved, removed and put back; and maps that
// can, or cannot, be aligned with the run's own.
import { readFile } from 'node:fs/promises';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

interface Inside {
  submaps: { count: number };
  hiddenSubmaps: readonly number[];
  submap(number: number): [number, number, number];
  loadedMaps: readonly { alignment: { pose: [number, number, number]; by: string } | null; error: string }[];
  camera: { x: number; y: number };
}

const inside = <T>(lab: Lab, read: (inside: Inside) => T): Promise<T> =>
  lab.page.evaluate((read) => (0, eval)(`(${read})`)((window as unknown as { slamlab: Inside }).slamlab) as T, read.toString());

/** A simulation by scan matching that has made some submaps. */
async function mapped(lab: Lab, world: string, least: number): Promise<void> {
  await lab.open();
  await lab.enter(world, '10');
  await lab.showMaps();
  await lab.at('method').selectOption('scan-matching');
  await expect.poll(async () => (await lab.state()).method).toBe('scan-matching');
  await expect.poll(() => inside(lab, ({ submaps }) => submaps.count), { message: 'it makes submaps', timeout: 90_000 }).toBeGreaterThan(least);
  await lab.pause();
  await lab.showMaps();
}

/** The file that a click saves. */
async function saved(lab: Lab, click: () => Promise<unknown>): Promise<{ name: string; bytes: Buffer }> {
  const coming = lab.page.waitForEvent('download');
  await click();
  const download = await coming;
  return { name: download.suggestedFilename(), bytes: await readFile(await download.path()) };
}

async function load(lab: Lab, name: string, bytes: Buffer, id: number): Promise<string> {
  await lab.at('load-map').setInputFiles({ name, mimeType: 'application/octet-stream', buffer: bytes });
  await expect(lab.at(`fit-${id}`)).not.toHaveText('Looking where it lies…', { timeout: 60_000 });
  return (await lab.at(`fit-${id}`).textContent())!;
}

test('submaps are listed, shown, looked at, taken out and put back', { tag: '@phone' }, async ({ lab, page }) => {
  test.setTimeout(180_000);
  await mapped(lab, 'office', 3);
  const count = await inside(lab, ({ submaps }) => submaps.count);
  await expect(lab.at('submaps-summary')).toContainText(`The map is made of ${count} submaps.`);
  await expect(lab.at('submap-0')).toHaveText(/Submap 0\s*[\d.]+ × [\d.]+ m/);
  await expect(lab.at(`submap-${count - 1}`)).toContainText('in the making');

  // One alone is shown, then all but one.
  await lab.at('submap-eye-1').click();
  await expect(lab.at('submap-eye-1')).toHaveAttribute('aria-pressed', 'true');
  await expect(lab.at('submap-eye-0')).toHaveAttribute('aria-pressed', 'false');
  await lab.at('show-submaps').click();
  await expect(lab.at('submap-eye-0')).toHaveAttribute('aria-pressed', 'true');
  await lab.at('submap-eye-0').click();
  expect(await inside(lab, ({ hiddenSubmaps }) => [...hiddenSubmaps])).toEqual([0]);

  // A click goes there, and describes it.
  await lab.at('submap-1').click();
  await expect(lab.at('submap-details')).toContainText(/Keyframes\s*\d+\s*Pieces of wall\s*\d+\s*Joined to submap 0\s*(by scans in both|loosely)/);
  const [x, y] = await inside(lab, ({ submap }) => submap(1));
  await expect.poll(async () => Math.hypot((await lab.state()).camera.x - x, (await lab.state()).camera.y - y), 'the view goes there').toBeLessThan(8);

  // Once removed, what only this submap saw is gone; put back, it is there again.
  const known = (await lab.status()).knownArea;
  await lab.at('remove-submap').click();
  await expect(lab.at('submaps-summary')).toContainText(`The map is made of ${count - 1} submaps.`);
  await lab.watch((s) => s.knownArea, 'less is known').toBeLessThan(known - 0.5);
  expect(await inside(lab, ({ hiddenSubmaps }) => [...hiddenSubmaps]), 'the first stays hidden').toEqual([0]);
  await lab.at('undo-removal').click();
  await expect(lab.at('submaps-summary')).toContainText(`The map is made of ${count} submaps.`);
  await lab.watch((s) => s.knownArea, 'all is known again').toBeGreaterThan(known - 0.2);
  await expect(lab.at('undo-removal')).toBeHidden();
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);

  // It can be put back even after the robot has seen more.
  await lab.at('submap-0').click();
  await lab.at('remove-submap').click();
  await expect(lab.at('submaps-summary')).toContainText(`The map is made of ${count - 1} submaps.`);
  await lab.hidePanels();
  const { scans } = await lab.status();
  await lab.at('step').click();
  await lab.watch((s) => s.scans, 'the robot sees more').toBeGreaterThan(scans);
  await lab.showMaps();
  // It may have begun another one.
  const since = await inside(lab, ({ submaps }) => submaps.count);
  await lab.at('undo-removal').click();
  await expect(lab.at('submaps-summary')).toContainText(`The map is made of ${since + 1} submaps.`);
  await expect(lab.at('undo-removal')).toBeHidden();
});

test('corners of complete submaps are landmarks: drawn, told, and saved with their submap', async ({ lab, page }) => {
  test.setTimeout(180_000);
  await mapped(lab, 'office', 3);
  const landmarks = (): Promise<{ kind: string; x: number; y: number; confidence: number }[]> => page.evaluate(() => (window as unknown as { slamlab: { landmarks: { kind: string; x: number; y: number; confidence: number }[] } }).slamlab.landmarks);
  const found = await landmarks();
  expect(found.length).toBeGreaterThan(4);
  expect(found.every(({ kind, confidence }) => kind !== 'wall' && confidence >= 1)).toBe(true);
  await lab.at('submap-1').click();
  const file = await saved(lab, () => lab.at('save-submap').click());
  const [, count, ...rows] = file.bytes.toString().split('#landmarks')[1]!.split('\n');
  expect(Number(count)).toBe(rows.filter((row) => row !== '').length);
  expect(Number(count)).toBeGreaterThan(0);
  // In the frame of its submap, each lies on a landmark of the map, as far as two submaps agree.
  const [x, y, heading] = await inside(lab, ({ submap }) => submap(1));
  const near = rows.filter((row) => row !== '').filter((row) => {
    // In the file y points to the right.
    const [px, right, confidence, kind] = row.split(',').map(Number) as [number, number, number, number];
    const py = -right;
    expect(confidence).toBeGreaterThanOrEqual(1);
    expect(kind, 'a point').toBe(0);
    const at = [x + (Math.cos(heading) * px - Math.sin(heading) * py) / 1000, y + (Math.sin(heading) * px + Math.cos(heading) * py) / 1000] as const;
    return found.some((landmark) => Math.hypot(landmark.x - at[0], landmark.y - at[1]) < 0.15);
  });
  expect(near.length / Number(count)).toBeGreaterThan(0.9);
});

test('a submap that was saved is found where it lies, and a map of another building nowhere', async ({ lab }) => {
  test.setTimeout(240_000);
  await mapped(lab, 'office', 3);
  await lab.at('submap-1').click();
  const file = await saved(lab, () => lab.at('save-submap').click());
  expect(file.name).toBe('office-submap-1.smap');
  expect(file.bytes.toString()).toMatch(/^#points\n\d+\n/);
  // The file is in the frame of the submap, so it lies where the submap does.
  const truth = await inside(lab, ({ submap }) => submap(1));
  expect(await load(lab, file.name, file.bytes, 1)).toMatch(/^It lies on the map: \d+ % of its walls stand on walls, \d+\scm apart on average; at most \d+ % of the walls of either map stand where the other is free\. (Walls and landmarks told the same place|Walls alone told the place|Walls fit more than one place; landmarks told which)\.( Both maps have \d+ landmarks? in common\.)?$/);
  const [x, y, heading] = await inside(lab, ({ loadedMaps }) => loadedMaps[0]!.alignment!.pose);
  expect(Math.hypot(x - truth[0], y - truth[1])).toBeLessThan(0.05);
  expect(Math.abs(Math.atan2(Math.sin(heading - truth[2]), Math.cos(heading - truth[2])))).toBeLessThan(0.01);
  await lab.at('loaded-eye-1').click();
  await expect(lab.at('loaded-eye-1')).toHaveAttribute('aria-pressed', 'false');

  // In another run it has another place, or none: it is aligned on request.
  const whole = await saved(lab, () => lab.save('slamlab'));
  await mapped(lab, 'arena', 1);
  const words = await load(lab, 'floor.slamlab', whole.bytes, 1);
  expect(words).toMatch(/^Not laid on the map: (no part of the map looks like it|it fits in \d+ places alike)/);
  await expect(lab.at('loaded-eye-1')).toBeDisabled();
  await lab.at('drop-map-1').click();
  await expect(lab.at('loaded-map-1')).toHaveCount(0);
});

test('a saved map lies on another run in the same building, also after that began anew', async ({ lab }) => {
  test.setTimeout(240_000);
  await mapped(lab, 'office', 3);
  const whole = await saved(lab, () => lab.save('slamlab'));
  await lab.at('seed').fill('7');
  await lab.at('seed').press('Enter');
  await expect.poll(async () => (await lab.state()).setup.seed).toBe(7);
  await expect.poll(() => inside(lab, ({ submaps }) => submaps.count), { timeout: 90_000 }).toBeGreaterThan(3);
  await lab.pause();
  await lab.showMaps();
  expect(await load(lab, 'floor.slamlab', whole.bytes, 1)).toContain('It lies on the map');
  // Both runs begin at the start of the world, which is the origin of either map.
  const [x, y, heading] = await inside(lab, ({ loadedMaps }) => loadedMaps[0]!.alignment!.pose);
  expect(Math.hypot(x, y)).toBeLessThan(0.1);
  expect(Math.abs(heading)).toBeLessThan(0.02);
  await lab.at('seed').fill('8');
  await lab.at('seed').press('Enter');
  await expect(lab.at('fit-1')).toHaveText('It is not laid on this run yet.');
  await lab.at('align-map-1').click();
  await expect(lab.at('fit-1')).toHaveText(/Not laid on the map: |It lies on the map/);
});

test('where both maps have landmarks, these tell the place as well as walls do', async ({ lab, page }) => {
  test.setTimeout(180_000);
  await lab.open();
  await lab.enter('office', '10');
  await lab.show('settings');
  await lab.at('settings-search').fill('landmarks are');
  await lab.at('s-ekf.landmarks').selectOption({ label: 'walls, corners and posts' });
  const seenOften = (): Promise<number> => page.evaluate(() => (window as unknown as { slamlab: { landmarks: { kind: string; confidence: number }[] } }).slamlab.landmarks.filter((l) => l.kind !== 'wall' && l.confidence > 4).length);
  await expect.poll(seenOften, { message: 'corners and posts are found again', timeout: 90_000 }).toBeGreaterThan(8);
  await lab.pause();
  await lab.showMaps();
  const file = await saved(lab, () => lab.save('smap'));
  // The run goes on mapping meanwhile: the building and the frame are the same.
  await lab.at('play').click();
  const { time } = await lab.status();
  await lab.watch((s) => s.time, 'it sees more').toBeGreaterThan(time + 10);
  await lab.pause();
  await lab.showMaps();
  expect(await load(lab, file.name, file.bytes, 1)).toMatch(/^It lies on the map: .*Walls and landmarks told the same place\. Both maps have \d+ landmarks in common\.$/);
  const [x, y, heading] = await inside(lab, ({ loadedMaps }) => loadedMaps[0]!.alignment!.pose);
  expect(Math.hypot(x, y)).toBeLessThan(0.05);
  expect(Math.abs(heading)).toBeLessThan(0.01);
});

test('a file that is no map is refused by name and line', async ({ lab }) => {
  await lab.open();
  await lab.showMaps();
  await lab.at('load-map').setInputFiles({ name: 'bad.smap', mimeType: 'text/plain', buffer: Buffer.from('#points\n2\n1, 2\n') });
  await expect(lab.at('toast')).toContainText(/bad\.smap: .*line/);
  await expect(lab.at('loaded-map-1')).toHaveCount(0);
});
