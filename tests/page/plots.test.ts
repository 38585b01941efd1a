// The curves can be saved as tables, and have labels.
import { readFile } from 'node:fs/promises';
import type { Page } from '@playwright/test';
import { axisEnd } from '../../www/src/ui/axis_end.ts';
import { expect, test } from './fixture.ts';
import { drop, type Lab } from './lab.ts';
import { record } from './recording.ts';

test('the plots of a simulation are saved as a table with units, each scan in it', { tag: '@phone' }, async ({ lab, page }) => {
  await lab.open();
  await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(20);
  await stepOn(lab);
  const table = await saved(page, lab, 'slam-plots', 'plots');
  expect(table.name).toBe('office-plots.csv');
  const innovation = (name: string, unit: string) => `${name} (${unit}),"${name}, ±2σ, upper (${unit})","${name}, ±2σ, lower (${unit})"`;
  expect(table.header).toBe(`Time (s),Position error (m),"Position error, 3σ (m)",Heading error (°),"Heading error, 3σ (°)",${innovation('Innovation α', '°')},${innovation('Innovation r', 'cm')},"Features, seen","Features, matched","Features, new",Time per scan (ms)`);
  const status = await lab.status();
  const last = table.rows.at(-1)!;
  expect(table.rows.length, 'a row for each scan').toBe(status.scans);
  expect(last[0]).toBeCloseTo(status.time, 6);
  expect(last[1], 'as far as the pose is from the truth').toBeCloseTo(Math.hypot(status.x - status.truthX, status.y - status.truthY), 9);
  expect(last[4], '3σ of the heading').toBeCloseTo((3 * 180 / Math.PI) * Math.sqrt(status.covHeading), 9);
  const { alpha, alphaSigma, r, rSigma } = status.innovation!;
  expect(last[5], 'α of the walls of the last scan').toBeCloseTo((180 / Math.PI) * alpha, 9);
  expect(last[6], 'and its bound').toBeCloseTo((2 * 180 / Math.PI) * alphaSigma, 9);
  expect([last[8], last[9], last[10]], 'r the same way').toEqual([100 * r, 200 * rSigma, -200 * rSigma]);
  expect([last[11], last[12], last[13]]).toEqual([status.featuresSeen, status.featuresMatched, status.featuresNew]);
  const [, matched] = [last[11]!, last[12]!];
  expect(matched, 'walls are recognised').toBeGreaterThan(0);
  await expect(lab.at('plot-26')).toHaveText(`${last[11]} / ${last[12]} / ${last[13]}`);
  await expect(lab.at('plot-16')).toHaveText(`${last[8]!.toFixed(2).replace('-', '−')} cm`);
  const known = table.rows.filter((row) => Number.isFinite(row[5]));
  const within = known.filter((row) => Math.abs(row[5]!) <= row[6]!);
  expect(within.length / known.length, 'most innovations lie between their bounds').toBeGreaterThan(0.7);
  expect(known.some((row) => row[5]! < 0) && known.some((row) => row[5]! > 0), 'to either side').toBe(true);
  expect(table.rows.every((row, i) => i === 0 || row[0]! > table.rows[i - 1]![0]!), 'in the order of time').toBe(true);
  await expect(lab.at('plot-1'), 'and the plot says the same').toHaveText(`${last[1]!.toFixed(3)} m`);
});

test('a recording has no truth: its curves and their table tell of no error', async ({ lab, page }) => {
  await lab.open();
  await drop(page, 'short.log', Buffer.from(record(40).text));
  await expect.poll(async () => (await lab.state()).source, 'the recording is shown').toBe('replay');
  // A recording is mapped as fast as possible: repeat its last scans one by one.
  await lab.watch((s) => s.finished, 'the recording ends').toBe(true);
  const { scans } = await lab.status();
  await page.keyboard.press('b');
  await lab.watch((s) => s.scans, 'one scan back').toBeLessThan(scans);
  await expect.poll(async () => (await lab.state()).seeking).toBe(null);
  await stepOn(lab);
  await lab.show('plots');
  const plots = page.locator('slam-plots');
  await expect(plots.getByText('Position uncertainty')).toBeVisible();
  await expect(plots.getByText('Heading uncertainty')).toBeVisible();
  await expect(plots.getByText(/error/i)).toHaveCount(0);
  const table = await saved(page, lab, 'slam-plots', 'plots');
  expect(table.name).toBe('short-log-plots.csv');
  expect(table.header).toContain('Position uncertainty');
  expect(table.header).not.toMatch(/error/i);
  const status = await lab.status();
  const sigma3 = 3 * Math.sqrt((status.covXx + status.covYy) / 2 + Math.hypot((status.covXx - status.covYy) / 2, status.covXy));
  expect(table.rows.at(-1)![1]).toBeCloseTo(sigma3, 9);
  await expect(lab.at('plot-1'), 'the number beside the title is the claim').toHaveText(`${sigma3.toFixed(3)} m`);
});

test('the honesty of the filter is saved with both bounds', async ({ lab, page }) => {
  await lab.open();
  await lab.watch((s) => s.nis, 'the filter is judged').toBeGreaterThan(0);
  await stepOn(lab);
  const table = await saved(page, lab, 'slam-consistency', 'filter');
  expect(table.name).toBe('office-consistency.csv');
  const [time, , , , nis, high, low] = table.rows.at(-1)!;
  const status = await lab.status();
  expect([time, nis, high, low]).toEqual([status.time, status.nis, status.nisHigh, status.nisLow]);
  expect(low!).toBeLessThan(high!);
});

test('a few values far beyond all others do not flatten a curve', () => {
  const curve = Array.from({ length: 400 }, (_, i) => 1 + Math.sin(i));
  const spiked = (places: readonly number[], value: number): number[] => curve.map((v, i) => (places.includes(i) ? value : v));
  const end = Math.max(...curve);
  expect(axisEnd([curve], 0, 399)).toBe(end);
  expect(axisEnd([spiked([17], 500)], 0, 399), 'one spike').toBe(end);
  expect(axisEnd([spiked([17, 18, 200, 399], -500)], 0, 399), 'four of 400, to the other side').toBe(end);
  expect(axisEnd([curve.map((v, i) => (i === 3 ? 5000 : i === 4 ? 50 : v))], 0, 399), 'one that hides another').toBe(end);
  expect(axisEnd([spiked([17, 18, 200, 300, 399], 500)], 0, 399), 'five of 400 are not rare').toBe(500);
  expect(axisEnd([spiked([17], 7)], 0, 399), 'not far beyond').toBe(7);
  expect(axisEnd([spiked([17], 500)], 10, 60), 'who looks at the spike sees it').toBe(500);
  expect(axisEnd([spiked([17], 500), curve.map(() => 100)], 0, 399), 'a bound beside it is no spike').toBe(100);
  expect(axisEnd([curve.map((_, i) => (i === 5 ? 3 : 0))], 0, 399), 'nothing else is there').toBe(3);
  expect(axisEnd([[null, NaN, undefined, 2]], 0, 3), 'gaps are not values').toBe(2);
  expect(axisEnd([[]], 0, -1)).toBe(0);
});

/** Pauses just after a scan: the page shows that scan, and so does the last row. */
async function stepOn(lab: Lab): Promise<void> {
  await lab.pause();
  const { scans } = await lab.status();
  await lab.at('step').click();
  await lab.watch((s) => s.scans, 'one scan more').toBe(scans + 1);
}

async function saved(page: Page, lab: Lab, plots: string, panel: 'plots' | 'filter'): Promise<{ name: string; header: string; rows: number[][] }> {
  await lab.show(panel);
  const coming = page.waitForEvent('download');
  await page.locator(plots).getByTestId('csv').click();
  const download = await coming;
  const [header = '', ...lines] = (await readFile(await download.path(), 'utf8')).trimEnd().split('\r\n');
  return { name: download.suggestedFilename(), header, rows: lines.map((line) => line.split(',').map((cell) => (cell === '' ? NaN : Number(cell)))) };
}

test('what has no innovation says why, and shows what it has in its place', async ({ lab, page }) => {
  await lab.open();
  await lab.show('plots');
  await expect(lab.at('plot-13'), 'the line filter has innovations').toContainText('°');
  await expect(lab.at('no-innovation')).toHaveCount(0);
  await lab.at('method').selectOption('scan-matching');
  await lab.watch((s) => s.scanResidual, 'the match has a residual').toBeGreaterThan(0);
  await expect(lab.at('plot-25')).toContainText('mm');
  await expect(lab.at('no-innovation')).toContainText('Whole scans are matched');
  await expect(lab.at('plot-13')).toBeHidden();
  const { featuresSeen, featuresMatched, featuresNew, innovation } = await lab.status();
  expect(featuresMatched).toBeLessThanOrEqual(featuresSeen);
  expect([featuresNew, innovation]).toEqual([NaN, null]);
  await lab.at('method').selectOption('odometry');
  await expect(lab.at('no-innovation')).toContainText('compares nothing');
  await expect(lab.at('plot-25')).toBeHidden();
  await expect(lab.at('plot-26')).toBeHidden();
});

test('points that are landmarks have innovations of their own', async ({ lab, page }) => {
  await lab.open();
  await lab.show('settings');
  await lab.at('settings-search').fill('ekf.landmarks');
  await lab.at('s-ekf.landmarks').selectOption({ index: 2 });
  await page.keyboard.press('Escape');
  await lab.at('method').selectOption('line-ekf');
  await lab.at('restart').click();
  await lab.watch((s) => s.innovation?.xSigma ?? NaN, 'a point is recognised').toBeGreaterThan(0);
  await lab.show('plots');
  await expect(lab.at('plot-19')).toContainText('cm');
});
