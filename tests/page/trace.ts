// What Chromium's own trace tells of the page's main thread: how long it works for each picture.
//
// It counts time of the processor, because what else runs on a machine takes from that of the
// clock.
import type { Browser, Page } from '@playwright/test';

interface TraceEvent { name: string; pid: number; tid: number; ts: number; dur?: number; tdur?: number; args: { name?: string } }

/** Of pictures that were drawn: work for each, and the time to the next one; and of each task of
    the main thread how long it worked, ms. */
export interface Pictures { readonly work: readonly number[]; readonly gaps: readonly number[]; readonly tasks: readonly number[] }

/** What the main thread did while `act` was under way. */
export async function picturesDuring(browser: Browser, page: Page, act: () => Promise<void>): Promise<Pictures> {
  await browser.startTracing(page, { categories: ['toplevel', 'devtools.timeline'] });
  await act();
  const { traceEvents } = JSON.parse((await browser.stopTracing()).toString()) as { traceEvents: TraceEvent[] };
  return pictures(ofMainThread(traceEvents));
}

/** Of all threads that pages have, the one that does most. */
function ofMainThread(events: TraceEvent[]): TraceEvent[] {
  const threadOf = ({ pid, tid }: TraceEvent): string => `${pid} ${tid}`;
  const mains = events.filter((e) => e.name === 'thread_name' && e.args.name === 'CrRendererMain').map(threadOf);
  const byThread = mains.map((main) => events.filter((e) => threadOf(e) === main));
  return (byThread.sort((a, b) => b.length - a.length)[0] ?? []).sort((a, b) => a.ts - b.ts);
}

/** Work for each picture but the last, and the time to the next one, ms: a task belongs to the
    picture that began last before it ended. */
function pictures(events: TraceEvent[]): Pictures {
  const tasks = events.filter((e) => e.name === 'ThreadControllerImpl::RunTask');
  // All that was asked for the next picture is called in one task.
  const asked = events.filter((e) => e.name === 'FireAnimationFrame').map((e) => e.ts);
  const begins = tasks.flatMap(({ ts, dur = 0 }) => asked.find((at) => at >= ts && at <= ts + dur) ?? []);
  const work = begins.slice(1).map(() => 0);
  let picture = -1;
  for (const { ts, dur = 0, tdur = 0 } of tasks) {
    while ((begins[picture + 1] ?? Infinity) <= ts + dur) picture += 1;
    if (picture >= 0 && picture < work.length) work[picture]! += tdur / 1000;
  }
  return { work, tasks: tasks.map(({ tdur = 0 }) => tdur / 1000), gaps: begins.slice(1).map((at, i) => (at - begins[i]!) / 1000) };
}

export function quantile(values: readonly number[], part: number): number {
  return [...values].sort((a, b) => a - b)[Math.floor(part * (values.length - 1))] ?? NaN;
}
