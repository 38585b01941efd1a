// A run is saved as a whole, and a later one goes on in its map; the map is edited.
import { readFile } from 'node:fs/promises';
import { Bridge } from './bridge.ts';
import { expect, test } from './fixture.ts';
import { drop, type Lab } from './lab.ts';
import { record } from './recording.ts';

interface Shown {
  probabilityAt(x: number, y: number): number | null;
  edits: number;
}

/** The probability of an obstacle at a point; null if nothing is known. */
function probabilityAt({ page }: Lab, x: number, y: number): Promise<number | null> {
  return page.evaluate(([x, y]) => (window as unknown as { slamlab: Shown }).slamlab.probabilityAt(x!, y!), [x, y]);
}

/** Saves the map to go on in later. */
async function saveMap(lab: Lab): Promise<Buffer> {
  await lab.showMaps();
  const coming = lab.page.waitForEvent('download');
  await lab.save('slamlab');
  const download = await coming;
  expect(download.suggestedFilename()).toMatch(/\.slamlab$/);
  return readFile(await download.path());
}

/** A simulation by scan matching that has seen some of the world. */
async function explored(lab: Lab, world: string, seconds: number): Promise<void> {
  await lab.open();
  await lab.enter(world, '10');
  await lab.showMaps();
  await lab.at('method').selectOption('scan-matching');
  await expect.poll(async () => (await lab.state()).method).toBe('scan-matching');
  await lab.watch((s) => s.time, 'it drives', 60_000).toBeGreaterThan(seconds);
  await lab.pause();
}

/** Drags on the map from one place to another, map frame, m. */
async function dragOn(lab: Lab, ...[x0, y0, x1, y1]: [number, number, number, number]): Promise<void> {
  await lab.stillCamera();
  const box = (await lab.at('map').boundingBox())!;
  const [from, to] = await lab.page.evaluate(([x0, y0, x1, y1]) => {
    const { toScreen } = (window as unknown as { slamlab: { toScreen(x: number, y: number): [number, number] } }).slamlab;
    return [toScreen(x0!, y0!), toScreen(x1!, y1!)] as const;
  }, [x0, y0, x1, y1]);
  await lab.page.mouse.move(box.x + from[0], box.y + from[1]);
  await lab.page.mouse.down();
  await lab.page.mouse.move(box.x + (from[0] + to[0]) / 2, box.y + (from[1] + to[1]) / 2);
  await lab.page.mouse.move(box.x + to[0], box.y + to[1]);
  await lab.page.mouse.up();
}

test('a simulation goes on in the map that was saved of it', async ({ lab, page }) => {
  test.setTimeout(150_000);
  await explored(lab, 'office', 40);
  const before = await lab.status();
  const known = before.knownArea;
  const saved = await saveMap(lab);
  await drop(page, 'floor.slamlab', saved);
  await expect(lab.at('going-on')).toContainText('floor.slamlab');
  // A simulation begins at the start of its world, where the first run also began, not where that
  // run left its robot.
  await lab.at('begin-at').selectOption('at');
  for (const i of [0, 1, 2]) {
    await lab.at(`begin-at-${i}`).fill('0');
    await lab.at(`begin-at-${i}`).press('Enter');
  }
  await expect.poll(async () => (await lab.status()).time, 'a new run').toBeLessThan(before.time);
  await expect(lab.at('placed')).toHaveText('The robot was told where it is in it.');
  await lab.watch((s) => s.knownArea, 'all that was known is there').toBeGreaterThan(0.9 * known);
  await lab.watch((s) => Math.hypot(s.x - s.truthX, s.y - s.truthY), 'it is where it begins').toBeLessThan(0.3);
  await lab.watch((s) => s.knownArea, 'and the map grows', 90_000).toBeGreaterThan(1.1 * known);
  await lab.watch((s) => Math.hypot(s.x - s.truthX, s.y - s.truthY), 'where it belongs').toBeLessThan(0.3);
  await lab.at('empty-map').click();
  await expect(lab.at('going-on')).toBeHidden();
  await lab.watch((s) => s.knownArea, 'it begins anew').toBeLessThan(0.9 * known);
});

test('a press on the picture of a saved map says where the robot begins', { tag: '@phone' }, async ({ lab, page }) => {
  test.setTimeout(120_000);
  await explored(lab, 'arena', 15);
  await drop(page, 'arena.slamlab', await saveMap(lab));
  await lab.showMaps();
  await expect(lab.at('begin-at')).toHaveValue('left');
  await lab.at('saved-map').scrollIntoViewIfNeeded();
  const box = (await lab.at('saved-map').boundingBox())!;
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x, y - 40);
  await page.mouse.up();
  await expect(lab.at('begin-at')).toHaveValue('at');
  await expect(lab.at('begin-at-2'), 'it looks up').toHaveValue('90');
  await lab.at('begin-at').selectOption('anywhere');
  await expect(lab.at('placed')).toContainText('not proved yet');
  await expect(lab.at('caption')).toContainText('a piece of its own');
});

test('two maps of one building become one, and other buildings are refused', async ({ lab, page }) => {
  test.setTimeout(240_000);
  await explored(lab, 'arena', 15);
  const arena = await saveMap(lab);
  await explored(lab, 'office', 60);
  const first = await saveMap(lab);
  await lab.at('seed').fill('11');
  await lab.at('seed').press('Enter');
  await lab.watch((s) => s.time, 'another run').toBeLessThan(30);
  await lab.watch((s) => s.time, 'it drives', 60_000).toBeGreaterThan(60);
  await lab.pause();
  const { hash } = await lab.state();
  const second = await saveMap(lab);

  await lab.at('merge-map').setInputFiles({ name: 'arena.slamlab', mimeType: '', buffer: arena });
  await expect(lab.at('toast')).toContainText('arena.slamlab: it is not proved where the maps overlap');
  await expect(lab.at('going-on')).toBeHidden();
  await expect(lab.at('caption')).not.toContainText('Loading');

  await lab.at('merge-map').setInputFiles({ name: 'floor.slamlab', mimeType: '', buffer: first });
  await expect(lab.at('going-on'), 'it waits for the next run').toContainText('office and floor from the next one on', { timeout: 60_000 });
  expect((await lab.state()).hash, 'the run itself stays as it was').toBe(hash);
  const coming = page.waitForEvent('download');
  await lab.at('save-saved-map').click();
  const download = await coming;
  expect(download.suggestedFilename()).toBe('office-and-floor.slamlab');
  const merged = await readFile(await download.path());
  expect(merged.length, 'both are in it').toBeGreaterThan(1.2 * Math.max(first.length, second.length));

  await lab.at('begin-in-it').click();
  await lab.watch((s) => s.time, 'a new run').toBeLessThan(30);
  await expect(lab.at('begin-in-it')).toBeHidden();
  await expect(lab.at('going-on')).toHaveText('Runs by scan matching go on in office and floor.');
  await lab.at('empty-map').click();
  await expect(lab.at('going-on')).toBeHidden();
});

test('what newer parts of a map cover is taken out', { tag: '@phone' }, async ({ lab, page }) => {
  test.setTimeout(120_000);
  await lab.open();
  await drop(page, 'laps.log', Buffer.from(record(600).text));
  await lab.watch((s) => s.source === 'replay' && s.finished, 'the recording ends', 60_000).toBe(true);
  const whole = await saveMap(lab);
  await lab.at('prune-map').click();
  await expect(lab.at('going-on')).toContainText('laps from the next one on');
  await lab.show('log');
  await expect(lab.at('log')).toContainText(/Taken out of laps\.log: [1-9]\d* submaps with [1-9]\d* keyframes/);
  await lab.showMaps();
  const coming = page.waitForEvent('download');
  await lab.at('save-saved-map').click();
  const pruned = await readFile(await (await coming).path());
  expect(pruned.length).toBeLessThan(0.8 * whole.length);
  await drop(page, 'pruned.slamlab', pruned);
  await expect(lab.at('going-on'), 'it can be gone on in').toContainText('pruned.slamlab');
});

test('a damaged saved map is refused in words, and nothing is lost', async ({ lab, page }) => {
  test.setTimeout(120_000);
  await explored(lab, 'arena', 10);
  const saved = await saveMap(lab);
  const { hash, title } = await lab.state();
  const flipped = Buffer.from(saved);
  const middle = flipped.length >> 1;
  flipped.writeUInt8(flipped.readUInt8(middle) ^ 0x10, middle);
  const damaged: [string, Buffer, RegExp | string][] = [
    ['cut.slamlab', saved.subarray(0, saved.length - 100), `cut.slamlab: the .slamlab file is cut off: it ends at byte ${saved.length - 100}, with `],
    ['flipped.slamlab', flipped, /flipped\.slamlab: .*(damaged: what stands before byte|cut off: it ends at byte) \d+/],
    ['other.slamlab', Buffer.from('a letter'), 'other.slamlab: this is no .slamlab file'],
    ['empty.slamlab', Buffer.alloc(0), 'empty.slamlab: this is no .slamlab file'],
  ];
  for (const [name, bytes, words] of damaged) {
    await drop(page, name, bytes);
    await expect(lab.at('toast'), name).toContainText(words);
    await expect(lab.at('going-on'), name).toBeHidden();
    expect((await lab.state()).title, 'the run is still there').toBe(title);
  }
  expect((await lab.state()).hash, 'to the bit').toBe(hash);
  // A saved map that the run goes on in stays too.
  await drop(page, 'whole.slamlab', saved);
  await expect(lab.at('going-on')).toContainText('whole.slamlab');
  await drop(page, 'cut.slamlab', saved.subarray(0, saved.length - 100));
  await expect(lab.at('toast')).toContainText('cut.slamlab');
  await expect(lab.at('going-on')).toContainText('whole.slamlab');
});

test('the map is changed by hand, and the changes are saved with it', async ({ lab, page }) => {
  test.setTimeout(120_000);
  await explored(lab, 'arena', 10);
  const { x, y, hash } = { ...(await lab.status()), hash: (await lab.state()).hash };
  expect(await probabilityAt(lab, x, y), 'the robot stands where it is free').toBeLessThan(0.5);
  const edits = () => page.evaluate(() => (window as unknown as { slamlab: Shown }).slamlab.edits);
  await page.keyboard.press('e');
  await expect(lab.at('edit')).toBeVisible();
  await expect(lab.at('edit-undo')).toBeDisabled();

  await lab.at('edit-wall').click();
  await dragOn(lab, x - 0.5, y + 0.4, x + 0.5, y + 0.4);
  await expect.poll(() => probabilityAt(lab, x, y + 0.4), 'a wall stands there').toBeGreaterThan(0.9);
  expect(await edits()).toBe(1);
  expect((await lab.status()).mode, 'nobody was sent there').toBe('explore');

  await lab.at('edit-erase').click();
  await dragOn(lab, x - 0.3, y - 0.3, x + 0.3, y + 0.2);
  await expect.poll(() => probabilityAt(lab, x, y), 'nothing is known there').toBeNull();
  expect(await probabilityAt(lab, x, y + 0.4), 'the wall stays').toBeGreaterThan(0.9);

  await lab.at('edit-undo').click();
  await expect.poll(() => probabilityAt(lab, x, y), 'it is free again').toBeLessThan(0.5);
  await lab.at('edit-undo').click();
  await expect.poll(() => probabilityAt(lab, x, y + 0.4), 'the wall is gone').toBeLessThan(0.5);
  await expect(lab.at('edit-undo')).toBeDisabled();

  // Two clicks draw as well.
  await lab.at('edit-glass').click();
  await lab.pointAt(x - 0.5, y + 0.4, false);
  await lab.pointAt(x + 0.5, y + 0.4, false);
  await expect.poll(() => probabilityAt(lab, x, y + 0.4), 'glass stands there').toBeGreaterThan(0.9);
  await lab.at('edit-done').click();
  await expect(lab.at('edit')).toBeHidden();
  await lab.at('play').click();
  const { time } = await lab.status();
  await lab.watch((s) => s.time, 'it goes on').toBeGreaterThan(time + 10);
  expect(await probabilityAt(lab, x, y + 0.4), 'and beams do not take the glass away').toBeGreaterThan(0.9);
  expect((await lab.state()).hash).not.toBe(hash);
  await lab.pause();
  await drop(page, 'edited.slamlab', await saveMap(lab));
  await expect(lab.at('going-on')).toContainText('edited.slamlab');
  await expect.poll(() => probabilityAt(lab, x, y + 0.4), 'the next run has it').toBeGreaterThan(0.9);
  await lab.at('method').selectOption('line-ekf');
  await expect.poll(async () => (await lab.state()).method).toBe('line-ekf');
  await expect(lab.at('edit-map'), 'other maps are not changed by hand').toBeHidden();
});

test('a recorded map is changed by hand too', async ({ lab, page }) => {
  await lab.open();
  await drop(page, 'short.log', Buffer.from(record(60).text));
  await lab.watch((s) => s.source === 'replay' && s.finished, 'the recording ends').toBe(true);
  const { x, y } = await lab.status();
  await lab.at('edit-map').click();
  await lab.at('edit-wall').click();
  await dragOn(lab, x - 0.3, y + 0.3, x + 0.3, y + 0.3);
  await expect.poll(() => probabilityAt(lab, x, y + 0.3)).toBeGreaterThan(0.9);
});

test('the map of a robot at a bridge is changed by hand, saved, and gone on in', async ({ lab, page }) => {
  test.setTimeout(120_000);
  const bridge = await Bridge.start(['--source', 'sim:arena,lidar']);
  await lab.open(bridge.url);
  await lab.showMaps();
  await lab.at('method').selectOption('scan-matching');
  await expect.poll(async () => (await lab.state()).method).toBe('scan-matching');
  await lab.watch((s) => s.scans, 'it scans').toBeGreaterThan(15);
  const { x, y } = await lab.status();
  await lab.at('edit-map').click();
  await lab.at('edit-wall').click();
  await dragOn(lab, x - 0.3, y + 0.4, x + 0.3, y + 0.4);
  await expect.poll(() => probabilityAt(lab, x, y + 0.4), 'a wall stands there').toBeGreaterThan(0.9);
  await drop(page, 'arena.slamlab', await saveMap(lab));
  await expect(lab.at('going-on')).toContainText('arena.slamlab');
  await lab.watch((s) => s.scans, 'the robot is asked again').toBeLessThan(10);
  await lab.watch((s) => s.scans, 'and scans').toBeGreaterThan(10);
  await lab.showMaps();
  await expect(lab.at('placed'), 'it stands where it was left').toHaveText('It is known where the robot is in it.');
  await expect.poll(() => probabilityAt(lab, x, y + 0.4), 'with the wall').toBeGreaterThan(0.9);
  await bridge.stop();
});
