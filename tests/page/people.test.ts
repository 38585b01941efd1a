// Walkers are tracked, taken out of pose and map if asked for, and shown so.
import { expect, test } from './fixture.ts';

interface Figures { slamlab: { tracks: { id: number; x: number; y: number; motion: string }[]; takenOut: number } }

test('people who walk are followed, and their points kept out where that is asked for', async ({ lab, page }) => {
  await lab.open();
  await lab.enter('crowd', '2');
  await lab.show('run');
  await lab.at('method').selectOption('scan-matching');
  const moving = (): Promise<number> => page.evaluate(() => (window as unknown as Figures).slamlab.tracks.filter((track) => track.motion === 'moving').length);
  const takenOut = (): Promise<number> => page.evaluate(() => (window as unknown as Figures).slamlab.takenOut);
  await lab.show('layers');
  await expect(lab.at('layer-tracks')).toBeChecked();
  await expect.poll(moving, 'ten people walk in the hall').toBeGreaterThan(1);
  expect(await takenOut()).toBe(0);
  await lab.show('settings');
  await lab.at('settings-search').fill('out of pose and map');
  await lab.at('s-moving.keeps_out').check();
  await expect.poll(takenOut, 'beams end on them').toBeGreaterThan(3);
  await lab.at('s-moving.keeps_out').uncheck();
  await expect.poll(takenOut, 'all of the scan is used').toBe(0);
  await lab.at('settings-search').fill('follow what moves');
  await lab.at('s-moving.on').uncheck();
  await expect.poll(moving, 'nobody is looked for').toBe(0);
});
