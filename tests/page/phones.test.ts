// The layout on a small phone: no control covers another, and sentences are complete.
import type { Locator, Page } from '@playwright/test';
import { expect, test } from './fixture.ts';

/** By how much two elements overlap, px. */
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

/** Whether the whole sentence in bold is visible, on as many lines as it takes. */
const isWhole = (page: Page): Promise<boolean> => page.evaluate(() => {
  const sentence = document.querySelector('slam-header')!.shadowRoot!.querySelector('.caption p')!;
  const { bottom, right } = sentence.getBoundingClientRect();
  return [...sentence.querySelector('strong')!.getClientRects()].every((line) => line.bottom <= bottom + 1 && line.right <= right + 1);
});

for (const [language, end] of [['en', 'could not be reached'], ['pl', 'nieosiągalne']] as const) {
  test(`the sentence of how an exploration ended is whole on narrow screens, in ${language}`, { tag: '@phone-only' }, async ({ lab, page }) => {
    test.setTimeout(120_000);
    await page.setViewportSize({ width: 360, height: 740 });
    // This robot fits through no door, so places remain that it could not reach.
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

for (const language of ['en', 'hu', 'cs', 'pl']) {
  test(`the names of the tabs stand apart from one another at 360 px, in ${language}`, { tag: '@phone-only' }, async ({ lab, page }) => {
    await page.setViewportSize({ width: 360, height: 740 });
    await lab.open(`/?lang=${language}`);
    const words = await page.evaluate(() => [...document.querySelector('slam-tabs')!.shadowRoot!.querySelectorAll('button')].map((button) => {
      const word = document.createRange();
      word.selectNodeContents(button);
      word.setStartAfter(button.querySelector('svg')!);
      const { left, right } = word.getBoundingClientRect();
      return { word: button.textContent.trim(), left, right };
    }));
    expect(words).toHaveLength(8);
    for (const [i, { word, left }] of words.entries()) if (i > 0) expect(left - words[i - 1]!.right, `${words[i - 1]!.word} and ${word}`).toBeGreaterThanOrEqual(4);
    expect(words.at(-1)!.right).toBeLessThanOrEqual(360);
  });
}

test('a message over the editor lies on no tool, and goes with the editor', { tag: '@phone' }, async ({ lab, page }) => {
  await lab.open();
  await lab.show('run');
  await lab.at('draw-world').click();
  await lab.at('editor-file').setInputFiles({ name: 'photo.jpg', mimeType: 'image/jpeg', buffer: Buffer.from('\xff\xd8\xff\xe0\0\x10JFIF\0', 'latin1') });
  await expect(lab.at('toast')).toContainText('photo.jpg');
  const tools = page.locator('slam-editor .head button').filter({ visible: true });
  expect(await tools.count()).toBeGreaterThan(5);
  for (const tool of await tools.all()) expect(await overlap(lab.at('toast'), tool), String(await tool.textContent())).toBe(0);
  await lab.at('editor-close').click();
  await expect(lab.at('toast')).toBeHidden();
});
