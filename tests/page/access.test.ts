// Accessibility: by keyboard alone, with assistive technology, in both themes, on the narrowest
// phone.
import { AxeBuilder } from '@axe-core/playwright';
import { expect, test } from './fixture.ts';
import { pressAt } from './hands.ts';

const REACHED = [
  'theme', 'help', 'map', 'play', 'step', 'speed', 'mode-manual', 'mode-goto', 'mode-explore', 'stop', 'layer-grid', 'layer-tree', 'world', 'sensor',
  'method', 'seed', 'dice', 'restart', 'file', 'save', 'tab-plots', 'tab-filter', 'tab-log',
];

test('the tabulator reaches everything, and shows where it is', async ({ lab, page }) => {
  await lab.open();
  const seen = new Set<string>();
  for (let i = 0; i < 70; i += 1) {
    await page.keyboard.press('Tab');
    const focus = await page.evaluate(() => {
      let element = document.activeElement;
      while (element?.shadowRoot?.activeElement) element = element.shadowRoot.activeElement;
      if (!element || element === document.body) return null;
      const outlined = (e: Element | null): boolean => !!e && getComputedStyle(e).outlineStyle !== 'none' && parseFloat(getComputedStyle(e).outlineWidth) >= 1;
      return { id: element.getAttribute('data-testid') ?? element.getAttribute('aria-label') ?? element.tagName, visible: outlined(element) || outlined(element.nextElementSibling) };
    });
    if (!focus) continue;
    expect(focus.visible, `the focus shows on ${focus.id}`).toBe(true);
    seen.add(focus.id);
  }
  for (const id of REACHED) expect([...seen]).toContain(id);
});

test('the keyboard alone plays, aims, drives and saves', async ({ lab, page }) => {
  await lab.open();
  await page.keyboard.press('p');
  await lab.stands();
  const { scans } = await lab.status();
  await page.keyboard.press('n');
  await lab.watch((s) => s.scans, 'one scan more').toBe(scans + 1);
  await page.keyboard.press('p');
  await expect.poll(async () => (await lab.state()).playing).toBe(true);
  await page.keyboard.press('1');
  await lab.watch((s) => s.mode, 'by hand').toBe('manual');
  await lab.at('map').focus();
  await page.keyboard.press('Enter');
  await lab.watch((s) => s.mode, 'to the cross in the middle').toBe('goto');
  await page.keyboard.press('3');
  await lab.watch((s) => s.mode, 'by itself').toBe('explore');
  await page.keyboard.press('?');
  await expect(lab.at('help-dialog')).toBeVisible();
  await page.keyboard.press('Escape');
  await expect(lab.at('help-dialog')).toBeHidden();
  expect((await lab.status()).mode, 'closing the help does not stop the robot').toBe('explore');
  const saved = page.waitForEvent('download');
  await page.keyboard.press('m');
  await expect(lab.at('saving-save'), 'the map is ticked').toBeEnabled();
  await pressAt(page, 'saving-save');
  await saved;
});

for (const theme of ['light', 'dark'] as const) {
  test(`nothing serious stands in anyone's way, ${theme}`, { tag: '@phone' }, async ({ lab, page }) => {
    await page.emulateMedia({ colorScheme: theme });
    await lab.open();
    await lab.pause();
    for (const panel of (['run', 'status', 'plots', 'filter', 'layers', 'log'] as const)) {
      await lab.show(panel);
      const { violations } = await new AxeBuilder({ page }).setLegacyMode().analyze();
      const serious = violations.filter((v) => v.impact === 'serious' || v.impact === 'critical');
      expect(serious.map((v) => `${v.id}: ${v.nodes.map((n) => n.target.join(' ')).join('; ')}`), `panel ${panel}`).toEqual([]);
    }
  });
}

test('nothing sticks out at 360 pixels', { tag: '@phone' }, async ({ lab, page }) => {
  await page.setViewportSize({ width: 360, height: 740 });
  await lab.open();
  for (const panel of ['run', 'status', 'plots', 'filter', 'layers', 'log'] as const) {
    await lab.show(panel);
    const outside = await page.evaluate(() => {
      const found: string[] = [];
      const look = (root: ParentNode): void => {
        for (const element of root.querySelectorAll('*')) {
          if (element.shadowRoot) look(element.shadowRoot);
          const box = element.getBoundingClientRect();
          // Canvases of the map glide in a box that clips them.
          if (element instanceof HTMLCanvasElement && element.closest('#ground, #record, #overlays')) continue;
          if (element.checkVisibility() && box.width > 1 && (box.right > innerWidth + 1 || box.left < -1) && !element.closest('dialog')) found.push(`${element.tagName} ${element.className} ${Math.round(box.left)}..${Math.round(box.right)}`);
        }
      };
      look(document);
      return found;
    });
    expect(outside, `panel ${panel}`).toEqual([]);
    expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(360);
  }
});
