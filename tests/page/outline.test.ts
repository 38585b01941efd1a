// A robot that is not a disc: its rectangle fits through doors that its outer disc does not.
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

/** In `doors`, whose doors are 0.9 m wide, a robot of 1.1 m by 0.5 m: its circumscribed disc is
    1.21 m wide. */
async function longRobot(lab: Lab): Promise<void> {
  await lab.open();
  await lab.enter('doors', '4');
  await lab.show('settings');
  await lab.at('settings-search').fill('rectangle');
  await lab.at('s-body.shape').selectOption({ label: 'rectangle' });
  for (const [key, value] of [['s-body.length', '110'], ['s-body.width', '50']] as const) {
    await lab.at(key).fill(value);
    await lab.at(key).blur();
  }
  await lab.at('settings-restart').click();
  await lab.watch((s) => s.isRectangle && s.halfLength, 'the robot has its new body').toBeCloseTo(0.55, 6);
  await lab.hidePanels();
}

test('the planner lab asks the outline too, and it alone finds the way through the door', async ({ lab, isMobile }) => {
  test.setTimeout(120_000);
  await longRobot(lab);
  await lab.pause();
  await lab.show('paths');
  await lab.at('contest-seconds').selectOption('3');
  // Through the door in the wall to the right; the map's frame begins at (1, 1) of the world.
  await lab.pointAt(3.4, 1.1, !!isMobile);
  await expect(lab.at('contest-outline')).toHaveAttribute('data-over', 'true', { timeout: 60_000 });
  await expect(lab.at('contest-again')).toBeVisible({ timeout: 60_000 });
  const length = (planner: string) => lab.at(`contest-${planner}`).locator('td').nth(1);
  expect(Number(await length('outline').innerText())).toBeGreaterThan(3);
  for (const disc of ['rrt-connect', 'theta-star', 'visibility']) await expect(length(disc)).toHaveText('no way, proved');
  await expect(lab.at('contest-outline-note')).toContainText('all others for the disc around it, 1.21 m wide');
});

test('it drives through that door, and its rectangle touches nothing', async ({ lab, isMobile }) => {
  test.setTimeout(180_000);
  await longRobot(lab);
  await lab.at('mode-goto').click();
  await lab.pointAt(3.4, 1.1, !!isMobile);
  await lab.watch((s) => s.mode, 'it is sent').toBe('goto');
  await lab.speed('20');
  await lab.watch((s) => s.finished, 'the errand ends', 120_000).toBe(true);
  const { reason, x, contacts } = await lab.status();
  expect(reason).toContain('goal reached');
  expect(x).toBeGreaterThan(3);
  expect(contacts).toBe(0);
});
