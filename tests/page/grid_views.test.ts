// The views of the grid: certainty, three tones, and fields with a scale in metres.
import { expect, test } from './fixture.ts';

test('fields of the grid are shown, read out under the pointer, and explained by a scale', { tag: '@phone' }, async ({ lab, page, hasTouch }) => {
  await lab.open();
  await lab.enter('arena', '4');
  await lab.watch((s) => s.distance, 'there is a map').toBeGreaterThan(0.3);
  await lab.at('mode-manual').click();
  await lab.standsStill();
  await lab.show('layers');
  await expect(lab.at('grid-scale'), 'the plain grid needs no scale').toHaveCount(0);
  const { x, y } = await lab.status();
  const { toScreen } = { toScreen: (at: [number, number]) => page.evaluate((p) => (window as unknown as { slamlab: { toScreen(x: number, y: number): [number, number] } }).slamlab.toScreen(...p), at) };
  for (const [view, scale, words] of [
    ['distance', '3.2 m and more', /\d\.\d\d m to the nearest wall/],
    ['likelihood', '1: on a wall', /likelihood 0\.\d\d/],
    ['room', '0 m of room', /the robot's middle has \d\.\d\d m of room/],
  ] as const) {
    await lab.show('layers');
    await lab.at('grid-view').selectOption(view);
    await expect(lab.at('grid-scale')).toContainText(scale);
    expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
    if (hasTouch) continue;
    await lab.stillCamera();
    const [left, top] = await toScreen([x, y]);
    const box = (await lab.at('map').boundingBox())!;
    await expect.poll(async () => {
      await page.mouse.move(box.x + left + 1, box.y + top);
      await page.mouse.move(box.x + left, box.y + top);
      return lab.at('hover').textContent();
    }, { message: view, timeout: 30_000 }).toMatch(words);
  }
  await lab.show('layers');
  await lab.at('grid-view').selectOption('three');
  await expect(lab.at('grid-scale')).toHaveCount(0);
});
