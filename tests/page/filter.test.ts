// Looking into the filter: the matrix, the walls on the map and the matches agree, and the figures
// are judged.
import type { Page } from '@playwright/test';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';
import { record } from './recording.ts';

/** A paused run with some walls, and the filter's panel open. */
async function lookInside(lab: Lab): Promise<void> {
  await lab.open();
  await lab.enter('arena', '10');
  await lab.watch((s) => s.features, 'walls are known').toBeGreaterThan(5);
  await lab.watch((s) => s.scans, 'there is something to judge').toBeGreaterThan(40);
  await lab.pause();
  await lab.show('filter');
  // The matrix is sent only while it is visible; on a phone it lies below the fold.
  await lab.at('correlations').scrollIntoViewIfNeeded();
  await expect(lab.at('correlations')).toHaveAttribute('data-rows', /^[1-9]/);
}

/** Tone of a cell of the matrix, the greatest difference between its colours: 0 is no
    correlation. */
const tones = (page: Page) => page.evaluate(() => {
  const canvas = document.querySelector('slam-correlations')!.shadowRoot!.querySelector('canvas')!;
  const n = canvas.width;
  const pixels = canvas.getContext('2d')!.getImageData(0, 0, n, n).data;
  const at = (row: number, column: number) => [...pixels.subarray(4 * (row * n + column), 4 * (row * n + column) + 3)].join();
  let asymmetric = 0;
  for (let row = 0; row < n; row += 1) for (let column = 0; column < row; column += 1) asymmetric += at(row, column) === at(column, row) ? 0 : 1;
  return { n, asymmetric, diagonal: new Set(Array.from({ length: n - 5 }, (_, i) => at(i + 5, i + 5))).size, colours: new Set(Array.from({ length: n }, (_, i) => at(n - 1, i))).size };
});

test('the matrix shows correlations: symmetric, ones on its diagonal, shades beside it', async ({ lab, page }) => {
  await lookInside(lab);
  await expect.poll(async () => (await tones(page)).n).toBe(Number(await lab.at('correlations').getAttribute('data-rows')));
  const { asymmetric, diagonal, colours } = await tones(page);
  expect(asymmetric).toBe(0);
  expect(diagonal, 'each wall is one with itself').toBe(1);
  expect(colours, 'and more or less with the others').toBeGreaterThan(5);
});

test('a cell names its two walls, which light up on the map', async ({ lab, page }) => {
  await lookInside(lab);
  const matrix = lab.at('correlations');
  await matrix.scrollIntoViewIfNeeded();
  const rows = Number(await matrix.getAttribute('data-rows'));
  const box = (await matrix.boundingBox())!;
  // Row: α of the third wall. Column: r of the first.
  await page.mouse.move(box.x + (box.width * 6.5) / rows, box.y + (box.height * 9.5) / rows);
  await expect(lab.at('correlation')).toHaveText(/^[−\d.]+ between α of wall \d+ and r of wall \d+$/);
  const named = [...(await lab.at('correlation').innerText()).matchAll(/wall (\d+)/g)].map((m) => Number(m[1]));
  expect((await lab.state()).spot.hovered).toEqual(named);
  await page.mouse.move(box.x + box.width * 0.5, box.y + box.height * 0.5);
  await page.mouse.move(box.x + box.width / 2, box.y - 30);
  expect((await lab.state()).spot.hovered, 'and go out again').toEqual([]);
});

test('the keyboard walks over the matrix without driving the robot', async ({ lab, page }) => {
  await lookInside(lab);
  await lab.at('correlations').focus();
  const { mode } = await lab.status();
  for (const key of ['ArrowDown', 'ArrowRight', 'ArrowRight']) await page.keyboard.press(key);
  await expect(lab.at('correlation')).toHaveText(/between y of the robot and θ of the robot$/);
  expect((await lab.status()).mode).toBe(mode);
});

test('a wall clicked on the map explains its match: candidates, distances, gates, winner', { tag: '@phone' }, async ({ lab, hasTouch }) => {
  await lookInside(lab);
  const { mode } = await lab.status();
  const row = lab.page.locator('slam-matches li button', { hasText: 'recognised' }).first();
  const wall = /wall (\d+)/.exec(await row.innerText())![1];
  await row.click();
  await expect(lab.at('match').first()).toContainText(new RegExp(`Wall ${wall}: recognised`));
  const winner = lab.at('match').first().locator('tr.winner');
  await expect(winner).toContainText(`wall ${wall} ✓`);
  await expect(winner).toContainText('inside the gate');
  const d2 = Number((await winner.locator('td').nth(1).innerText()).trim());
  expect(d2, 'inside the 99 % gate').toBeLessThanOrEqual(9.21);
  // The same wall from the map: a click on its middle sets no goal.
  await lab.at('unpin').click();
  const [x, y] = await lab.wallMiddle(Number(wall));
  await lab.pointAt(x, y, hasTouch);
  await expect(lab.at('match').first()).toContainText(`Wall ${wall}`);
  expect((await lab.status()).mode, 'the robot stays on its errand').toBe(mode);
});

test('the figures are judged, and drawn with their bands', async ({ lab }) => {
  await lookInside(lab);
  await expect(lab.at('diagnosis')).toContainText(/Honest|Cautious|Overconfident|Sightings err/);
  // The readouts are those of the worker's samples: NEES and NIS.
  await expect(lab.at('plot-7')).toHaveText(/^\d+\.\d\d$/);
  await expect(lab.at('plot-10')).toHaveText(/^\d+\.\d\d$/);
  const nis = Number(await lab.at('plot-10').innerText());
  expect(nis).toBeGreaterThan(0.2);
  expect(nis).toBeLessThan(5);
  await expect(lab.at('learned'), 'what the walls taught of the tracks').toHaveText(/[\d.]+ ± [\d.]+ °\/m to the (left|right), a turn is\s+[\d.]+ ± [\d.]+ % (smaller|larger)/);
});

test('a method without a filter says so; a recording can be mapped again by another method', async ({ lab }) => {
  await lab.open();
  await lab.show('run');
  await lab.at('file').setInputFiles({ name: 'laps.log', mimeType: 'text/plain', buffer: Buffer.from(record(200).text) });
  await expect.poll(async () => (await lab.state()).source).toBe('replay');
  await lab.watch((s) => s.finished, 'it is mapped').toBe(true);
  await lab.show('filter');
  await expect(lab.at('no-filter')).toBeVisible();
  await lab.show('run');
  await expect(lab.at('method')).toHaveValue('scan-matching');
  await lab.at('method').selectOption('line-ekf');
  await expect.poll(async () => (await lab.state()).method).toBe('line-ekf');
  await lab.watch((s) => s.finished && s.features > 3, 'it is mapped again, with walls').toBe(true);
  await lab.show('filter');
  // The matrix is requested while it is visible.
  await lab.at('correlations').scrollIntoViewIfNeeded();
  await expect(lab.at('correlations')).toHaveAttribute('data-rows', /^[1-9]/);
  await expect(lab.at('diagnosis')).toBeVisible();
});
