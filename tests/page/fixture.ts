// What every test of the page gets: a page that fails the test when anything went wrong inside it.
//
// Errors on the console, uncaught exceptions, failed requests and refusals by the content security
// policy all count; a test that provokes one on purpose empties `problems` before it ends.
import { test as base, expect } from '@playwright/test';
import { Bridge } from './bridge.ts';
import { Lab } from './lab.ts';

export { expect };

/** What the map is drawn with: Canvas 2D, whatever graphics card the machine of the tests has. */
export type DrawnWith = 'auto' | 'webgl2' | 'canvas';

export const test = base.extend<{ problems: string[]; lab: Lab; bridges: void; firstVisit: boolean; isKept: boolean; drawnWith: DrawnWith }>({
  /** Whether nobody was here before: then the page shows what SLAM is, by a run of its own. */
  firstVisit: [false, { option: true }],
  /** Whether the browser may keep the page for when there is no server. */
  isKept: [false, { option: true }],
  drawnWith: ['canvas', { option: true }],
  lab: async ({ page, firstVisit, drawnWith }, use) => {
    // What is chosen later stays.
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
    // Who leaves a page leaves its icon, which browsers fetch last.
    const isIcon = (url: string): boolean => url.endsWith('/icon.svg');
    page.on('console', (message) => {
      if (message.type() === 'error' && !isIcon(message.location().url)) problems.push(`console: ${message.text()}`);
    });
    page.on('pageerror', (error) => problems.push(`exception: ${error.stack ?? error.message}`));
    page.on('requestfailed', (request) => {
      const why = request.failure()?.errorText ?? '';
      // Who leaves a page, or loads it again, leaves what was still on its way.
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
