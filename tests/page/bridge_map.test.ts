// The map that the bridge itself makes: drawn beside the page's, restarted, and with a geofence
// that is drawn on it and holds the robot back.
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { behind, expect } from './robot_behind.ts';

const test = behind((folder) => ['--source', 'sim:arena,lidar', '--map', join(folder, 'flat.slamlab')]);

test('the map of the bridge is drawn where it lies, and is begun anew', async ({ lab, page, bridge, token, state }) => {
  await lab.open(`${bridge.url}#token=${token}`);
  await lab.show('run');
  await expect(lab.at('bridge-map')).toContainText('kept in flat.slamlab');
  await expect(lab.at('bridge-map')).toContainText('drawn beside');
  // Enough scans for the new map to have fewer for some seconds.
  await expect.poll(async () => (await state())?.map?.scans ?? 0, { timeout: 30_000 }).toBeGreaterThan(25);
  await expect.poll(async () => (await state())?.map?.revision ?? 0).toBeGreaterThan(0);
  const before = (await state())!.map!;
  // Both began where the robot stands.
  const [x, y, heading] = before.place!;
  expect(Math.hypot(x, y)).toBeLessThan(0.1);
  expect(Math.abs(heading)).toBeLessThan(0.05);
  await expect(lab.at('geofence')).toContainText('may go everywhere');

  page.once('dialog', (dialog) => dialog.accept());
  await lab.at('bridge-map-reset').click();
  await expect.poll(async () => (await state())?.map?.scans ?? Infinity, { intervals: [100] }).toBeLessThan(before.scans);
  await expect.poll(async () => (await state())?.map?.revision ?? 0).toBeGreaterThan(before.revision);
});

test('a geofence is drawn on the map, holds the robot back, and says so', async ({ lab, page, bridge, folder, token, state, isMobile }) => {
  await lab.open(`${bridge.url}#token=${token}`);
  await expect.poll(async () => (await state())?.map?.place ?? null).not.toBeNull();
  await lab.show('run');
  await lab.at('geofence-draw').click();
  await expect(lab.at('geofence-set')).toBeEnabled();
  await lab.hidePanels();
  const square = [[-0.7, -0.7], [0.7, -0.7], [0.7, 0.7], [-0.7, 0.7]] as const;
  for (const [x, y] of square) await lab.pointAt(x, y, isMobile);
  await lab.show('run');
  await expect(lab.at('geofence-editor')).toContainText('4 corners');
  // One corner too many, by keyboard, and back.
  await lab.at('map').focus();
  await page.keyboard.press('Enter');
  await expect(lab.at('geofence-editor')).toContainText('5 corners');
  await lab.at('geofence-undo').click();
  await lab.at('geofence-close').click();
  await expect(lab.at('geofence-editor')).toContainText('One area');
  await lab.at('geofence-set').click();
  await expect(lab.at('geofence')).toContainText('within');
  const [zone] = (await state())!.map!.geofence.zones;
  expect(zone!.keepOut).toBe(false);
  for (const [i, [x, y]] of square.entries()) {
    const corner = zone!.corners[i]!;
    expect(Math.hypot(corner[0] - x, corner[1] - y)).toBeLessThan(0.1);
  }
  // The file is beside the map.
  await expect.poll(() => readFile(join(folder, 'flat.geofence.json'), 'utf8').catch(() => '')).toContain('keep-in');

  await lab.at('lease').click();
  await expect.poll(async () => (await state())?.armed).toBe(true);
  await lab.hidePanels();
  await lab.at('map').focus();
  await page.keyboard.down('ArrowUp');
  await expect.poll(async () => (await state())?.map?.fenceState, { timeout: 30_000 }).toBe('held');
  await page.keyboard.up('ArrowUp');
  const { x, y } = await lab.status();
  expect(Math.max(Math.abs(x), Math.abs(y))).toBeLessThan(0.7);
  expect((await state())?.armed, 'it may be driven back').toBe(true);
  await page.keyboard.down('ArrowDown');
  await expect.poll(async () => {
    const { x: nowX, y: nowY } = await lab.status();
    return Math.hypot(nowX - x, nowY - y);
  }, { timeout: 30_000 }).toBeGreaterThan(0.15);
  await page.keyboard.up('ArrowDown');
  await lab.show('run');
  await expect(lab.at('geofence')).toContainText('within');
});
