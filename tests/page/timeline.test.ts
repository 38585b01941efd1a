// Time: back along the line of a run, the same way again, and another way from there; by mouse, by
// key and from the log; in a simulation and in a recording.
import type { Page } from '@playwright/test';
import { expect, test } from './fixture.ts';
import { focused } from './hands.ts';
import { drop, type Lab } from './lab.ts';
import { record } from './recording.ts';

/** Half the width of the line's handle, px. */
const HALF_HANDLE = 8;

interface Moment { time: number; scans: number; hash: string }

/** The moment of a paused run, once its hash has arrived. */
async function moment(lab: Lab): Promise<Moment> {
  await expect.poll(async () => (await lab.state()).playing, 'it waits').toBe(false);
  await expect.poll(async () => (await lab.state()).hash, 'the hash has come').not.toBe('');
  let before = '';
  // The last frame and its hash are sent one after the other.
  await expect.poll(async () => {
    const { seq, hash } = await lab.state();
    const now = `${seq} ${hash}`;
    const isSame = now === before;
    before = now;
    return isSame;
  }, { message: 'all has come', intervals: [150] }).toBe(true);
  const { status, hash } = await lab.state();
  return { time: status!.time, scans: status!.scans, hash };
}

/** Drags the handle from where it is to a share of the line. */
async function drag(lab: Lab, to: number): Promise<void> {
  const line = lab.at('timeline');
  const box = (await line.boundingBox())!;
  const at = await line.evaluate((input: HTMLInputElement) => Number(input.value) / Number(input.max));
  const x = (share: number): number => box.x + HALF_HANDLE + share * (box.width - 2 * HALF_HANDLE);
  const y = box.y + box.height / 2;
  await lab.page.mouse.move(x(at), y);
  await lab.page.mouse.down();
  await lab.page.mouse.move(x((at + to) / 2), y, { steps: 4 });
  await lab.page.mouse.move(x(to), y, { steps: 4 });
  await lab.page.mouse.up();
  await arrives(lab);
}

/** Goes to exactly this moment, s. */
async function goTo(lab: Lab, time: number): Promise<void> {
  await lab.at('timeline').fill(String(time));
  await arrives(lab);
}

async function arrives(lab: Lab): Promise<void> {
  await expect.poll(async () => (await lab.state()).seeking, { message: 'it arrives', timeout: 60_000, intervals: [30, 60, 100] }).toBeNull();
  await expect.poll(async () => (await lab.state()).playing, 'and waits').toBe(false);
}

/** A run in the arena that has gone on for a while, and is paused; its last moment. */
async function driven(lab: Lab): Promise<Moment> {
  await lab.open();
  await lab.enter('arena', '4');
  await lab.watch((s) => s.time, 'it drives for a while').toBeGreaterThan(14);
  await lab.pause();
  return moment(lab);
}

const length = (lab: Lab): Promise<number> => lab.at('timeline').evaluate((input: HTMLInputElement) => Number(input.max));

const onMap = (page: Page): Promise<void> => page.evaluate(() => void dispatchEvent(new Event('focus-map')));

test('a simulated run goes back, the same way again, and another way with another setting', async ({ lab }) => {
  test.setTimeout(120_000);
  const end = await driven(lab);
  expect(await length(lab), 'the line is as long as the run').toBeCloseTo(end.time, 6);

  await drag(lab, 0.5);
  const half = await moment(lab);
  expect(half.time / end.time).toBeCloseTo(0.5, 1);
  expect(half.scans).toBeLessThan(end.scans);
  expect(half.hash).not.toBe(end.hash);
  expect(await length(lab), 'what came after stays on the line').toBeCloseTo(end.time, 6);
  await expect(lab.at('timeline')).toHaveAttribute('aria-valuetext', /^0:0\d of 0:1\d$/);

  await drag(lab, 1);
  expect(await moment(lab), 'the same way to the same end, to the bit').toEqual(end);
  await drag(lab, 0);
  expect((await moment(lab)).time, 'back to the beginning').toBeLessThan(0.1);
  await goTo(lab, half.time);
  expect(await moment(lab), 'every way to a moment leads to the same state').toEqual(half);

  // Playing on, at its own speed, is the same way too.
  await lab.at('play').click();
  await lab.watch((s) => s.time, 'it goes on').toBeGreaterThan(end.time);
  await lab.pause();
  await goTo(lab, end.time);
  expect(await moment(lab)).toEqual(end);

  await goTo(lab, half.time);
  await lab.show('settings');
  await lab.at('settings-search').fill('shortest line');
  await lab.at('s-lines.min_length').fill('5');
  await lab.at('s-lines.min_length').blur();
  await expect.poll(() => length(lab), 'from here on it is another run').toBeCloseTo(half.time, 6);
  await lab.at('play').click();
  await lab.watch((s) => s.time, 'it goes its own way').toBeGreaterThan(end.time + 1);
  await lab.pause();
  await goTo(lab, end.time);
  const other = await moment(lab);
  expect(other.time).toBe(end.time);
  expect(other.hash, 'with another setting, another map').not.toBe(end.hash);

  // The fields show the values at the moment that is shown.
  const field = lab.at('s-lines.min_length');
  await expect(field).toHaveValue('5');
  await goTo(lab, half.time / 2);
  await expect(field, 'before it was chosen').toHaveValue('0.5');
  await goTo(lab, end.time);
  await expect(field, 'and after').toHaveValue('5');
  expect(await moment(lab)).toEqual(other);

  // A choice now applies in addition to those, not in their place.
  await lab.at('settings-search').fill('gate of a match');
  await lab.at('s-ekf.gate').fill('12');
  await lab.at('s-ekf.gate').blur();
  await expect.poll(async () => (await lab.state()).setup.settings).toEqual({ 'lines.min_length': 5, 'ekf.gate': 12 });
});

test('B goes back scan by scan, N goes on, and the log leads to its moments', async ({ lab, page }) => {
  test.setTimeout(120_000);
  await lab.open();
  await lab.enter('arena');
  await lab.watch((s) => s.finished, 'it explores to the end', 90_000).toBe(true);
  const end = await moment(lab);
  await expect(page.locator('slam-timeline rect'), 'its end is marked').not.toHaveCount(0);
  const marks = await page.locator('slam-timeline rect').count();

  await onMap(page);
  const passed = [end];
  for (let i = 1; i <= 3; i += 1) {
    await page.keyboard.press('b');
    await lab.watch((s) => s.scans, 'one scan back').toBe(end.scans - i);
    await arrives(lab);
    passed.push(await moment(lab));
  }
  await page.keyboard.press('n');
  await lab.watch((s) => s.scans, 'one scan on').toBe(end.scans - 2);
  expect((await moment(lab)).hash).toBe(passed[2]!.hash);
  await expect(page.locator('slam-timeline rect'), 'what is told once more is marked once').toHaveCount(marks);

  await lab.show('log');
  const first = lab.at('log').getByRole('button').last();
  await expect(first).toHaveAttribute('title', 'Go to this moment');
  await first.click();
  await arrives(lab);
  expect((await lab.status()).time, 'the log begins where the run does').toBeLessThan(0.1);
  expect(await length(lab)).toBeCloseTo(end.time, 6);
  await lab.hidePanels();
  await drag(lab, 1);
  expect((await moment(lab)).hash).toBe(end.hash);
  await lab.watch((s) => s.finished, 'it is over again').toBe(true);

  // What a person does there begins another way.
  await goTo(lab, end.time / 2);
  await lab.at('mode-manual').click();
  await expect.poll(() => length(lab)).toBeLessThan(0.6 * end.time);
  await expect(lab.at('speed'), 'nobody steers faster than time goes').toHaveValue('1');

  // The earlier way is not lost.
  await lab.at('toast-way').click();
  await lab.watch((s) => s.time, 'it is done again').toBeGreaterThan(0.99 * end.time);
  await lab.watch((s) => s.finished, 'to its end').toBe(true);
  expect((await moment(lab)).hash).toBe(end.hash);
});

test('what cannot be done again is said, and the run stays where it is', async ({ lab, page }) => {
  await lab.open();
  await lab.enter('arena', '4');
  await lab.show('run');
  await lab.at('method').selectOption('scan-matching');
  await expect.poll(async () => (await lab.state()).method).toBe('scan-matching');
  await lab.hidePanels();
  await lab.watch((s) => s.time, 'it drives').toBeGreaterThan(4);
  await lab.pause();
  await onMap(page);
  await page.keyboard.press('e');
  const { hash: unchanged } = await moment(lab);
  await lab.at('edit-wall').click();
  const box = (await lab.at('map').boundingBox())!;
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 60, y, { steps: 3 });
  await page.mouse.up();
  await page.keyboard.press('Escape');
  await expect(lab.at('edit-wall'), 'Esc is enough').toBeHidden();
  await expect.poll(async () => (await moment(lab)).hash, 'the wall is in the map').not.toBe(unchanged);
  const before = await moment(lab);
  await lab.at('back').click();
  await expect(page.locator('slam-toast')).toContainText('cannot be done again');
  expect(await moment(lab)).toEqual(before);
});

test('a recording goes back and the same way again, and with another setting another way', async ({ lab, page }) => {
  test.setTimeout(120_000);
  await lab.open();
  await drop(page, 'laps.log', Buffer.from(record(420).text));
  await expect.poll(async () => (await lab.state()).source, 'the recording is shown').toBe('replay');
  await lab.watch((s) => s.finished, 'the recording ends', 60_000).toBe(true);
  const end = await moment(lab);

  await drag(lab, 0.5);
  const half = await moment(lab);
  expect(half.time / end.time).toBeCloseTo(0.5, 1);
  expect((await lab.status()).finished).toBe(false);
  await onMap(page);
  await page.keyboard.press('b');
  await lab.watch((s) => s.scans, 'one scan back').toBe(half.scans - 1);
  await arrives(lab);
  await drag(lab, 1);
  expect(await moment(lab), 'the same map, to the bit').toEqual(end);

  await lab.show('settings');
  await lab.at('settings-search').fill('distance between keyframes');
  await lab.at('s-match.keyframe_distance').fill('1');
  await lab.at('s-match.keyframe_distance').blur();
  await expect.poll(async () => (await lab.state()).setup.settings).toEqual({ 'match.keyframe_distance': 1 });
  await lab.hidePanels();
  await goTo(lab, 0);
  await goTo(lab, end.time);
  const other = await moment(lab);
  expect([other.time, other.scans]).toEqual([end.time, end.scans]);
  expect(other.hash, 'matched to other keyframes').not.toBe(end.hash);
});

test('who goes by keys stays on the line, and nothing there drives', async ({ lab, page }) => {
  test.setTimeout(120_000);
  const end = await driven(lab);
  await lab.at('timeline').focus();
  // In quick succession: the second comes while the run is on its way.
  for (let i = 0; i < 3; i += 1) await page.keyboard.press('ArrowLeft');
  await arrives(lab);
  expect(await focused(page), 'the focus stays').toBe('timeline');
  await page.keyboard.press('ArrowLeft');
  await arrives(lab);
  expect(await focused(page)).toBe('timeline');
  const { time, mode } = await lab.status();
  expect(time / end.time, 'four steps of a hundredth back').toBeCloseTo(0.96, 1);
  expect(mode, 'nobody steers').toBe('explore');
  expect(await length(lab), 'the run did not take another way').toBeCloseTo(end.time, 6);
  await expect(lab.at('toast')).toHaveCount(0);

  // The same after a click.
  const box = (await lab.at('timeline').boundingBox())!;
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
  await page.keyboard.press('ArrowUp');
  await arrives(lab);
  await page.keyboard.press('ArrowUp');
  await arrives(lab);
  expect((await lab.status()).mode).toBe('explore');
  expect(await length(lab)).toBeCloseTo(end.time, 6);

  // Another run has no past yet.
  await lab.enter('office', '4');
  await lab.watch((s) => s.time, 'it begins').toBeGreaterThan(1);
  expect(await length(lab)).toBeLessThan(end.time);
});
