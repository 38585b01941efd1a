// Doors of a world: a button for each, one for all, and a click on the map; what the robot then
// observes is its own business.
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

/** Whether each door is open; a door has six numbers. */
async function open(lab: Lab): Promise<boolean[]> {
  const { doors } = await lab.state();
  return Array.from({ length: doors.length / 6 }, (_, i) => doors[6 * i + 4] === 1);
}

async function middle(lab: Lab, door: number): Promise<[number, number]> {
  const [x1 = NaN, y1 = NaN, x2 = NaN, y2 = NaN] = (await lab.state()).doors.slice(6 * door);
  return [(x1 + x2) / 2, (y1 + y2) / 2];
}

test('doors are shut and opened by button and by a click on the map', { tag: '@phone' }, async ({ lab, hasTouch }) => {
  await lab.open();
  await lab.enter('doors', '4');
  await lab.at('mode-manual').click();
  await lab.standsStill();
  expect(await open(lab)).toEqual([true, true, true, true]);
  await lab.show('run');
  await expect(lab.at('door-1')).toHaveText('2: open');
  await lab.at('door-1').click();
  await expect(lab.at('door-1')).toHaveText('2: shut');
  await expect.poll(() => open(lab)).toEqual([true, false, true, true]);
  await lab.at('doors-all').click();
  await expect.poll(() => open(lab)).toEqual([false, false, false, false]);
  await lab.at('doors-all').click();
  await expect.poll(() => open(lab)).toEqual([true, true, true, true]);
  // A click still acts on a door when clicks also choose rooms.
  await lab.show('layers');
  await lab.at('layer-rooms').check();
  await lab.hidePanels();
  const [x, y] = await middle(lab, 0);
  await lab.pointAt(x, y, hasTouch);
  await expect.poll(() => open(lab)).toEqual([false, true, true, true]);
  // The click acted on the door and set no goal.
  expect((await lab.status()).mode).toBe('manual');
  await lab.pointAt(x, y, hasTouch);
  await expect.poll(() => open(lab)).toEqual([true, true, true, true]);
});

test('a door that is opened once all is explored is offered to the robot, and it looks behind', async ({ lab }) => {
  test.setTimeout(240_000);
  await lab.open();
  await lab.enter('doors', '20');
  await lab.show('run');
  await lab.at('doors-all').click();
  await expect.poll(() => open(lab)).toEqual([false, false, false, false]);
  await lab.watch((s) => s.finished, 'it maps what it can reach', 120_000).toBe(true);
  const { explored } = await lab.status();
  expect(explored).toBeLessThan(0.9);
  await lab.at('door-0').click();
  await expect(lab.at('toast')).toContainText('Door 1 is open now');
  for (const door of [1, 2, 3]) await lab.at(`door-${door}`).click();
  await expect(lab.at('toast')).toContainText('4 doors are open now');
  await lab.at('toast-way').click();
  await lab.watch((s) => s.mode, 'it goes to look').toBe('goto');
  await lab.watch((s) => s.mode, 'and explores', 120_000).toBe('explore');
  await lab.watch((s) => s.finished, 'to the end', 180_000).toBe(true);
  expect((await lab.status()).explored).toBeGreaterThan(0.95);
});

test('a world without doors has no buttons for them', async ({ lab }) => {
  await lab.open();
  await lab.enter('arena', '4');
  await lab.show('run');
  await expect(lab.at('doors-all')).toBeHidden();
  await expect(lab.at('door-0')).toHaveCount(0);
});

test('a beam under the pointer tells its range, its σ and its quality', async ({ lab, page }) => {
  await lab.open();
  await lab.enter('doors', '4');
  await lab.at('mode-manual').click();
  await lab.standsStill();
  await lab.pause();
  await lab.stillCamera();
  const [screenX, screenY] = await page.evaluate(() => {
    const { hit, toScreen } = (window as unknown as { slamlab: { hit(beam: number): [number, number]; toScreen(x: number, y: number): [number, number] } }).slamlab;
    return toScreen(...hit(0));
  });
  const box = (await lab.at('map').boundingBox())!;
  await page.mouse.move(box.x + screenX, box.y + screenY);
  await expect(lab.at('hover')).toHaveText(/beam \d+\.\d\d ± 0\.\d\d m, quality \d+/);
});
