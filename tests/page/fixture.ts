// The fixture of every test of the page: a test fails if anything goes wrong inside the page.
//
// Errors on the console, uncaught exceptions, failed requests and refusals by the content security
// policy all count; a test that provokes one on purpose empties `problems` before it ends.
import { test as base, expect } from '@playwright/test';
import { Bridge } from './bridge.ts';
import { Lab } from './lab.ts';

export { expect };

/** What the map is drawn with: Canvas 2D, whatever graphics card the test machine has. */
export type DrawnWith = 'auto' | 'webgl2' | 'canvas';

export const test = base.extend<{ problems: string[]; lab: Lab; bridges: void; firstVisit: boolean; isKept: boolean; drawnWith: DrawnWith }>({
  /** Whether this is a first visit: then the page begins with the tour and a run of its own. */
  firstVisit: [false, { option: true }],
  /** Whether the browser may keep the page for use without a server. */
  isKept: [false, { option: true }],
  drawnWith: ['canvas', { option: true }],
  lab: async ({ page, firstVisit, drawnWith }, use) => {
    // A later choice stays.
    await page.addInitScript((drawnWith) => localStorage.getItem('slamlab-drawn-with') ?? localStorage.setItem('slamlab-drawn-with', drawnWith), drawnWith);
    if (!firstVisit) await page.addInitScript(() => localStorage.setItem('slamlab-visited', '1'));
    await use(new Lab(page));
  },
  baseURL: async ({}, use) => {
    const url = process.env.SLAMLAB_URL;
    if (!url) throw new Error('SLAMLAB_URL is not set: the bridge was not started');
    await use(url);
  },
  bridges: [async ({}, use) => {
    await use();
    await Bridge.stopAll();
  }, { auto: true }],
  problems: [async ({ page, isKept }, use) => {
    // As at an address that is neither https nor this computer's own.
    if (!isKept) await page.addInitScript(() => Object.defineProperty(navigator, 'serviceWorker', { value: undefined }));
    const problems: string[] = [];
    // Leaving a page aborts the request for its icon, which browsers load last.
    const isIcon = (url: string): boolean => url.endsWith('/icon.svg');
    page.on('console', (message) => {
      if (message.type() === 'error' && !isIcon(message.location().url)) problems.push(`console: ${message.text()}`);
    });
    page.on('pageerror', (error) => problems.push(`exception: ${error.stack ?? error.message}`));
    page.on('requestfailed', (request) => {
      const why = request.failure()?.errorText ?? '';
      // Leaving or reloading a page aborts its pending requests.
      if (/ERR_ABORTED/.test(why) || (isIcon(request.url()) && /ERR_FAILED/.test(why))) return;
      problems.push(`request: ${request.url()} ${why}`);
    });
    page.on('response', (response) => {
      if (response.status() >= 400) problems.push(`response: ${response.status()} ${response.url()}`);
    });
    await use(problems);
    expect(problems, 'nothing goes wrong inside the page').toEqual([]);
  }, { auto: true }],
});
