// Rooms: a layer that is off by default, a list that says what each is, and a click that chooses
// one.
import { numbered } from '../../www/src/room_numbers.ts';
import { expect, test } from './fixture.ts';

test('rooms are found, listed with their doors, chosen by click and by key, and saved', { tag: '@phone' }, async ({ lab, page, isMobile }) => {
  test.setTimeout(120_000);
  await lab.open();
  const rooms = (): Promise<number> => page.evaluate(() => (window as unknown as { slamlab: { rooms: { regions: unknown[] } | null } }).slamlab.rooms?.regions.length ?? -1);
  expect(await rooms(), 'nobody looks').toBe(-1);
  await lab.speed('20');
  await lab.show('layers');
  await lab.at('layer-rooms').check();
  await lab.watch((st) => st.time, 'when a first visitor gets the tip on driving').toBeGreaterThan(9);
  await expect(lab.at('tip'), 'a click chooses a room here').toHaveCount(0);
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
  // The start of the robot, in the corridor of `office`.
  await lab.pointAt(0.6, 0, !!isMobile);
  await expect(lab.at('room-details'), 'the corridor is chosen').toBeVisible();
  expect((await lab.status()).goalX, 'the robot is not sent there').toEqual(goal);
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  await lab.show('layers');
  await lab.at('layer-rooms').uncheck();
  expect(await rooms()).toBe(-1);
});

/** Squares with a corner at x, 0, as the module reports them, the largest first. */
function squares(...rooms: readonly (readonly [x: number, side: number])[]) {
  const sorted = [...rooms].sort((a, b) => b[1] - a[1]);
  return {
    regions: sorted.map(([x, side]) => ({
      kind: 'room' as const, area: side * side, middle: [x + side / 2, side / 2] as [number, number], width: side,
      outlines: [Float32Array.of(x, 0, x + side, 0, x + side, side, x, side)],
    })),
  };
}

test('a room keeps its number, and so its colour, when another grows larger', () => {
  const first = squares([0, 3], [10, 2]);
  const numbers = numbered(first, null, []);
  expect(numbers).toEqual([1, 2]);
  const grown = squares([0, 3], [10, 4], [20, 5]);
  const later = numbered(grown, first, numbers);
  expect(later, 'the new one, the second, the first').toEqual([3, 2, 1]);
  // The first is part of the second: the number comes from the larger of the two rooms before.
  expect(numbered(squares([-1, 15], [20, 5]), grown, later)).toEqual([2, 3]);
});
