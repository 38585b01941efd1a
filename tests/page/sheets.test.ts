// The sheets of a phone: a swipe down closes them, the page itself never moves, and the map stays
// visible.
import type { CDPSession, Page } from '@playwright/test';
import { Bridge } from './bridge.ts';
import { expect, test } from './fixture.ts';

/** A touch that moves from one height to another. */
async function swipe(touch: CDPSession, x: number, from: number, to: number): Promise<void> {
  const STEPS = 12;
  const at = (step: number): { touchPoints: { x: number; y: number }[] } => ({ touchPoints: [{ x, y: from + ((to - from) * step) / STEPS }] });
  await touch.send('Input.dispatchTouchEvent', { type: 'touchStart', ...at(0) });
  for (let step = 1; step <= STEPS; step += 1) await touch.send('Input.dispatchTouchEvent', { type: 'touchMove', ...at(step) });
  await touch.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
}

test('a swipe up scrolls a sheet, a swipe down brings it back and then shuts it', { tag: '@phone-only' }, async ({ lab, page }) => {
  await lab.open();
  const touch = await page.context().newCDPSession(page);
  await lab.showMaps();
  const sheet = page.locator('#run-panel');
  await sheet.evaluate((panel) => (panel.scrollTop = 0));
  const scrolled = (): Promise<number> => sheet.evaluate((panel) => panel.scrollTop);
  const { y } = (await sheet.boundingBox())!;
  await swipe(touch, 200, y + 300, y + 60);
  await expect.poll(scrolled, 'it scrolls').toBeGreaterThan(100);
  await swipe(touch, 200, y + 60, y + 500);
  await expect.poll(scrolled, 'and comes back').toBe(0);
  await expect(sheet, 'what scrolls is not shut by that').toBeVisible();
  await swipe(touch, 200, y + 12, y + 40);
  await expect(sheet, 'nor by a twitch').toBeVisible();
  expect((await sheet.boundingBox())!.y, 'it stands where it stood').toBe(y);
  await swipe(touch, 200, y + 12, y + 160);
  await expect(sheet).toBeHidden();
  await expect(lab.at('tab-run')).toHaveAttribute('aria-pressed', 'false');
});

test('a swipe down that nothing takes up does not reload the page', { tag: '@phone-only' }, async ({ lab, page }) => {
  await lab.open();
  await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(3);
  // What a browser does with the rest of a swipe is visible only in its own frame; the page tells
  // it to do nothing.
  for (const part of ['html', 'body']) expect(await page.locator(part).evaluate((element) => getComputedStyle(element).overscrollBehaviorY), part).toBe('none');
  const touch = await page.context().newCDPSession(page);
  const { scans } = await lab.status();
  for (const [from, to] of [[30, 600], [300, 700], [800, 300]] as const) {
    await swipe(touch, 200, from, to);
    expect(await page.evaluate(() => [scrollX, scrollY, document.querySelector('main')!.getBoundingClientRect().top]), `${from} to ${to}`).toEqual([0, 0, 54]);
  }
  await lab.watch((s) => s.scans, 'the same run goes on').toBeGreaterThan(scans);
});

/** Gap between the sheet and the top of the steering controls, px. */
async function gap(page: Page, panel: string): Promise<number> {
  const sheet = (await page.locator(panel).boundingBox())!;
  const above = await page.evaluate(() => {
    const steers = [...document.querySelectorAll<HTMLElement>('slam-cycle, slam-timeline, slam-transport')].filter(({ offsetHeight }) => offsetHeight > 0);
    return Math.min(...steers.map((part) => part.getBoundingClientRect().top));
  });
  return Math.abs(sheet.y + sheet.height - above);
}

test('sheets stand on what steers, and leave the map in sight', { tag: '@phone-only' }, async ({ lab, page }) => {
  await lab.open();
  for (const [tab, panel] of [['run', '#run-panel'], ['plots', '#plots-panel'], ['status', '#status-panel']] as const) {
    await lab.show(tab);
    await expect.poll(() => gap(page, panel), panel).toBeLessThanOrEqual(1);
  }
  await page.setViewportSize({ width: 360, height: 844 });
  await lab.show('run');
  expect(await page.locator('#run-panel').evaluate((panel) => panel.scrollWidth - panel.clientWidth), 'nothing sticks out of it').toBe(0);
  const [sheet, restart] = await Promise.all([page.locator('#run-panel'), lab.at('restart')].map((part) => part.boundingBox()));
  expect(restart!.x + restart!.width, 'nor into its margin').toBeLessThanOrEqual(sheet!.x + sheet!.width - 15);
  await lab.show('status');
  expect((await page.locator('#status-panel').boundingBox())!.y, 'a fifth of the height is map').toBeGreaterThan(54 + 844 / 5);
  await page.keyboard.press('4');
  await expect.poll(() => gap(page, '#status-panel'), 'in the cycle').toBeLessThanOrEqual(1);
});

test('so they do with a robot that has no timeline', { tag: '@phone-only' }, async ({ lab, page }) => {
  const bridge = await Bridge.start(['--source', 'sim:office,lidar']);
  await lab.open(bridge.url);
  await lab.show('run');
  await expect.poll(() => gap(page, '#run-panel')).toBeLessThanOrEqual(1);
  await bridge.stop();
});
