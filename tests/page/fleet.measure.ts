// How many frames per second the page of the fleet draws while 10, 30 and 100 robots drive on it.
// Run it with `npx playwright test --config measure.config.ts fleet`. Chromium draws without a
// graphics card here, which counts too.
import { writeFileSync } from 'node:fs';
import { expect, test } from './fixture.ts';
import { SimulatedFleet } from './fleet.ts';
import { picturesDuring, quantile } from './trace.ts';

/** Duration of each measurement, s. */
const LONG = 10;
const LEAST_PICTURES = 30;

test('a hundred robots are drawn thirty times a second', async ({ page, browser, problems }) => {
  test.setTimeout(180_000);
  const figures = [];
  for (const count of [10, 30, 100]) {
    await SimulatedFleet.of(count, true).serve(page);
    await page.goto('fleet.html');
    await expect(page.locator('li')).toHaveCount(count);
    const { work, gaps } = await picturesDuring(browser, page, () => page.waitForTimeout(1000 * LONG));
    expect(problems).toEqual([]);
    // If the page still asked while nobody answers, the browser would report errors.
    await page.goto('about:blank');
    await page.unrouteAll({ behavior: 'ignoreErrors' });
    problems.length = 0;
    figures.push({
      robots: count, pictures_a_second: work.length / LONG,
      milliseconds_between_pictures: { median: quantile(gaps, 0.5), p95: quantile(gaps, 0.95), most: Math.max(...gaps) },
      main_thread_milliseconds_a_picture: { median: quantile(work, 0.5), p95: quantile(work, 0.95), most: Math.max(...work) },
    });
  }
  const holds = figures.every(({ pictures_a_second }) => pictures_a_second >= LEAST_PICTURES);
  if (process.env.SLAMLAB_FIGURES) writeFileSync(process.env.SLAMLAB_FIGURES, JSON.stringify({ report: 'fleet-page', holds, pictures_a_second_at_least: LEAST_PICTURES, figures }, null, 2));
  expect(holds, JSON.stringify(figures)).toBe(true);
});
