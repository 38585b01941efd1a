// Somebody who uses no mouse: everything of a first hour by keyboard alone, each control reached by
// Tab or by its key.
import { expect, test } from './fixture.ts';
import { focused, pressAt, tabTo } from './hands.ts';

test.use({ firstVisit: true });

test('the first hour of somebody who uses no mouse', async ({ lab, page }) => {
  test.setTimeout(240_000);
  await lab.open();

  // The tour, and out of it.
  await pressAt(page, 'tour-next');
  await expect(lab.at('tour')).toContainText('wheels');
  await pressAt(page, 'tour-leave');
  await expect(lab.at('tour')).toHaveCount(0);

  // Which keys there are, and back to where the focus was.
  await tabTo(page, 'help');
  await page.keyboard.press('Enter');
  await expect(lab.at('help-dialog')).toBeVisible();
  await page.keyboard.press('Escape');
  await expect(lab.at('help-dialog')).toBeHidden();
  expect(await focused(page), 'the focus is where it was').toBe('help');

  // Another world and another method, by the arrow keys in their lists.
  await tabTo(page, 'world');
  await page.keyboard.type('arena');
  await page.keyboard.press('Enter');
  await expect.poll(async () => (await lab.state()).setup.world).toBe('arena');
  await lab.watch((s) => s.scans, 'the run begins').toBeGreaterThan(1);
  // At a person's pace: ten times as fast, it would arrive before the next key.
  await lab.speed('1');

  // By hand: it goes while the key is down.
  await page.evaluate(() => (document.activeElement as HTMLElement | null)?.blur());
  await page.keyboard.press('1');
  await lab.standsStill();
  const { distance } = await lab.status();
  await page.keyboard.down('ArrowUp');
  await lab.watch((s) => s.distance, 'it goes').toBeGreaterThan(distance + 0.1);
  await page.keyboard.up('ArrowUp');
  await lab.standsStill();

  // To a place: the arrows move the cross in the middle of the map, Enter sends it there.
  await page.keyboard.press('3');
  await lab.watch((s) => s.mode, 'it explores').toBe('explore');
  await tabTo(page, 'map');
  // An exploration does not end without a question.
  await page.keyboard.press('Enter');
  await lab.says('Send the robot there?');
  await page.keyboard.press('Enter');
  await lab.watch((s) => s.mode, 'to the cross').toBe('goto');

  // Stop is one key, wherever the focus is.
  await tabTo(page, 'layer-grid');
  await page.keyboard.press('Escape');
  await lab.watch((s) => s.mode, 'stopped').toBe('manual');
  await lab.standsStill();

  // A layer off and on, the truth shown, the past looked at.
  const isOn = (): Promise<boolean> => lab.at('layer-grid').isChecked();
  const before = await isOn();
  await tabTo(page, 'layer-grid');
  await page.keyboard.press('Space');
  expect(await isOn()).toBe(!before);
  await page.keyboard.press('Space');
  expect(await isOn()).toBe(before);
  await page.keyboard.press('p');
  await expect.poll(async () => (await lab.state()).playing).toBe(false);
  const { scans } = await lab.status();
  await page.keyboard.press('b');
  await lab.watch((s) => s.scans, 'one scan back').toBeLessThan(scans);

  // A lesson from the gallery.
  await page.keyboard.press('g');
  await expect(lab.at('gallery')).toBeVisible();
  await pressAt(page, 'lesson-shy');
  await expect(lab.at('lesson')).toBeVisible();
  await expect.poll(async () => (await lab.state()).setup.lesson).toBe('shy');

  // The work is kept.
  await lab.watch((s) => s.scans, 'it runs').toBeGreaterThan(1);
  const saved = page.waitForEvent('download');
  await page.keyboard.press('m');
  await expect(lab.at('saving-save'), 'the map is ticked').toBeEnabled();
  await pressAt(page, 'saving-save');
  expect((await saved).suggestedFilename(), 'its picture and its sheet').toMatch(/\.zip$/);
});
