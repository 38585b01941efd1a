// The gallery: experiments that begin by a click, and show what they promise.
import { EXHIBITS } from '../../www/src/gallery.ts';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

const begin = async (lab: Lab, name: string): Promise<void> => {
  await lab.at('show-gallery').click();
  await lab.at(`exhibit-${name}`).click();
};

test('each of a dozen experiments begins, and says what to watch', async ({ lab }) => {
  test.setTimeout(240_000);
  expect(EXHIBITS.length).toBeGreaterThanOrEqual(12);
  await lab.open();
  for (const { name, title, setup } of EXHIBITS) {
    await begin(lab, name);
    await expect(lab.at('exhibit'), name).toContainText(title);
    await expect.poll(async () => {
      const { setup: { world, sensor, seed }, method } = await lab.state();
      return { world, sensor, method, seed };
    }, `${name} runs`).toEqual({ world: setup.world, sensor: setup.sensor, method: setup.method, seed: setup.seed });
    await lab.watch((s) => s.scans, `${name} sees`).toBeGreaterThan(1);
    const settings = (await lab.state()).setup.settings;
    expect(settings, name).toEqual(setup.settings ?? {});
  }
  // Another run has another story.
  await lab.enter('arena');
  await expect(lab.at('exhibit')).toHaveCount(0);
});

test('worlds are called as the Run panel calls them, in the gallery and where a drawing begins', async ({ lab }) => {
  await lab.open();
  await lab.at('show-gallery').click();
  await expect(lab.at('exhibit-not-fooled')).toContainText('Look-alikes: ten equal rooms · Lidar, 360° · Scan matching');
  await expect(lab.at('lesson-shy')).toContainText('Doors: rooms and narrow gaps · Lidar, 360° · Line EKF-SLAM');
  await lab.page.keyboard.press('Escape');
  await lab.page.keyboard.press('o');
  await expect(lab.at('editor-begin').locator('option[value="look-alikes"]')).toHaveText('Look-alikes: ten equal rooms');
});

test('a filter that is too sure leaves its band, and an honest one does not', { tag: '@phone' }, async ({ lab, page, isMobile }) => {
  test.setTimeout(180_000);
  await lab.open();
  await begin(lab, 'too-sure');
  await lab.watch((s) => s.scans, 'it runs').toBeGreaterThan(1);
  if (isMobile) await lab.hidePanels();
  await lab.speed('Infinity');
  await lab.watch((s) => s.nees, 'its error is far outside of what it believes', 120_000).toBeGreaterThan(50);
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
});

test('a story that was read gives its room to the map, and the next one is told again', { tag: '@phone' }, async ({ lab, isMobile }) => {
  await lab.open();
  await begin(lab, 'too-sure');
  const { watch } = EXHIBITS.find(({ name }) => name === 'too-sure')!;
  await expect(lab.at('exhibit')).toContainText(watch);
  await lab.pause();
  await lab.stillCamera();
  const before = (await lab.state()).camera.scale;
  await lab.at('fold-exhibit').click();
  await expect(lab.at('exhibit')).not.toContainText(watch);
  if (isMobile) await expect.poll(async () => (await lab.state()).camera.scale, 'the map is larger').toBeGreaterThan(before);
  await begin(lab, 'wheels');
  await expect(lab.at('exhibit')).toContainText(EXHIBITS.find(({ name }) => name === 'wheels')!.watch);
});

test('by its wheels alone the robot draws walls that are not there', async ({ lab }) => {
  test.setTimeout(120_000);
  await lab.open();
  await begin(lab, 'wheels');
  await lab.speed('Infinity');
  await lab.watch((s) => s.positionError, 'it is metres off', 90_000).toBeGreaterThan(1);
});

test('kidnapped among rooms that look alike the robot says that it is not sure', async ({ lab }) => {
  await lab.open();
  await begin(lab, 'look-alikes');
  await lab.watch((s) => s.scans, 'it runs').toBeGreaterThan(5);
  await lab.at('kidnap').click();
  await lab.watch((s) => s.localisation !== 'localised', 'it is not sure').toBe(true);
  await lab.watch((s) => s.localisation, 'it sees several places', 60_000).toBe('ambiguous');
});

test('a world and a sensor that are chosen at once both count', async ({ lab, page }) => {
  await lab.open();
  await lab.show('run');
  // Quicker than a run can begin.
  await page.evaluate(() => {
    const setup = document.querySelector('slam-setup')!.shadowRoot!;
    for (const [id, value] of [['sensor', 'sick'], ['world', 'arena']] as const) {
      const select = setup.querySelector<HTMLSelectElement>(`[data-testid="${id}"]`)!;
      select.value = value;
      select.dispatchEvent(new Event('change'));
    }
  });
  await expect.poll(async () => (await lab.state()).setup.world).toBe('arena');
  expect((await lab.state()).setup.sensor).toBe('sick');
  // An earlier request does not come back.
  await lab.at('world').selectOption('office');
  await expect.poll(async () => (await lab.state()).setup.world).toBe('office');
  await lab.at('sensor').selectOption('lidar');
  await expect.poll(async () => (await lab.state()).setup.sensor).toBe('lidar');
  expect((await lab.state()).setup.world).toBe('office');
});
