// A hobbyist with a robot of their own behind a bridge, in the room with a phone: watches, takes
// the controls, drives by thumb, lets it explore, stops it, and takes the map home.
import { mkdtemp, readFile, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { Bridge } from './bridge.ts';
import { expect, test } from './fixture.ts';
import { fits, pushUntil } from './hands.ts';

test('a hobbyist drives a robot of their own from a phone', { tag: '@phone-only' }, async ({ lab, page }) => {
  test.setTimeout(240_000);
  const folder = await mkdtemp(join(tmpdir(), 'slamlab-hobby-'));
  const bridge = await Bridge.start(['--source', 'sim:arena,lidar', '--token-file', join(folder, 'token')]);
  const token = (await readFile(join(folder, 'token'), 'utf8')).trim();
  const state = () => lab.bridge();

  // The page finds the robot by itself; it shows the room, and the robot stands.
  await lab.open(`${bridge.url}#token=${token}`);
  expect((await lab.state()).source).toBe('bridge');
  await lab.watch((s) => s.scans, 'it looks around').toBeGreaterThan(3);
  await fits(page);
  const began = await lab.status();
  await lab.pointAt(began.x + 0.5, began.y, true);
  await lab.watch((s) => s.scans, 'time passes').toBeGreaterThan(began.scans + 10);
  expect((await lab.status()).distance - began.distance, 'a tap does not move what nobody armed').toBeLessThan(0.02);

  // Drive.
  await lab.at('lease').tap();
  await expect.poll(async () => (await state())?.armed, 'armed').toBe(true);
  await expect(lab.at('stick')).toBeVisible();
  const before = await lab.status();
  await pushUntil(lab.at('stick'), [0, -50], () =>
    lab.watch((s) => Math.hypot(s.x - before.x, s.y - before.y), 'it drives under the thumb').toBeGreaterThan(0.1));
  await lab.standsStill();

  // By itself, until Stop.
  const { distance } = await lab.status();
  await lab.at('mode-explore').tap();
  await lab.watch((s) => s.distance, 'it explores').toBeGreaterThan(distance + 0.3);
  await lab.at('stop').tap();
  await expect.poll(async () => (await state())?.armed, 'Stop disarms').toBe(false);
  await lab.watch((s) => s.mode, 'and its errand is over').toBe('manual');

  // The map is taken home.
  await lab.savedMap();
  await bridge.stop();
  await rm(folder, { recursive: true });
});
