// Home again after an exploration: the page says so on the way, and home is where the robot began,
// even in a map with another frame.
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

/** A flat of two rooms, 5 m x 4 m, whose frame begins seven metres away from it. */
const moved = Buffer.from(`<svg xmlns="http://www.w3.org/2000/svg" data-metres-per-unit="1">
  <polygon points="7,7 12,7 12,11 7,11" fill="none" stroke="black"/>
  <path d="M9.5,7v1.5m0 1v1.5" stroke="black"/>
  <circle id="start" cx="8" cy="9" r=".1"/></svg>`);

async function comesHome(lab: Lab): Promise<void> {
  await lab.show('settings');
  await lab.at('settings-search').fill('comes home');
  await lab.at('s-explore.return_home').check();
  await expect.poll(async () => (await lab.state()).setup.settings).toEqual({ 'explore.return_home': 1 });
  await lab.hidePanels();
}

async function isHome(lab: Lab): Promise<void> {
  await lab.watch((s) => s.finished, 'it ends by itself', 90_000).toBe(true);
  const status = await lab.status();
  expect(status.reason).toMatch(/^explored: .*; home again$/);
  await expect(lab.at('caption')).toContainText('home again');
  expect(status.distance).toBeGreaterThan(3);
}

test('all explored, it says that it drives home, and does', async ({ lab }) => {
  test.setTimeout(120_000);
  await lab.open();
  await lab.enter('arena', '4');
  await comesHome(lab);
  await expect(lab.at('caption')).toContainText(/all is explored, drives home, \d+\.\d\sm to the/, { timeout: 60_000 });
  await isHome(lab);
  await lab.show('log');
  await expect(lab.at('log')).toContainText('All is explored: drives home to (0.00, 0.00) m');
  await expect(lab.at('log')).not.toContainText('Heads for a frontier at (0.00, 0.00) m');
  const { truthX, truthY } = await lab.status();
  expect(Math.hypot(truthX, truthY), 'where it began').toBeLessThan(0.15);
});

test('in a map whose frame begins elsewhere, home is where the robot was put into it', async ({ lab }) => {
  test.setTimeout(120_000);
  await lab.open();
  await comesHome(lab);
  await lab.show('run');
  await lab.at('file').setInputFiles({ name: 'moved.svg', mimeType: 'image/svg+xml', buffer: moved });
  await expect.poll(async () => (await lab.state()).title).toBe('moved.svg');
  await lab.showMaps();
  await lab.at('prior-map-file').setInputFiles({ name: 'map.svg', mimeType: 'image/svg+xml', buffer: moved });
  await expect(lab.at('prior-map-name')).toContainText('map.svg');
  await lab.speed('Infinity');
  await isHome(lab);
  const { truthX, truthY } = await lab.status();
  expect(Math.hypot(truthX, truthY), 'where it began').toBeLessThan(0.15);
});
