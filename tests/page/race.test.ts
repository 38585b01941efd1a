// Runs side by side: the same world or recording with other methods or settings, at the same
// moment, in one view, with their errors in one plot.
import { readFile } from 'node:fs/promises';
import { AxeBuilder } from '@axe-core/playwright';
import type { Page } from '@playwright/test';
import { expect, test } from './fixture.ts';
import { drop, type Lab } from './lab.ts';
import { record } from './recording.ts';
import type { Status } from '../../www/src/protocol/frame.ts';

interface Beside { name: string; isThere: boolean; playing: boolean; status: Status | null; hash: string; method: string; camera: { x: number; y: number; scale: number; angle: number }; layers: Record<string, boolean> }

const beside = (lab: Lab): Promise<Beside[]> => lab.page.evaluate(() => (window as unknown as { slamlab: { beside: Beside[] } }).slamlab.beside);

/** Chooses methods to compare with, as a person does. */
async function against(lab: Lab, ...methods: string[]): Promise<void> {
  await lab.at('compare').click();
  for (const method of methods) await lab.at(`race-${method}`).check();
  await lab.at('race-go').click();
  await expect(lab.at('race')).toBeHidden();
  await expect.poll(async () => (await beside(lab)).slice(-methods.length).every(({ isThere }) => isThere), { message: 'they have caught up', timeout: 40_000 }).toBe(true);
}

/** Waits until all are at the moment of the run that is shown; returns their states. */
async function together(lab: Lab): Promise<[Status, ...Status[]]> {
  let all: [Status, ...Status[]] | null = null;
  await expect.poll(async () => {
    const [shown, others] = [await lab.status(), await beside(lab)];
    all = [shown, ...others.map(({ status }) => status!)];
    return others.map(({ status }) => Math.abs((status?.time ?? NaN) - shown.time) < 1e-6);
  }, { message: 'all have come to the same moment', timeout: 30_000 }).toEqual((await beside(lab)).map(() => true));
  return all!;
}

async function fine(page: Page, state: string): Promise<void> {
  const { violations } = await new AxeBuilder({ page }).setLegacyMode().analyze();
  const serious = violations.filter((v) => v.impact === 'serious' || v.impact === 'critical');
  expect(serious.map((v) => `${v.id}: ${v.nodes.map((n) => n.target.join(' ')).join('; ')}`), state).toEqual([]);
}

test('methods race in the same world at the same moment, and one plot has the errors of all', { tag: '@phone' }, async ({ lab, page, isMobile }) => {
  await lab.open();
  await lab.watch((s) => s.time, 'the run is under way').toBeGreaterThan(4);
  await against(lab, 'scan-matching', 'odometry');
  await expect(page.locator('#maps slam-map')).toHaveCount(3);
  for (const [place, name] of ['Line EKF-SLAM', 'Odometry', 'Scan matching'].entries()) await expect(page.locator('slam-race-chip').filter({ has: lab.at(`race-now-${place}`) })).toContainText(name);
  const before = await lab.status();
  await lab.watch((s) => s.time, 'they go on together').toBeGreaterThan(before.time + 3);
  await lab.pause();
  await together(lab);
  // A step takes all of them one scan on.
  const { scans } = await lab.status();
  await lab.at('step').click();
  await lab.watch((s) => s.scans, 'one scan more').toBe(scans + 1);
  const states = await together(lab);
  const counts = states.map((status) => status.scans);
  expect(new Set(counts).size, `the same sensor has scanned as often: ${counts}`).toBe(1);
  await lab.show('plots');
  for (const [place, status] of states.entries()) {
    const error = Math.hypot(status.x - status.truthX, status.y - status.truthY);
    await expect(lab.at(`race-run-${place}`).locator('td').nth(1), 'what the table says is the error of this run').toHaveText(error.toFixed(3));
  }
  expect(states[1]?.positionError, 'wheels alone are worse').toBeGreaterThan(states[0].positionError);
  await expect(page.locator('slam-race-plot .uplot')).toHaveCount(1);
  const coming = page.waitForEvent('download');
  await lab.at('race-csv').click();
  const table = (await readFile(await (await coming).path(), 'utf8')).trimEnd().split('\r\n');
  expect(table[0]).toBe('Time (s),"Position error, Line EKF-SLAM (m)","Position error, Odometry (m)","Position error, Scan matching (m)"');
  const last = table.at(-1)!.split(',').map(Number);
  expect(last).toEqual([states[0].time, ...states.map((status) => status.positionError)]);
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  // Ending one leaves the others.
  await lab.hidePanels();
  await lab.at('race-close-1').click();
  await expect(page.locator('#maps slam-map')).toHaveCount(2);
  expect((await beside(lab)).map(({ name }) => name)).toEqual(['Scan matching']);
  await lab.at('play').click();
  await lab.watch((s) => s.time, 'it goes on').toBeGreaterThan(states[0].time + 1);
  await expect.poll(async () => (await beside(lab))[0]?.status?.time, 'and so does the other').toBeGreaterThan(states[0].time + 1);
  await lab.at('race-close-3').or(lab.at('race-close-2')).click();
  await expect(page.locator('#maps slam-map')).toHaveCount(1);
  const { time } = await lab.status();
  await lab.watch((s) => s.time, 'alone it goes on too').toBeGreaterThan(time + 1);
  if (!isMobile) await expect(page.locator('#legend')).toBeVisible();
});

for (const theme of ['light', 'dark'] as const) {
  test(`nothing serious stands in anyone's way while runs are compared, ${theme}`, { tag: '@phone' }, async ({ lab, page }) => {
    await page.emulateMedia({ colorScheme: theme });
    await lab.open();
    await lab.at('compare').click();
    await lab.at('race-setting').selectOption('ekf.gate');
    await fine(page, 'what to compare with is chosen');
    await lab.at('race-setting').selectOption('');
    await lab.at('race-odometry').check();
    await lab.at('race-go').click();
    await expect.poll(async () => (await beside(lab))[0]?.isThere).toBe(true);
    await lab.pause();
    await lab.show('plots');
    await fine(page, 'runs side by side');
  });
}

test('one view fits all: pan, zoom and layers are those of each', async ({ lab, page }) => {
  await lab.open();
  await lab.pause();
  await against(lab, 'scan-matching');
  await lab.stillCamera();
  const other = (await lab.at('map-beside').boundingBox())!;
  await page.mouse.move(other.x + other.width / 2, other.y + other.height / 2);
  const { scale } = (await lab.state()).camera;
  await page.mouse.wheel(0, -300);
  await expect.poll(async () => (await lab.state()).camera.scale, 'a wheel over the other map zooms').toBeGreaterThan(1.05 * scale);
  await page.mouse.down();
  await page.mouse.move(other.x + other.width / 2 + 60, other.y + other.height / 2, { steps: 4 });
  await page.mouse.up();
  await expect.poll(async () => (await beside(lab))[0]?.camera).toEqual((await lab.state()).camera);
  await page.keyboard.press('q');
  await expect.poll(async () => (await beside(lab))[0]?.camera.angle, 'both are turned').toBeGreaterThan(0.2);
  const { truth } = (await beside(lab))[0]!.layers;
  await page.keyboard.press('x');
  await expect.poll(async () => (await beside(lab))[0]?.layers['truth'], 'the truth is shown or hidden in both').toBe(!truth);
});

test('a run is forked where it is, with another setting: both are one until then', async ({ lab, page }) => {
  await lab.open();
  await lab.watch((s) => s.time, 'the run is under way').toBeGreaterThan(8);
  await lab.pause();
  await page.keyboard.press('c');
  await lab.at('race-setting').selectOption('ekf.gate');
  await expect(lab.at('race-go'), 'the number is not another yet').toBeDisabled();
  await lab.at('race-value').fill('0.01');
  await expect(lab.at('race-go'), 'nor is it one that may be').toBeDisabled();
  await expect(lab.at('race')).toContainText('0.1 to 100');
  await lab.at('race-value').fill('0.1');
  await lab.at('race-fork').check();
  await lab.at('race-go').click();
  const [shown, forked] = await together(lab);
  expect([forked!.x, forked!.y, forked!.heading, forked!.scans], 'the same to the bit').toEqual([shown.x, shown.y, shown.heading, shown.scans]);
  await expect.poll(async () => (await beside(lab))[0]?.hash, 'and so are the hashes').toBe((await lab.state()).hash);
  await lab.at('play').click();
  await lab.watch((s) => s.time, 'both go on').toBeGreaterThan(shown.time + 4);
  await lab.pause();
  const [after, other] = await together(lab);
  expect(other!.x, 'a filter that matches hardly anything goes another way').not.toBe(after.x);
  expect(other!.featuresMatched).toBeLessThan(after.featuresMatched);
  // Back before the fork: both are there again, and identical.
  await lab.at('timeline').fill(String(shown.time - 3));
  await expect.poll(async () => (await lab.state()).seeking).toBe(null);
  const [earlier, same] = await together(lab);
  expect(earlier.time).toBeLessThan(shown.time);
  expect([same!.x, same!.y]).toEqual([earlier.x, earlier.y]);
});

test('what is done on one map is done to all', async ({ lab, page, isMobile }) => {
  await lab.open();
  await lab.pause();
  await against(lab, 'scan-matching');
  await lab.at('mode-goto').click();
  const other = (await lab.at('map-beside').boundingBox())!;
  const at = await page.evaluate(() => (window as unknown as { slamlab: { toScreen(x: number, y: number): [number, number] } }).slamlab.toScreen(1, 0.2));
  await page.mouse.click(other.x + at[0], other.y + at[1]);
  await lab.watch((s) => s.goalX, 'the robot that is shown drives there').toBeCloseTo(1, 1);
  await expect.poll(async () => (await beside(lab))[0]?.status?.goalX, 'and the other one').toBeCloseTo(1, 1);
  expect(isMobile).toBe(false);
});

test('methods race on a recording, where no curve is called an error', async ({ lab, page }) => {
  await lab.open();
  await drop(page, 'short.log', Buffer.from(record(40).text));
  await expect.poll(async () => (await lab.state()).source, 'the recording is shown').toBe('replay');
  await lab.watch((s) => s.finished, 'the recording ends').toBe(true);
  await against(lab, 'line-ekf');
  await expect.poll(async () => (await beside(lab))[0]?.status?.finished, 'the other has mapped it too').toBe(true);
  const [shown, other] = [await lab.status(), (await beside(lab))[0]!];
  expect([other.status!.scans, other.method]).toEqual([shown.scans, 'line-ekf']);
  await expect(page.locator('slam-race-plot')).toContainText('there is no truth here');
  await expect(page.locator('slam-race-plot')).not.toContainText(/error/i);
  await expect.poll(async () => Number(await lab.at('race-run-1').locator('td').nth(2).innerText()), 'how far the two ways lie apart').toBeLessThan(0.3);
  await lab.enter('arena', '4');
  await expect(page.locator('#maps slam-map'), 'another world is not raced in').toHaveCount(1);
});

test('a run whose worker fails leaves, and keeps nobody waiting', async ({ lab, page, problems }) => {
  await lab.open();
  await against(lab, 'odometry');
  const [, other] = page.workers();
  await other!.evaluate(() => void setTimeout(() => { throw new Error('the module is gone'); }));
  await expect(page.locator('#maps slam-map'), 'its map goes').toHaveCount(1);
  await expect(page.locator('slam-toast')).toContainText('Odometry:');
  const { time } = await lab.status();
  await lab.watch((s) => s.time, 'the run that is shown goes on').toBeGreaterThan(time + 2);
  problems.length = 0;
});
