// The inspector: whatever is clicked shows its numbers, which are compared with the exported map
// and the walls of the built-in world; by mouse, by touch and by keys; and no click of it drives.
import { readFile } from 'node:fs/promises';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

/** `arena` is 5 x 4 m and the robot begins 0.6 m and 0.7 m from two of its walls, along x. So the
    outer walls are these lines of the map, α in degrees and r in m. */
const OUTER = [[0, 4.4], [90, 3.3], [180, 0.6], [-90, 0.7]] as const;

interface Inside {
  thing: { kind: string; id?: number } | null;
  landmarks: { id: number; kind: string; confidence: number }[];
  wall(id: number): number[] | null;
}

const inside = <T>(lab: Lab, read: (inside: Inside) => T): Promise<T> =>
  lab.page.evaluate((read) => (0, eval)(`(${read})`)((window as unknown as { slamlab: Inside }).slamlab) as T, read.toString());

/** The number at the beginning of a figure, in m or in its own unit. */
async function figure(lab: Lab, id: string): Promise<number> {
  const text = (await lab.at(id).innerText()).replaceAll('−', '-');
  const [, digits = '', unit = ''] = /^[±+]?(-?[\d.]+)\s*(\S*)/.exec(text) ?? [];
  return Number(digits) * (unit === 'cm' ? 0.01 : 1);
}

/** A run in the arena that has seen something, and is paused. */
async function looked(lab: Lab): Promise<void> {
  await lab.open();
  await lab.show('run');
  await lab.at('sensor').selectOption('lidar');
  await lab.enter('arena', '4');
  await lab.watch((s) => s.scans, 'it has looked around').toBeGreaterThan(12);
  await lab.pause();
}

/** Walls of the map by the length of their known part, the longest first. */
const walls = async (lab: Lab): Promise<{ id: number; ends: number[] }[]> => {
  const all = await inside(lab, ({ landmarks, wall }) => landmarks.filter((l) => l.kind === 'wall').map(({ id }) => ({ id, ends: wall(id) ?? [] })));
  const length = ({ ends: [x1 = 0, y1 = 0, x2 = 0, y2 = 0] }: { ends: number[] }): number => Math.hypot(x2 - x1, y2 - y1);
  return all.sort((a, b) => length(b) - length(a));
};

test('a cell has the probability that the exported map has', async ({ lab, page }) => {
  await looked(lab);
  await lab.show('run');
  const [download] = await Promise.all([page.waitForEvent('download'), save(lab, 'og-map')]);
  const [head = '', ...rows] = (await readFile(await download.path(), 'utf8')).trim().split('\n');
  const [width = 0, height = 0, side = 0, left = 0, low = 0] = head.split(' ').map(Number);
  const p = rows.map((row) => row.trim().split(/\s+/).map(Number));
  expect([p.length, p[0]?.length]).toEqual([height, width]);
  await lab.at('inspect').click();
  await expect(lab.at('robot-title')).toHaveText('The robot');
  // A cell that is certainly free, the most certain wall, and an unknown one.
  const cells = p.flatMap((row, y) => row.map((value, x) => ({ x: left + (x + 0.5) * side, y: low + (y + 0.5) * side, value })));
  const away = ({ x, y }: { x: number; y: number }): boolean => Math.hypot(x, y) > 0.5;
  const sorted = cells.filter(away).sort((a, b) => a.value - b.value);
  const unknown = sorted.find(({ value }) => value === 0.5);
  for (const cell of [sorted[0], sorted[Math.floor(sorted.length / 9)], sorted.at(-1), unknown]) {
    if (!cell) throw new Error('the map has no such cell');
    await lab.pointAt(cell.x, cell.y, false);
    for (let more = 0; more < 6 && (await lab.at('cell-title').count()) === 0; more += 1) await lab.at('inspect-next').click();
    const middle = [cell.x, cell.y].map((at) => at.toFixed(3).replace('-', '−')).join(', ');
    await expect(lab.at('cell-where')).toHaveText(`${middle} m`);
    await expect(lab.at('cell-p')).toHaveText(/%$/);
    expect(await figure(lab, 'cell-p')).toBeCloseTo(100 * cell.value, 0);
    const odds = Math.log(cell.value / (1 - cell.value));
    expect(Math.abs((await figure(lab, 'cell-l')) - odds)).toBeLessThan(0.02 + 1e-3 / (cell.value * (1 - cell.value)));
    await expect(lab.at('cell-fate')).toHaveText(cell.value > 0.65 ? 'Occupied' : cell.value < 0.35 ? 'Free' : 'Unknown');
    await expect(lab.at('formula').first()).toContainText('Celej');
  }
});

test('a wall has the line of the world, and what would flip its match', async ({ lab }) => {
  await looked(lab);
  const before = await lab.status();
  await lab.at('inspect').click();
  const [longest] = await walls(lab);
  if (!longest) throw new Error('the map has no wall');
  await lab.pointAt(...(await lab.wallMiddle(longest.id)), false);
  await expect(lab.at('line-title')).toHaveText(`Wall ${longest.id}`);
  const [alpha, r] = [await figure(lab, 'line-alpha'), await figure(lab, 'line-r')];
  const off = OUTER.map(([a, d]) => [Math.abs(((alpha - a + 540) % 360) - 180), Math.abs(r - d)] as const);
  const nearest = off.sort((a, b) => a[0] + 50 * a[1] - b[0] - 50 * b[1])[0];
  expect(nearest?.[0], 'α is that of an outer wall, °').toBeLessThan(2);
  expect(nearest?.[1], 'and so is r, m').toBeLessThan(0.05);
  expect(await figure(lab, 'line-sigma-r')).toBeGreaterThan(0);
  const [id, confidence] = await inside(lab, ({ thing, landmarks }) => [thing?.id, landmarks.find((l) => l.id === thing?.id)?.confidence]);
  expect(id).toBe(longest.id);
  await expect(lab.at('line-seen')).toHaveText(confidence === 0 ? 'once' : `${Number(confidence) + 1} times`);
  // One of the walls was matched in the last scan.
  const matched = lab.at('line-match').filter({ hasText: 'recognised' });
  const scanned = matched.or(lab.at('line-unseen')).or(lab.at('line-match')).or(lab.at('line-rival')).first();
  for (const { id: wall } of await walls(lab)) {
    await lab.pointAt(...(await lab.wallMiddle(wall)), false);
    for (let more = 0; more < 6 && (await inside(lab, ({ thing }) => thing))?.kind !== 'line'; more += 1) await lab.at('inspect-next').click();
    await expect(scanned).toBeVisible();
    if ((await matched.count()) > 0) break;
  }
  await expect(matched.first()).toContainText(/recognised: d² to wall \d+ is [\d.]+/);
  await expect(lab.at('flips').first().locator('li')).toHaveCount(4);
  await expect(lab.at('flips').first()).toContainText(/nearer by [\d.]+ c?m: (it would leave the gate|wall \d+ would explain it as well)/);
  await expect(lab.at('line')).toContainText('TDK 2016 eq. (3.10), (3.12), (3.13)');
  // The robot was not sent anywhere.
  await lab.at('play').click();
  await lab.watch((s) => s.time, 'it goes on').toBeGreaterThan(before.time + 0.5);
  expect((await lab.status()).mode, 'a click that drives would end the exploration').toBe(before.mode);
});

test('a beam is held against the walls of the world, with its numbers in both sensor models', async ({ lab, page }) => {
  await looked(lab);
  await lab.at('inspect').click();
  const hits = await page.evaluate(() => Array.from({ length: 400 }, (_, i) => (window as unknown as { slamlab: { hit(beam: number): [number, number] } }).slamlab.hit(i)).filter(([x]) => Number.isFinite(x)));
  const { x, y } = (await lab.status()) as unknown as { x: number; y: number };
  // On the wall to the right, which is 4.4 m from the start, or else to the left; the hit nearest
  // to perpendicular, because the wall is known best there.
  const [hit] = hits.filter(([x]) => Math.abs(x - 4.4) < 0.08 || Math.abs(x + 0.6) < 0.08).sort((a, b) => Math.abs(a[1] - y) - Math.abs(b[1] - y));
  if (!hit) throw new Error('no beam hit the wall');
  await lab.inspectAt('beam', ...hit);
  const away = Math.hypot(hit[0] - x, hit[1] - y);
  expect(Math.abs((await figure(lab, 'beam-range')) - away), 'the range').toBeLessThan(0.15);
  expect(Math.abs((await figure(lab, 'beam-expected')) - away), 'and that of the map').toBeLessThan(0.2);
  const [z, expected, residual] = [await figure(lab, 'beam-range'), await figure(lab, 'beam-expected'), await figure(lab, 'beam-residual')];
  expect(Math.abs(z - expected - residual)).toBeLessThan(0.012);
  const d = await figure(lab, 'beam-nearest');
  expect(d, 'the scan is part of the map').toBeLessThan(0.06);
  expect(await figure(lab, 'beam-likelihood')).toBeGreaterThan(0.1);
  await expect(lab.at('beam-fate')).toHaveText(/Agrees|Shorter|Longer/);
  await expect(lab.at('formula')).toHaveCount(2);
  await expect(lab.at('formula').nth(0)).toContainText('eq. (6.4)');
  await expect(lab.at('formula').nth(1)).toContainText('table 6.3');
});

test('a door that stands open is open by the map, and one in front of which nobody looked is not known', async ({ lab, page }) => {
  test.setTimeout(90_000);
  await lab.open();
  await lab.enter('doors', '4');
  await lab.show('layers');
  if (!(await lab.at('layer-truth').isChecked())) await lab.at('layer-truth').click();
  await lab.watch((s) => s.explored, 'it has been through some').toBeGreaterThan(0.5);
  await lab.pause();
  await lab.at('inspect').click();
  const doors = await page.evaluate(() => [...(window as unknown as { slamlab: { doors: number[] } }).slamlab.doors]);
  const [x1 = NaN, y1 = NaN, x2 = NaN, y2 = NaN, open] = doors;
  await lab.inspectAt('door', (x1 + x2) / 2, (y1 + y2) / 2);
  await expect(lab.at('door-fate')).toHaveText(open === 1 ? 'Stands open' : 'Stands shut');
  expect(await figure(lab, 'door-width')).toBeCloseTo(Math.hypot(x2 - x1, y2 - y1), 1);
  const [p, sum] = [await figure(lab, 'leaf-open'), await figure(lab, 'leaf-sum')];
  expect(Math.abs(p - 100 / (1 + Math.exp(sum)))).toBeLessThan(0.3);
  expect(open === 1 ? p : 100 - p, 'the map agrees with the truth').toBeGreaterThan(90);
  await expect(lab.at('formula').first()).toContainText('eq. (9.6)');
});

test('what was pointed at comes out from under the card', async ({ lab, page }) => {
  await looked(lab);
  const box = (await lab.at('map').boundingBox())!;
  await lab.stillCamera();
  // Moving the view keeps it where it is; then point at its left edge, where the card will be.
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.wheel(0, -100);
  await lab.at('inspect').click();
  await lab.at('inspector').getByRole('button', { name: 'Close' }).click();
  await expect(lab.at('inspector')).toHaveCount(0);
  await lab.stillCamera();
  const toScreen = (x: number, y: number): Promise<[number, number]> => page.evaluate(([x, y]) => (window as unknown as { slamlab: { toScreen(x: number, y: number): [number, number] } }).slamlab.toScreen(x!, y!), [x, y]);
  const [zeroX, zeroY] = await toScreen(0, 0);
  const scale = (await lab.state()).camera.scale;
  const place = [(300 - zeroX) / scale, (zeroY - 300) / scale] as const;
  await lab.pointAt(...place, false);
  await expect(lab.at('inspector')).toBeVisible();
  const card = (await lab.at('inspector').boundingBox())!;
  await expect.poll(async () => (await toScreen(...place))[0] + box.x, 'it lies beside the card').toBeGreaterThan(card.x + card.width);
});

test('the robot by touch: its pose, and the truth only where it is shown', { tag: '@phone-only' }, async ({ lab, page }) => {
  await looked(lab);
  await lab.hidePanels();
  await lab.at('inspect').tap();
  await expect(lab.at('robot-title')).toHaveText('The robot');
  await lab.at('robot').getByRole('button', { name: 'Close' }).tap();
  await expect(lab.at('inspector')).toHaveCount(0);
  const { x, y, mode, covXx, covYy } = await lab.status();
  await lab.pointAt(x, y, true);
  await expect(lab.at('robot-pose')).toHaveText(`${x.toFixed(2).replace('-', '−')}, ${y.toFixed(2).replace('-', '−')} m`);
  expect(await figure(lab, 'ellipse'), 'no longer than the sum of both').toBeLessThanOrEqual(Math.sqrt(5.991 * (covXx + covYy)) + 1e-3);
  await expect(lab.at('robot-truth')).toHaveCount(1);
  expect((await lab.status()).mode, 'a tap asks, and sends nobody').toBe(mode);
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), 'nothing stands over').toBeLessThanOrEqual(0);
  const [card, bar] = [await lab.at('inspector').boundingBox(), await lab.at('play').boundingBox()];
  expect(card!.y + card!.height, 'time and Stop stay free').toBeLessThanOrEqual(bar!.y + 1);
  await lab.at('robot').getByRole('button', { name: 'Close' }).tap();
  await lab.at('inspect').tap();
  await expect(lab.at('inspect')).toHaveAttribute('aria-pressed', 'false');
  await expect(lab.at('inspector')).toHaveCount(0);
});

test('by keys alone: what is near the robot, what lies under it, the cross, and Esc stops nobody', async ({ lab, page }) => {
  await looked(lab);
  await lab.at('play').click();
  await expect.poll(async () => (await lab.status()).mode).toBe('explore');
  await lab.at('map').focus();
  await page.keyboard.press('i');
  await expect(lab.at('inspect')).toHaveAttribute('aria-pressed', 'true');
  await expect(lab.at('robot-title')).toHaveText('The robot');
  await expect(lab.at('inspect-step')).toHaveText(/^1 of \d+$/);
  await lab.at('inspect-next').focus();
  await page.keyboard.press('Enter');
  await expect(lab.at('inspect-step')).toHaveText(/^2 of \d+$/);
  await expect.poll(async () => (await inside(lab, ({ thing }) => thing))?.kind).not.toBe('robot');
  await lab.at('map').focus();
  await page.keyboard.press('Enter');
  await expect(lab.at('inspector')).toBeVisible();
  await page.keyboard.press('Escape');
  await expect(lab.at('inspector')).toHaveCount(0);
  await expect(lab.at('inspect')).toHaveAttribute('aria-pressed', 'false');
  expect((await lab.status()).mode, 'Esc was for the inspector').toBe('explore');
  await page.keyboard.press('Escape');
  await expect.poll(async () => (await lab.status()).mode, 'and then it stops').toBe('manual');
});

/** Chooses a format, and saves. */
async function save(lab: Lab, format: string): Promise<void> {
  await lab.save(format);
}
