// The planners side by side: all get the same query, the table shows the results, and a tree is
// drawn.
import type { Page } from '@playwright/test';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

const PLANNERS = ['rrt', 'rrt-connect', 'rrt-star', 'informed-rrt-star', 'a-star', 'theta-star', 'visibility', 'rooms'];

/** Cells of a planner's row, in words. */
async function cells(lab: Lab, planner: string): Promise<string[]> {
  return lab.at(`contest-${planner}`).locator('td').allInnerTexts();
}

async function over(lab: Lab): Promise<void> {
  await expect(lab.at('contest-again'), 'it comes to an end').toBeVisible({ timeout: 60_000 });
  for (const planner of PLANNERS) await expect(lab.at(`contest-${planner}`)).toHaveAttribute('data-over', 'true');
}

/** A goal behind walls, clicked where it is drawn. */
async function ask(lab: Lab, page: Page, isTouch: boolean): Promise<void> {
  await lab.open();
  await lab.pause();
  await lab.show('paths');
  await lab.at('contest-seconds').selectOption('0.2');
  const box = await lab.at('map').boundingBox();
  expect(box).not.toBeNull();
  // In the next room to the north-east of the start of `office`; the map's frame begins at (1, 6)
  // of the world.
  await lab.pointAt(4.4, 2.6, isTouch);
  await expect(lab.at('contest-table')).toBeVisible();
  await over(lab);
}

test('all planners find the way and are held against the shortest', { tag: '@phone' }, async ({ lab, page, isMobile }) => {
  await ask(lab, page, !!isMobile);
  const { goalX } = await lab.status();
  await expect(lab.at('contest-rrt'), 'nobody has to look for the table').toBeInViewport();
  for (const planner of PLANNERS) {
    const [, length, ratio, time] = await cells(lab, planner);
    expect(Number(length), `${planner} found a way`).toBeGreaterThan(4);
    expect(Number(ratio), `${planner} is not shorter than the shortest`).toBeGreaterThanOrEqual(0.999);
    expect(time).toMatch(/ms|s/);
  }
  expect((await cells(lab, 'visibility'))[2]).toBe('1.000');
  await lab.at('contest-rrt').locator('button').click();
  await expect(lab.at('contest-rrt').locator('button')).toHaveAttribute('aria-pressed', 'true');
  await expect(page.locator('slam-contest .uplot')).toHaveCount(1);
  expect((await lab.status()).goalX, 'the robot is not sent anywhere').toEqual(goalX);
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
});

test('on the map that was learned there is no visibility graph, and the table says so', async ({ lab, page, isMobile }) => {
  await ask(lab, page, !!isMobile);
  await lab.at('contest-ground').selectOption('map');
  await expect(lab.at('contest-visibility').locator('.why')).toHaveText('needs walls', { timeout: 60_000 });
  await over(lab);
  expect(Number((await cells(lab, 'theta-star'))[1])).toBeGreaterThan(4);
});

test('a start inside of a wall is refused as what it is: the robot stands elsewhere', async ({ lab, isMobile }) => {
  await ask(lab, lab.page, !!isMobile);
  await lab.at('contest-start').click();
  await lab.pointAt(3, -0.9, !!isMobile);
  await expect(lab.at('contest-error')).toContainText(/^The start at \(3\.\d\d, -0\.\d\d\) m is inside an obstacle or enclosed/);
  await lab.at('contest-robot').click();
  await over(lab);
  await expect(lab.at('contest-error')).toHaveCount(0);
});

test('the layers say that the robot has its own plan hidden while paths are compared', async ({ lab }) => {
  await lab.open();
  await lab.pause();
  for (const name of ['path', 'rawPath', 'frontiers', 'tree']) {
    const layer = lab.at(`layer-${name}`);
    await lab.show('paths');
    await expect(layer, name).toHaveAttribute('aria-description', /Not drawn while Paths is open/);
    await lab.show('plots');
    await expect(layer, name).not.toHaveAttribute('aria-description', /Not drawn/);
  }
});

test('a goal inside of a wall is refused with the reason', async ({ lab, isMobile }) => {
  await lab.open();
  await lab.pause();
  await lab.show('paths');
  // On the southern wall of the corridor, 0.9 m to the right of the start.
  await lab.pointAt(3, -0.9, !!isMobile);
  await expect(lab.at('contest-error')).toContainText(/goal .* inside an obstacle/);
});
