// Lessons: a run with a fault, repaired as a person would, and graded by measurements.
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

const begin = async (lab: Lab, name: string): Promise<void> => {
  await lab.at('show-gallery').click();
  await lab.at(`lesson-${name}`).click();
  await expect(lab.at('lesson')).toBeVisible();
};

/** Waits for the end of an attempt. */
const graded = async (lab: Lab): Promise<void> => {
  await lab.speed('Infinity');
  await expect.poll(async () => (await lab.state()).grade?.isOver, { timeout: 120_000 }).toBe(true);
};

test('a robot that goes through no door is mended, and it stays noted', { tag: '@phone' }, async ({ lab, page, isMobile }) => {
  test.setTimeout(240_000);
  await lab.open();
  await begin(lab, 'shy');
  expect((await lab.state()).setup.settings).toEqual({ 'pilot.gap': 0.3 });
  await expect(lab.at('mark-explored')).toContainText('≥ 95 %');
  if (isMobile) await lab.hidePanels();
  await graded(lab);
  await expect(lab.at('verdict')).toContainText('Not mended yet');
  await expect(lab.at('mark-explored')).toHaveAttribute('data-met', 'false');
  await expect(lab.at('mark-contacts')).toHaveAttribute('data-met', 'true');
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);

  await lab.show('settings');
  await lab.at('settings-search').fill('kept from obstacles');
  await lab.at('s-pilot.gap').fill('5');
  await lab.at('s-pilot.gap').blur();
  if (isMobile) await lab.hidePanels();
  await lab.at('try-again').click();
  await expect.poll(async () => (await lab.state()).grade?.isOver ?? false).toBe(false);
  await graded(lab);
  await expect(lab.at('verdict')).toContainText('Mended');
  await expect(lab.at('next-lesson')).toBeVisible();

  await page.reload();
  await lab.at('show-gallery').click();
  await expect(lab.at('lesson-shy')).toContainText('mended');
  await expect(lab.at('lesson-crooked')).not.toContainText('mended');
});

for (const [lesson, ...groups] of [
  ['shy', 'Planning and driving'], ['short-sighted', 'Points'], ['long-walls', 'Lines'], ['narrow-gate', 'Filter'], ['perfect-wheels', 'Odometry'],
  ['crooked', 'Simulated tracks', 'Odometry'], ['too-sure', 'Filter'], ['one-story', 'Grid particles'],
] as const) {
  test(`the hint of ${lesson} names settings as their panel does`, async ({ lab }) => {
    await lab.open(`/#lesson=${lesson}`);
    await lab.at('lesson').getByText('Hint').click();
    const hint = await lab.at('lesson').locator('details').innerText();
    await lab.show('settings');
    if (hint.includes('All settings')) await lab.at('settings-all').check();
    for (const group of groups) {
      expect(hint).toMatch(new RegExp(`(?:Settings, |under )${group}(?::|,| what)`));
      await expect(lab.at(`settings-${group}`)).toBeVisible();
    }
    // The fault is visible: each setting that the lesson changed.
    for (const key of Object.keys((await lab.state()).setup.settings)) await expect(lab.at(`s-${key}`), key).toHaveCount(1);
  });
}

test('a teacher passes on an address, and another method may be the way out', async ({ lab, page }) => {
  test.setTimeout(180_000);
  await page.goto('/#lesson=blind-faith');
  await expect(lab.at('lesson')).toContainText('It never looks twice');
  await expect.poll(async () => (await lab.state()).method).toBe('odometry');
  await lab.show('run');
  await lab.at('method').selectOption('scan-matching');
  await expect.poll(async () => (await lab.state()).method).toBe('scan-matching');
  await expect(lab.at('lesson'), 'it is the same lesson').toBeVisible();
  await graded(lab);
  await expect(lab.at('verdict')).toContainText('Mended');
  await lab.at('next-lesson').click();
  await expect(lab.at('lesson')).toContainText('Through no door');
  expect(new URL(page.url()).hash).toBe('#lesson=shy');
});

test('the fault itself is not taken away, nor the method where it matters', async ({ lab }) => {
  await lab.open();
  await begin(lab, 'crooked');
  await lab.watch((s) => s.scans, 'it runs').toBeGreaterThan(1);
  const hash = (await lab.state()).setup;
  await lab.show('run');
  await lab.at('method').selectOption('scan-matching');
  await expect(lab.at('toast')).toContainText("the lesson's method is");
  expect((await lab.state()).setup, 'the run goes on').toEqual(hash);
  await expect(lab.at('lesson')).toBeVisible();
});

test('who goes elsewhere leaves the lesson, its address and its fault', async ({ lab, page }) => {
  await lab.open();
  await begin(lab, 'shy');
  await lab.watch((s) => s.scans, 'it runs').toBeGreaterThan(1);
  await lab.show('run');
  await lab.at('world').selectOption('arena');
  await expect(lab.at('lesson')).toHaveCount(0);
  await expect.poll(async () => (await lab.state()).setup).toMatchObject({ world: 'arena', lesson: null, settings: {} });
  expect(new URL(page.url()).hash).toBe('');
  await page.goto('/#lesson=no-such');
  await expect(lab.at('toast')).toContainText('There is no lesson no-such');
});

test('on a short phone a lesson leaves the map in sight, folds to its name, and says what came of it', { tag: '@phone-only' }, async ({ lab, page }) => {
  test.setTimeout(180_000);
  await page.setViewportSize({ width: 360, height: 640 });
  await lab.open('/#lesson=shy');
  const card = async (): Promise<number> => (await lab.at('lesson').boundingBox())!.height;
  await expect(lab.at('lesson')).toContainText('goes through none');
  expect(await card(), 'more than a third of what is left beside bars is map').toBeLessThan(240);
  await lab.at('fold-lesson').click();
  await expect(lab.at('lesson')).toContainText('Through no door');
  await expect(lab.at('lesson')).not.toContainText('goes through none');
  expect(await card()).toBeLessThan(80);
  await graded(lab);
  await expect(lab.at('verdict')).toContainText('Not mended yet');
  await lab.at('fold-lesson').click();
  await expect(lab.at('mark-explored')).toBeVisible();
});
