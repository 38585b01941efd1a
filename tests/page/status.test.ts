// The current figures: each on one line, at every size of the page.
import { expect, test } from './fixture.ts';

test('every figure keeps to its line, also an uncertain heading', { tag: '@phone' }, async ({ lab }) => {
  await lab.open();
  await lab.show('status');
  const one = (await lab.at('distance').boundingBox())!.height;
  await expect(lab.at('heading-error')).toHaveText(/^\d+\.\d° \(3σ \d+\.\d°\)$/);
  for (const figure of ['time', 'pace', 'features', 'known-area', 'contacts', 'scans', 'heading-error', 'hash']) {
    expect((await lab.at(figure).boundingBox())!.height, figure).toBeLessThan(1.5 * one);
  }
  // By odometry alone a turning robot becomes less and less certain of its heading. Only that
  // method goes on regardless.
  await lab.show('run');
  await lab.at('method').selectOption('odometry');
  await lab.speed('Infinity');
  await lab.watch((s) => 3 * Math.sqrt(s.covHeading), 'the heading is lost', 45_000).toBeGreaterThan(Math.PI);
  await lab.pause();
  await lab.show('status');
  await expect(lab.at('heading-error')).toContainText('(3σ over 180°)');
});

test('what steers fits beside the panels of a tablet that is held upright', async ({ lab, page }) => {
  await page.setViewportSize({ width: 768, height: 1024 });
  await lab.open();
  const [stage, transport] = await Promise.all(['#stage', 'slam-transport'].map((part) => page.locator(part).boundingBox()));
  expect(transport!.x, 'to the left').toBeGreaterThanOrEqual(8);
  expect(stage!.x + stage!.width - transport!.x - transport!.width, 'to the right').toBeGreaterThanOrEqual(8);
});
