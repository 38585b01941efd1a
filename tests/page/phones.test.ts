// What stands on a small phone: nothing lies on another thing that is to be pressed, and sentences
// are whole.
import type { Locator, Page } from '@playwright/test';
import { expect, test } from './fixture.ts';

/** How far two things lie on one another, px. */
async function overlap(one: Locator, other: Locator): Promise<number> {
  const [a, b] = await Promise.all([one.boundingBox(), other.boundingBox()]);
  if (!a || !b) throw new Error('one of them is not shown');
  const within = (from: 'x' | 'y', by: 'width' | 'height'): number => Math.min(a[from] + a[by], b[from] + b[by]) - Math.max(a[from], b[from]);
  return Math.max(0, Math.min(within('x', 'width'), within('y', 'height')));
}

for (const height of [640, 740, 844]) {
  test(`the stick lies on no tool of the map at 360 x ${height}`, { tag: '@phone-only' }, async ({ lab, page }) => {
    await page.setViewportSize({ width: 360, height });
    await lab.open();
    await lab.show('run');
    // The method with the most tools.
    await lab.at('method').selectOption('scan-matching');
    await expect.poll(async () => (await lab.state()).method).toBe('scan-matching');
    await lab.hidePanels();
    await lab.at('mode-manual').click();
    await expect(lab.at('stick')).toBeVisible();
    for (const id of ['inspect', 'edit-map', 'play', 'stop']) expect(await overlap(lab.at('stick'), lab.at(id)), id).toBe(0);
    expect(await overlap(lab.at('stick'), page.getByRole('button', { name: 'Follow the robot' })), 'Follow').toBe(0);
  });
}

/** Whether the whole of what is said in bold is seen, on as many lines as it takes. */
const isWhole = (page: Page): Promise<boolean> => page.evaluate(() => {
  const sentence = document.querySelector('slam-header')!.shadowRoot!.querySelector('.caption p')!;
  const { bottom, right } = sentence.getBoundingClientRect();
  return [...sentence.querySelector('strong')!.getClientRects()].every((line) => line.bottom <= bottom + 1 && line.right <= right + 1);
});

for (const [language, end] of [['en', 'could not be reached'], ['pl', 'nieosiągalne']] as const) {
  test(`the sentence of how an exploration ended is whole on narrow screens, in ${language}`, { tag: '@phone-only' }, async ({ lab, page }) => {
    test.setTimeout(120_000);
    await page.setViewportSize({ width: 360, height: 740 });
    // This robot goes through no door: places stay that it could not reach.
    await lab.open(`/?lang=${language}#lesson=shy`);
    await lab.speed('Infinity');
    await lab.watch((s) => s.finished, 'it explores to its end', 90_000).toBe(true);
    await expect(lab.at('caption')).toContainText(end);
    for (const width of [360, 390, 768]) {
      await page.setViewportSize({ width, height: 740 });
      await expect.poll(() => isWhole(page), `at ${width}`).toBe(true);
    }
  });
}
