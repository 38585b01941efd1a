// Points of the last scan: a layer that is off by default, and settings that choose the kinds to
// look for.
import { expect, test } from './fixture.ts';

test('corners and crossings are shown while their layer is, and only those that are looked for', async ({ lab, page }) => {
  await lab.open();
  const points = (): Promise<number> => page.evaluate(() => (window as unknown as { slamlab: { points: number } }).slamlab.points);
  expect(await points(), 'nobody looks').toBe(0);
  await lab.show('layers');
  await lab.at('layer-points').check();
  await expect.poll(points, 'the robot stands in an office').toBeGreaterThan(3);
  await lab.show('settings');
  await lab.at('settings-search').fill('look for');
  for (const kind of ['corners', 'crossings', 'spikes', 'circles']) await lab.at(`s-features.${kind}`).uncheck();
  await expect.poll(points, 'nothing is looked for any more').toBe(0);
});
