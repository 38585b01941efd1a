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
