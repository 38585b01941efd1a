// Landmarks of the filter: corners and posts besides walls, circles that grow with confidence, and
// how well they are found again over the gate.
import type { Page } from '@playwright/test';
import { expect, test } from './fixture.ts';
import { record } from './recording.ts';

interface Landmark {
  id: number;
  kind: 'wall' | 'corner' | 'post';
  confidence: number;
}

const landmarks = (page: Page): Promise<Landmark[]> => page.evaluate(() => (window as unknown as { slamlab: { landmarks: Landmark[] } }).slamlab.landmarks);
const gates = (page: Page): Promise<number> => page.evaluate(() => (window as unknown as { slamlab: { refinding: number } }).slamlab.refinding);
const rate = (text: string): number => Number(/^([\d.]+) %$/.exec(text)?.[1]);

test('corners and posts are landmarks where it is chosen, and confidence grows as they are found again', { tag: '@phone' }, async ({ lab, page }) => {
  await lab.open();
  await lab.enter('arena', '4');
  await expect.poll(async () => (await landmarks(page)).length, 'walls are landmarks').toBeGreaterThan(2);
  expect(new Set((await landmarks(page)).map((l) => l.kind)), 'by default only they').toEqual(new Set(['wall']));
  await lab.show('layers');
  await lab.at('layer-landmarks').check();
  await lab.show('settings');
  await lab.at('settings-search').fill('landmarks are');
  await lab.at('s-ekf.landmarks').selectOption({ label: 'walls, corners and posts' });
  const points = async (): Promise<Landmark[]> => (await landmarks(page)).filter((l) => l.kind !== 'wall');
  await expect.poll(async () => (await points()).length, 'points come beside the walls').toBeGreaterThan(1);
  const surest = async (): Promise<number> => Math.max(0, ...(await points()).map((l) => l.confidence));
  await expect.poll(surest, 'a point is found again and again').toBeGreaterThan(5);
  await lab.pause();
  const before = await surest();
  await lab.at('play').click();
  await expect.poll(surest, 'and its confidence goes on growing').toBeGreaterThan(before);
  await lab.pause();
  await lab.show('filter');
  await expect(lab.at('points-matched')).toHaveText(/^And \d+ corners and posts: \d+ recognised, \d+ new, \d+ not used\.$/);
});

test('how well landmarks are found again is drawn over the gate, and the gate that is set is marked', { tag: '@phone' }, async ({ lab, page }) => {
  await lab.open();
  await lab.enter('arena', '10');
  await lab.watch((s) => s.scans, 'there is something to count').toBeGreaterThan(60);
  await lab.pause();
  await lab.show('plots');
  await lab.at('refinding').scrollIntoViewIfNeeded();
  await expect(lab.at('refinding')).toBeVisible();
  await expect(lab.at('refinding-gate')).toHaveText('9.21');
  expect(rate(await lab.at('refinding-tpr').innerText()), 'walls of an arena are recognised').toBeGreaterThan(50);
  expect(rate(await lab.at('refinding-ppv').innerText()), 'and rightly').toBeGreaterThan(80);
  await expect(lab.at('refinding-fpr')).toHaveText(/^[\d.]+ %$/);
  await expect(lab.at('refinding-acc')).toHaveText(/^[\d.]+ %$/);
  const curve = await lab.at('refinding').locator('polyline').getAttribute('points');
  const places = curve!.split(' ').map((place) => place.split(',').map(Number) as [number, number]);
  expect(places.length, 'a place for each gate').toBeGreaterThan(20);
  // The curve rises to the right: x are false positives; y counts from the top.
  for (const [i, [x, y]] of places.entries()) {
    const [x0, y0] = places[i - 1] ?? [0, 100];
    expect(x).toBeGreaterThanOrEqual(x0);
    expect(y).toBeLessThanOrEqual(y0);
  }
  const wide = rate(await lab.at('refinding-tpr').innerText());
  await lab.show('settings');
  await lab.at('settings-search').fill('gate of a match');
  await lab.at('s-ekf.gate').fill('0.5');
  await lab.at('s-ekf.gate').press('Enter');
  await lab.show('plots');
  await expect(lab.at('refinding-gate')).toHaveText('0.50');
  expect(rate(await lab.at('refinding-tpr').innerText()), 'a smaller gate finds less').toBeLessThan(wide);
});

test('a recording has no truth, so there is nothing to judge by', async ({ lab, page }) => {
  await lab.open();
  await lab.show('run');
  await lab.at('file').setInputFiles({ name: 'laps.log', mimeType: 'text/plain', buffer: Buffer.from(record(120).text) });
  await expect.poll(async () => (await lab.state()).source).toBe('replay');
  await lab.at('method').selectOption('line-ekf');
  await expect.poll(async () => (await lab.state()).method).toBe('line-ekf');
  await lab.watch((s) => s.finished && s.features > 3, 'it is mapped, with walls').toBe(true);
  expect((await landmarks(page)).length, 'which are landmarks').toBeGreaterThan(3);
  expect(await gates(page)).toBe(0);
  await lab.show('plots');
  await expect(lab.at('refinding')).toHaveCount(0);
});
