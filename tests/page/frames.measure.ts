// How long the page's main thread works for each frame while a recording plays at 50 times its
// speed. `cargo xtask report page-frames` runs it and reads the figures that it writes. Chromium
// draws without a graphics card here, which counts too.
import { existsSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { expect, test } from './fixture.ts';
import { picturesDuring, quantile } from './trace.ts';

const LOG = 'intel/intel.clf';
const folder = process.env.SLAMLAB_DATA ?? fileURLToPath(new URL('../../../shared/data', import.meta.url));
const SPEED = '50';
/** How long it plays before the measurement, and how long that takes, s. */
const [BEFORE, LONG] = [10, 20];
/** The time for one frame at 60 per second, ms. */
const MOST_WORK = 1000 / 60;

test.use({ drawnWith: 'auto' });

test('the main thread works less than a picture lasts while a log plays at 50 times its speed', async ({ lab, page, browser }) => {
  test.setTimeout(180_000);
  const file = `${folder}/${LOG}`;
  test.skip(!existsSync(file), `recorded data ${LOG} is absent from ${folder}`);
  await lab.open();
  await lab.at('file').setInputFiles(file);
  await expect.poll(async () => (await lab.state()).source, { timeout: 30_000 }).toBe('replay');
  await lab.speed(SPEED);
  await page.waitForTimeout(1000 * BEFORE);
  const begin = await lab.status();
  const { work, gaps } = await picturesDuring(browser, page, () => page.waitForTimeout(1000 * LONG));
  const end = await lab.status();
  const figures = {
    report: 'page-frames',
    log: LOG,
    log_seconds_a_second: (end.time - begin.time) / LONG,
    scans: end.scans - begin.scans,
    pictures_a_second: work.length / LONG,
    milliseconds_between_pictures: { median: quantile(gaps, 0.5), p95: quantile(gaps, 0.95), most: Math.max(...gaps) },
    main_thread_milliseconds_a_picture: { median: quantile(work, 0.5), p95: quantile(work, 0.95), p99: quantile(work, 0.99), most: Math.max(...work) },
    p95_at_most: MOST_WORK,
  };
  if (process.env.SLAMLAB_FIGURES) writeFileSync(process.env.SLAMLAB_FIGURES, JSON.stringify(figures, null, 2));
  expect(work.length, 'pictures were drawn').toBeGreaterThan(10 * LONG);
  expect(quantile(work, 0.95), 'milliseconds that 95 of 100 pictures take at most').toBeLessThanOrEqual(MOST_WORK);
});
