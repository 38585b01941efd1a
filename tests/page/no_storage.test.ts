// A browser that keeps nothing, as in a private window, or has no room: the page works without, and
// says what it cannot keep when somebody relies on it.
import type { Page } from '@playwright/test';
import { expect, test } from './fixture.ts';
import { drop, type Lab } from './lab.ts';
import { record } from './recording.ts';

/** From the next load on, every attempt to store fails, and with `isDenied` also to read. */
const withoutStorage = (page: Page, isDenied: boolean): Promise<unknown> => page.addInitScript((isDenied) => {
  const refuse = (name: string) => (): never => {
    throw new DOMException('no room', name);
  };
  if (isDenied) {
    for (const name of ['localStorage', 'sessionStorage', 'indexedDB', 'caches']) Object.defineProperty(window, name, { get: refuse('SecurityError') });
    return;
  }
  Storage.prototype.setItem = refuse('QuotaExceededError');
  IDBObjectStore.prototype.put = refuse('QuotaExceededError');
}, isDenied);

/** Opens the page without storage, and leaves the tour, with which each visit then begins. */
async function openWithout(lab: Lab, page: Page, isDenied: boolean): Promise<void> {
  await lab.open();
  await withoutStorage(page, isDenied);
  await page.reload();
  await lab.watch((s) => s.scans, 'it explores').toBeGreaterThan(1);
  const leave = lab.at('tour-leave');
  if (await leave.isVisible()) await leave.click();
}

for (const [what, isDenied] of [['forbidden', true], ['full', false]] as const) {
  test.describe(`storage that is ${what}`, () => {
    test('a run, its settings and its theme are as ever, only not kept', { tag: '@phone' }, async ({ lab, page, isMobile }) => {
      test.setTimeout(120_000);
      await openWithout(lab, page, isDenied);
      await lab.at('theme').click();
      await lab.enter('arena', '10');
      await lab.show('layers');
      await lab.at('layer-grid').click();
      if (isMobile) await lab.hidePanels();
      await lab.watch((s) => s.time, 'long enough to be kept').toBeGreaterThan(30);
      await drop(page, 'lap.clf', Buffer.from(record(120).text));
      await expect.poll(async () => (await lab.state()).title).toBe('lap.clf');
      await lab.watch((s) => s.finished, 'a recording is mapped').toBe(true);
      await page.reload();
      await lab.watch((s) => s.scans, 'and the page opens again').toBeGreaterThan(0);
    });

    test('a drawing that is not kept is said to be so', async ({ lab, page }) => {
      await openWithout(lab, page, isDenied);
      await lab.at('draw-world').click();
      await expect(lab.at('editor-name')).toHaveValue(/office/i);
      await lab.at('editor-name').fill('attic');
      await lab.at('editor-name').blur();
      await expect(lab.at('editor-note')).toContainText('has no room for the drawing, or keeps nothing');
      await page.keyboard.press('Escape');
      await expect(page.locator('slam-editor')).toHaveCount(0);
    });
  });
}
