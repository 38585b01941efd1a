// How long the page's main thread works for each picture while a recording plays at 50 times its
// speed. `cargo xtask report page-frames` asks for it and reads the figures that it leaves.
//
// It counts time of the processor, by Chromium's own trace, because what else runs on a machine
// takes from that of the clock. Chromium draws without a graphics card here: that counts too.
import { existsSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { expect, test } from './fixture.ts';

const LOG = 'intel/intel.clf';
const folder = process.env.SLAMLAB_DATA ?? fileURLToPath(new URL('../../../shared/data', import.meta.url));
const SPEED = '50';
/** How long it plays before it is measured, and how long that takes, s. */
const [BEFORE, LONG] = [10, 20];
/** At 60 pictures a second there is so much time for one, ms. */
const MOST_WORK = 1000 / 60;

interface TraceEvent { name: string; pid: number; tid: number; ts: number; dur?: number; tdur?: number; args: { name?: string } }

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
  await browser.startTracing(page, { categories: ['toplevel', 'devtools.timeline'] });
  await page.waitForTimeout(1000 * LONG);
  const end = await lab.status();
  const { traceEvents } = JSON.parse((await browser.stopTracing()).toString()) as { traceEvents: TraceEvent[] };
  const { work, gaps } = pictures(ofMainThread(traceEvents));
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

/** Of all threads that pages have, the one that does most. */
function ofMainThread(events: TraceEvent[]): TraceEvent[] {
  const threadOf = ({ pid, tid }: TraceEvent): string => `${pid} ${tid}`;
  const mains = events.filter((e) => e.name === 'thread_name' && e.args.name === 'CrRendererMain').map(threadOf);
  const byThread = mains.map((main) => events.filter((e) => threadOf(e) === main));
  return (byThread.sort((a, b) => b.length - a.length)[0] ?? []).sort((a, b) => a.ts - b.ts);
}

/** Work for each picture but the last, and the time to the next one, ms: a task belongs to the
    picture that began last before it ended. */
function pictures(events: TraceEvent[]): { work: number[]; gaps: number[] } {
  const begins = events.filter((e) => e.name === 'FireAnimationFrame').map((e) => e.ts);
  const work = begins.slice(1).map(() => 0);
  let picture = -1;
  for (const { ts, dur = 0, tdur = 0 } of events.filter((e) => e.name === 'ThreadControllerImpl::RunTask')) {
    while ((begins[picture + 1] ?? Infinity) <= ts + dur) picture += 1;
    if (picture >= 0 && picture < work.length) work[picture]! += tdur / 1000;
  }
  return { work, gaps: begins.slice(1).map((at, i) => (at - begins[i]!) / 1000) };
}

function quantile(values: number[], part: number): number {
  return [...values].sort((a, b) => a - b)[Math.floor(part * (values.length - 1))] ?? NaN;
}
