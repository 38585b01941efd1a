// What Chromium's own trace reports of the page's main thread: how long it works for each frame.
//
// It counts processor time, because other programs on the machine affect wall-clock time.
import type { Browser, Page } from '@playwright/test';

interface TraceEvent { name: string; pid: number; tid: number; ts: number; dur?: number; tdur?: number; args: { name?: string } }

/** For drawn frames: the work for each, and the time to the next one; and the work of each task of
    the main thread, ms. */
export interface Pictures { readonly work: readonly number[]; readonly gaps: readonly number[]; readonly tasks: readonly number[] }

/** What the main thread did during `act`. */
export async function picturesDuring(browser: Browser, page: Page, act: () => Promise<void>): Promise<Pictures> {
  await browser.startTracing(page, { categories: ['toplevel', 'devtools.timeline'] });
  await act();
  const { traceEvents } = JSON.parse((await browser.stopTracing()).toString()) as { traceEvents: TraceEvent[] };
  return pictures(ofMainThread(traceEvents));
}

/** Of all threads of pages, the one that does most. */
function ofMainThread(events: TraceEvent[]): TraceEvent[] {
  const threadOf = ({ pid, tid }: TraceEvent): string => `${pid} ${tid}`;
  const mains = events.filter((e) => e.name === 'thread_name' && e.args.name === 'CrRendererMain').map(threadOf);
  const byThread = mains.map((main) => events.filter((e) => threadOf(e) === main));
  return (byThread.sort((a, b) => b.length - a.length)[0] ?? []).sort((a, b) => a.ts - b.ts);
}

/** Work for each frame but the last, and the time to the next one, ms: a task belongs to the last
    frame that began before the task ended. */
function pictures(events: TraceEvent[]): Pictures {
  const tasks = events.filter((e) => e.name === 'ThreadControllerImpl::RunTask');
  // All callbacks for the next frame are called in one task.
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
