// A robot that is carried elsewhere by the page's button: it shows where it may be, reports that
// its pose is unreliable, and localises itself again.
import { expect, test } from './fixture.ts';

test('a kidnapped robot shows where it may be, and says so, until it is found again', async ({ lab, page }) => {
  test.setTimeout(180_000);
  await lab.open();
  await lab.enter('office', '4');
  await lab.show('run');
  await lab.at('method').selectOption('particle-localisation');
  await expect.poll(async () => (await lab.state()).method).toBe('particle-localisation');
  const error = (s: { x: number; y: number; truthX: number; truthY: number }): number => Math.hypot(s.x - s.truthX, s.y - s.truthY);
  await lab.watch((s) => s.localisation, 'it begins where it knows').toBe('localised');
  await lab.watch((s) => s.time, 'it is under way').toBeGreaterThan(10);
  await lab.watch(error, 'and is right').toBeLessThan(0.3);
  const hypotheses = (): Promise<number> => page.evaluate(() => (window as unknown as { slamlab: { hypotheses: number } }).slamlab.hypotheses);
  expect(await hypotheses(), 'there is one place only').toBe(0);
  await lab.show('run');
  await expect(lab.at('localisation')).toHaveText('The robot knows where it is.');
  await lab.at('kidnap').click();
  await lab.watch((s) => s.localisation, 'it notices', 60_000).not.toBe('localised');
  await expect(lab.at('localisation'), 'and says so').toHaveClass(/bad/);
  await expect(lab.at('caption')).toContainText(/Lost|Not sure where it is/);
  await lab.pause();
  await expect(lab.at('caption'), 'also while it waits').toContainText(/Paused · (lost|not sure where it is)/);
  await lab.at('play').click();
  await expect.poll(hypotheses, { message: 'several places are shown', timeout: 60_000, intervals: [50] }).toBeGreaterThan(1);
  await lab.watch((s) => s.localisation, 'it finds itself again', 120_000).toBe('localised');
  await lab.watch(error, 'where it is').toBeLessThan(0.3);
  await expect(lab.at('localisation')).toHaveText('The robot knows where it is.');
  await expect.poll(hypotheses, 'there is one place again').toBe(0);
});
