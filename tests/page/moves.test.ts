// The robot steps 20 times a second and glides on the screen between two computed states.
import { expect, test } from './fixture.ts';

test('between two steps the robot glides, and never runs ahead of what is known', async ({ lab, page }) => {
  await lab.open();
  await lab.speed('0.25');
  await lab.watch((s) => s.distance, 'it drives').toBeGreaterThan(0.1);
  const seen = await page.evaluate(
    () =>
      new Promise<{ drawn: number; newest: number; x: number; y: number }[]>((resolve) => {
        const pictures: { drawn: number; newest: number; x: number; y: number }[] = [];
        const look = (): void => {
          const { drawn, status } = (window as unknown as { slamlab: { drawn: { time: number; x: number; y: number }; status: { time: number } } }).slamlab;
          pictures.push({ drawn: drawn.time, newest: status.time, x: drawn.x, y: drawn.y });
          if (pictures.length < 60) requestAnimationFrame(look);
          else resolve(pictures);
        };
        requestAnimationFrame(look);
      }),
  );
  const steps = new Set(seen.map((p) => p.newest)).size;
  expect(new Set(seen.map((p) => p.drawn)).size, 'more pictures than steps').toBeGreaterThan(2 * steps);
  for (const [i, picture] of seen.entries()) {
    expect(picture.drawn, 'time does not run back').toBeGreaterThanOrEqual(seen[Math.max(i - 1, 0)]!.drawn);
    expect(picture.newest - picture.drawn, 'nothing is predicted').toBeGreaterThanOrEqual(-1e-9);
    expect(picture.newest - picture.drawn, 'a step late at most, and a picture').toBeLessThan(0.05 + 0.1);
  }
});

test('a paused robot is drawn where it is', async ({ lab, page }) => {
  await lab.open();
  await lab.watch((s) => s.distance, 'it drives').toBeGreaterThan(0.1);
  await lab.pause();
  const same = () => page.evaluate(() => {
    const { drawn, status } = (window as unknown as { slamlab: { drawn: Record<string, number>; status: Record<string, number> } }).slamlab;
    return ['time', 'x', 'y', 'heading'].every((key) => drawn[key] === status[key]);
  });
  await expect.poll(same).toBe(true);
});

test('the log tells an exploration as a story, not leg by leg', async ({ lab }) => {
  await lab.open();
  await lab.enter('arena');
  await lab.watch((s) => s.finished, 'exploration ends by itself', 60_000).toBe(true);
  await lab.show('log');
  const entries = await lab.at('log').locator('li').allInnerTexts();
  expect(entries.filter((text) => /Heads for a frontier/.test(text)), 'one line for all legs').toHaveLength(1);
  expect(entries.some((text) => /\d\d % of what can be reached is known, after [\d.]+ m/.test(text)), 'how far it is').toBe(true);
  expect(entries[0], 'the newest first').toMatch(/explored/i);
  expect(entries.at(-1)).toMatch(/wakes up in Arena: walls and boxes/);
  expect(entries.length).toBeLessThan(12);
});
