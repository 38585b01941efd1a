// The cycle of the paper as a mode: chosen, followed stage by stage, read, and left again.
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

const now = (lab: Lab) => lab.at('cycle').getAttribute('data-now');

test('the cycle runs with a lidar too, and its stages tell what they gave', async ({ lab }) => {
  await lab.open();
  await lab.enter('arena', '4');
  await expect(lab.at('cycle')).toBeHidden();
  await lab.at('mode-cycle').click();
  await expect(lab.at('mode-cycle')).toHaveAttribute('aria-pressed', 'true');
  await expect(lab.at('cycle')).toBeVisible();
  await expect.poll(() => now(lab), 'it drives its first leg').toBe('go');
  await lab.pause();
  // It was paused at any stage: go on until all of the stages below have results.
  await expect.poll(async () => {
    if ((await now(lab)) !== 'truncate') await lab.at('next-stage').click();
    return now(lab);
  }, 'the path is cut').toBe('truncate');
  for (const [stage, words] of [
    ['scan', /\d+ readings, \d+ on something/], ['lines', /\d+ lines through \d+ readings/], ['localise', /\d+ recognised, \d+ new, \d+ unused/],
    ['map', /\d+ walls/], ['plan', /m in \d+ legs/], ['truncate', /[\d.]+ m of [\d.]+ m: /],
  ] as const) {
    await lab.at(`stage-${stage}`).click();
    await expect(lab.at('stage-words'), stage).toHaveText(words);
  }
});

test('stage by stage it goes round in the order of the paper, and stands between', async ({ lab }) => {
  await lab.open();
  await lab.enter('arena', '4');
  await lab.at('mode-cycle').click();
  await expect.poll(() => now(lab)).not.toBe('');
  await lab.pause();
  const seen: string[] = [];
  for (let i = 0; i < 12; i += 1) {
    const words = (await lab.at('stage-words').innerText()) + (await now(lab));
    await lab.at('next-stage').click();
    await expect.poll(async () => (await lab.at('stage-words').innerText()) + (await now(lab)), 'the next stage is shown').not.toBe(words);
    expect((await lab.state()).playing, 'then it waits').toBe(false);
    seen.push((await now(lab)) ?? '');
  }
  const from = seen.indexOf('lines');
  expect(from, seen.join()).toBeGreaterThanOrEqual(0);
  expect(seen.slice(from, from + 4)).toEqual(['lines', 'localise', 'map', 'plan'].slice(0, seen.length - from));
  const before = (await lab.status()).time;
  await lab.page.waitForTimeout(300);
  expect((await lab.status()).time, 'no time passes between two stages').toBe(before);
});

test('it can be left, and rangers cannot leave it', async ({ lab }) => {
  await lab.open();
  await lab.enter('arena', '4');
  await lab.at('mode-cycle').click();
  await expect(lab.at('cycle')).toBeVisible();
  await lab.at('mode-cycle').click();
  await expect(lab.at('cycle')).toBeHidden();
  await lab.show('run');
  await lab.at('sensor').selectOption('rangers');
  await lab.hidePanels();
  await expect(lab.at('cycle')).toBeVisible();
  await expect(lab.at('mode-cycle')).toBeDisabled();
  await expect(lab.at('mode-cycle')).toHaveAttribute('aria-pressed', 'true');
});

test('the strip fits the page, with the keyboard too', { tag: '@phone' }, async ({ lab, page, hasTouch }) => {
  await lab.open();
  await lab.at('mode-cycle').click();
  await expect(lab.at('cycle')).toBeVisible();
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  const strip = (await lab.at('cycle').boundingBox())!;
  const bar = (await page.locator('slam-transport').boundingBox())!;
  expect(strip.y + strip.height, 'above the controls').toBeLessThanOrEqual(bar.y + 1);
  if (hasTouch) return;
  await lab.pause();
  const words = (await lab.at('stage-words').innerText()) + (await now(lab));
  await page.keyboard.press('.');
  await expect.poll(async () => (await lab.at('stage-words').innerText()) + (await now(lab))).not.toBe(words);
});
