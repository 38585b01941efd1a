// Every setting with its unit, range and meaning; changed at once or on restart; found by search;
// refused in words if out of range.
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

async function search(lab: Lab, words: string): Promise<void> {
  await lab.show('settings');
  await lab.at('settings-search').fill(words);
}

test('a setting that acts at once changes the run that goes on', async ({ lab }) => {
  await lab.open();
  await lab.enter('arena', '4');
  await lab.watch((s) => s.features, 'walls are known').toBeGreaterThan(4);
  await search(lab, 'shortest line');
  const field = lab.at('s-lines.min_length');
  await expect(field).toHaveValue('0.5');
  await expect(lab.page.locator('slam-settings')).toContainText('0 to 5 m, default 0.5 m');
  const { scans } = await lab.status();
  await field.fill('5');
  await field.blur();
  await expect.poll(async () => (await lab.state()).setup.settings).toEqual({ 'lines.min_length': 5 });
  expect((await lab.status()).scans, 'the same run').toBeGreaterThanOrEqual(scans);
  // The arena is 5 m x 4 m: no line of 5 m is ever found again.
  await lab.watch((s) => s.scans, 'it goes on').toBeGreaterThan(scans + 10);
  await lab.page.evaluate(() => (document.querySelector('slam-settings') as HTMLElement).scrollTop);
  await lab.at('settings-reset').click();
  await expect(field).toHaveValue('0.5');
});

test('a setting of the sensor waits for a restart, says so, and then holds', async ({ lab }) => {
  await lab.open();
  await lab.enter('arena', '4');
  await search(lab, 'farthest range lidar');
  const field = lab.at('s-lidar.max_range');
  await field.fill('1');
  await field.blur();
  await expect(lab.at('settings-wait')).toContainText('Farthest range waits for a restart');
  await lab.at('settings-restart').click();
  await expect(lab.at('settings-wait')).toBeHidden();
  await lab.watch((s) => s.scans, 'the new run scans').toBeGreaterThan(5);
  await lab.pause();
  expect((await lab.status()).knownArea, 'a robot that sees 1 m knows little at first').toBeLessThan(6);
});

test('what is out of range is refused in words, and the field says what holds', async ({ lab }) => {
  await lab.open();
  await search(lab, 'gate of a match');
  const field = lab.at('s-ekf.gate');
  await field.fill('-3');
  await field.blur();
  await expect(lab.page.locator('slam-toast')).toContainText('Gate of a match is a number from 0.1 to 100 d²; it stays 9.21');
  await expect(field).toHaveValue(/^9\.21/);
  await search(lab, 'no such thing at all');
  await expect(lab.page.locator('slam-settings')).toContainText('No setting matches');
});

test('limits that are round in radians are told by three digits, and typed as told they hold', async ({ lab }) => {
  await lab.open();
  await search(lab, 'glass returns');
  const field = lab.at('s-lidar.glass_angle');
  await expect(lab.page.locator('slam-settings')).toContainText('0 to 90 °, default 8.59 °');
  await expect(field).toHaveValue('8.59');
  await search(lab, 'flattest view');
  await expect(lab.page.locator('slam-settings')).toContainText('0.573 to 85.9 °, default 9.74 °');
  const angle = lab.at('s-lines.grazing_angle');
  // A little more than the true limit: it counts as that limit.
  await angle.fill('0.573');
  await angle.blur();
  await expect.poll(async () => (await lab.state()).setup.settings).toEqual({ 'lines.grazing_angle': 0.01 });
  await angle.fill('85.94367');
  await angle.blur();
  await expect.poll(async () => (await lab.state()).setup.settings).toEqual({ 'lines.grazing_angle': 1.5 });
  await expect(angle).toHaveValue('85.9');
  await angle.fill('86');
  await angle.blur();
  await lab.says('Flattest view of a wall is a number from 0.573 to 85.9 °; it stays 85.9 °');
});

test('a preset sets its group, and each setting can go back', async ({ lab }) => {
  await lab.open();
  await lab.show('settings');
  const group = lab.at('settings-Odometry');
  await group.locator('summary').click();
  await group.getByRole('button', { name: 'Constant Q (TDK 2016)' }).click();
  await expect(lab.at('s-odometry.model')).toHaveValue('1');
  await expect.poll(async () => (await lab.state()).setup.settings).toEqual({ 'odometry.model': 1 });
  await group.getByRole('button', { name: /^Odometry noise: back to/ }).click();
  await expect(lab.at('s-odometry.model')).toHaveValue('0');
  await expect.poll(async () => (await lab.state()).setup.settings).toEqual({});
});

test('settings fit the page', { tag: '@phone' }, async ({ lab, page }) => {
  await lab.open();
  await search(lab, 'σ');
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
});
