// Settings act for every source: a live robot obeys them while it drives, a recording is mapped
// with them from the next scan on.
import { mkdtemp, readFile, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Page } from '@playwright/test';
import { Bridge } from './bridge.ts';
import { expect, test } from './fixture.ts';
import { drop, type Lab } from './lab.ts';
import { record } from './recording.ts';

/** Types a number in the unit that the page shows; `stored` is the same in SI. */
async function set(lab: Lab, key: string, value: string, stored: number): Promise<void> {
  await lab.show('settings');
  await lab.at('settings-search').fill(key);
  await lab.at(`s-${key}`).fill(value);
  await lab.at(`s-${key}`).blur();
  await expect.poll(async () => (await lab.state()).setup.settings[key]).toBe(stored);
  await lab.hidePanels();
}

/** Drives straight on until safe mode stops it. Returns where it then stands. */
async function driveToTheWall(lab: Lab, page: Page): Promise<{ x: number; y: number }> {
  await page.keyboard.down('ArrowUp');
  let before = { time: -Infinity, x: NaN, y: NaN };
  await lab.watch((s) => {
    if (s.time < before.time + 2) return false;
    const stands = Math.hypot(s.x - before.x, s.y - before.y) < 0.01;
    before = { time: s.time, x: s.x, y: s.y };
    return stands;
  }, 'it stands before the wall', 45_000).toBe(true);
  await page.keyboard.up('ArrowUp');
  return before;
}

test('a robot behind a bridge keeps as far from obstacles as the setting says', async ({ lab, page }) => {
  test.setTimeout(120_000);
  const folder = await mkdtemp(join(tmpdir(), 'slamlab-settings-'));
  const bridge = await Bridge.start(['--source', 'sim:arena,lidar', '--token-file', join(folder, 'token')]);
  try {
    const token = (await readFile(join(folder, 'token'), 'utf8')).trim();
    await lab.open(`${bridge.url}#token=${token}`);
    await set(lab, 'pilot.gap', '50', 0.5);
    await lab.at('lease').click();
    await expect(lab.at('mode-explore'), 'it is armed').toBeEnabled();
    const far = await driveToTheWall(lab, page);
    await set(lab, 'pilot.gap', '5', 0.05);
    const near = await driveToTheWall(lab, page);
    expect(Math.hypot(near.x - far.x, near.y - far.y), 'it stopped farther from the wall, as it was set').toBeGreaterThan(0.3);
    await page.keyboard.press('Escape');
  } finally {
    await bridge.stop();
    await rm(folder, { recursive: true });
  }
});

test('a recording is mapped by a changed setting from the next scan on', async ({ lab, page }) => {
  const hit = (): Promise<number> => page.evaluate(() => (window as unknown as { slamlab: { hit(beam: number): [number, number] } }).slamlab.hit(0)[0]);
  await lab.open();
  await drop(page, 'long.log', Buffer.from(record(2500).text));
  await expect.poll(async () => (await lab.state()).source, { message: 'the recording is shown', timeout: 30_000 }).toBe('replay');
  await lab.speed('2');
  await lab.watch((s) => s.scans, 'scans are mapped').toBeGreaterThan(5);
  await expect.poll(hit, 'beams end on walls').not.toBeNaN();
  const { scans } = await lab.status();
  await set(lab, 'points.max_range', '0.2', 0.2);
  await expect.poll(hit, 'nothing stands so near').toBeNaN();
  await lab.show('settings');
  await lab.at('settings-reset').click();
  await expect.poll(hit, 'and the walls are back').not.toBeNaN();
  expect((await lab.status()).scans, 'in the same run').toBeGreaterThan(scans);
});
