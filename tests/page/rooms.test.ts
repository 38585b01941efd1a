// Rooms: a layer that is off until somebody wants it, a list that says what each is, and a click that chooses one.
import { expect, test } from './fixture.ts';

test('rooms are found, listed with their doors, chosen by click and by key, and saved', async ({ lab, page, isMobile }) => {
  test.setTimeout(120_000);
  await lab.open();
  const rooms = (): Promise<number> => page.evaluate(() => (window as unknown as { slamlab: { rooms: { regions: Float64Array } | null } }).slamlab.rooms?.regions.length ?? -1);
  expect(await rooms(), 'nobody looks').toBe(-1);
  await lab.speed('20');
  await lab.show('layers');
  await lab.at('layer-rooms').check();
  await lab.show('status');
  // The corridor, and the first room beside it.
  await expect(lab.at('room-1'), 'two regions').toBeVisible({ timeout: 90_000 });
  await lab.pause();
  await lab.at('room-0').focus();
  await page.keyboard.press('Enter');
  await expect(lab.at('room-details')).toContainText('Free floor');
  await expect(lab.at('room-details')).toContainText(/Door to (room|corridor) \d/);
  await page.keyboard.press('Enter');
  await expect(lab.at('room-details')).toHaveCount(0);
  const goal = (await lab.status()).goalX;
  // Where the robot began: in the corridor of `office`.
  await lab.pointAt(0.6, 0, !!isMobile);
  await expect(lab.at('room-details'), 'the corridor is chosen').toBeVisible();
  expect((await lab.status()).goalX, 'the robot is not sent there').toEqual(goal);
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  await lab.show('layers');
  await lab.at('layer-rooms').uncheck();
  expect(await rooms()).toBe(-1);
});
