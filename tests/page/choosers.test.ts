// Every chooser does what it says, for the eye and for keyboard users.
import { expect, test } from './fixture.ts';
import type { Setup } from '../../www/src/protocol/module.ts';

test('world, sensor, method and seed start the run again', { tag: '@phone' }, async ({ lab, page }) => {
  await lab.open();
  await lab.speed('20');
  await lab.show('run');
  const restarts = async (change: () => Promise<unknown>, setup: Partial<Setup>): Promise<void> => {
    await lab.watch((s) => s.time, 'the run has gone on').toBeGreaterThan(2);
    await change();
    await expect.poll(async () => (await lab.state()).setup, 'the setup').toMatchObject(setup);
    await lab.watch((s) => s.scans, 'it runs').toBeGreaterThan(0);
  };
  await restarts(() => lab.at('world').selectOption('doors'), { world: 'doors' });
  await restarts(() => lab.at('sensor').selectOption('rangers'), { world: 'doors', sensor: 'rangers' });
  await restarts(() => lab.at('sensor').selectOption('lidar'), { sensor: 'lidar' });
  await restarts(() => lab.at('method').selectOption('scan-matching'), { method: 'scan-matching' });
  await restarts(async () => {
    await lab.at('seed').fill('12');
    await page.keyboard.press('Enter');
  }, { seed: 12 });
  const begun = (await lab.status()).time;
  await lab.at('restart').click();
  await lab.watch((s) => s.time, 'from the beginning').toBeLessThan(begun + 2);
});

test('a run that another one took the place of is there again, to the bit', { tag: '@phone' }, async ({ lab, page }) => {
  test.setTimeout(120_000);
  await lab.open();
  await lab.speed('20');
  await lab.watch((s) => s.time, 'it is long enough to be missed').toBeGreaterThan(21);
  await lab.pause();
  await expect.poll(async () => (await lab.state()).hash).not.toBe('');
  await page.waitForTimeout(700);
  const { status, hash } = await lab.state();
  const isBack = async (): Promise<void> => {
    await lab.says('The run before, in Office: rooms off a corridor, had come as far as');
    await lab.at('toast-way').click();
    await expect.poll(async () => (await lab.state()).setup.world).toBe('office');
    await lab.watch((s) => s.time, 'it comes to where it was').toBe(status!.time);
    await expect.poll(async () => (await lab.state()).playing, 'and waits').toBe(false);
    await expect.poll(async () => (await lab.state()).hash).toBe(hash);
  };
  // Somebody goes through the list by keys: each entry begins a run.
  await lab.show('run');
  await lab.at('world').focus();
  for (let i = 0; i < 2; i += 1) {
    const { title } = await lab.state();
    await page.keyboard.press('ArrowDown');
    await expect.poll(async () => (await lab.state()).title).not.toBe(title);
  }
  await isBack();
  await page.evaluate(() => (document.activeElement as HTMLElement | null)?.blur());
  await page.keyboard.press('r');
  await lab.watch((s) => s.time, 'it begins again').toBeLessThan(20);
  await isBack();
  // A short run is not offered, but the long one before it still is.
  await lab.at('dice').click();
  await expect.poll(async () => (await lab.state()).setup.seed).not.toBe(7);
  await lab.says('The run before');
});

test('method, settings, speed and the open panel are as they were after a reload; a link goes before them', async ({ lab, page, problems }) => {
  test.setTimeout(120_000);
  await lab.open();
  await lab.speed('10');
  await lab.at('method').selectOption('scan-matching');
  await lab.show('settings');
  await lab.at('settings-search').fill('kept from obstacles');
  await lab.at('s-pilot.gap').fill('9');
  await lab.at('s-pilot.gap').blur();
  await expect.poll(async () => (await lab.state()).setup.settings).toEqual({ 'pilot.gap': 0.09 });

  await page.reload();
  await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(0);
  expect(await lab.state()).toMatchObject({ method: 'scan-matching', setup: { world: 'office', settings: { 'pilot.gap': 0.09 } } });
  await expect(lab.at('speed')).toHaveValue('10');
  await expect(lab.at('tab-settings')).toHaveAttribute('aria-pressed', 'true');
  await lab.at('settings-search').fill('kept from obstacles');
  await expect(lab.at('s-pilot.gap')).toHaveValue('9');

  await page.goto('/#run&world=arena&sensor=lidar&method=line-ekf&seed=3');
  await page.reload();
  await expect.poll(async () => (await lab.state()).title).toBe('arena');
  expect(await lab.state()).toMatchObject({ method: 'line-ekf', setup: { settings: {} } });

  // A build that does not know the kept choices begins without them, and says so.
  await page.evaluate(() => localStorage.setItem('slamlab-choices', '{"method":"oracle","settings":{"no.such":7},"speed":"fast"}'));
  await lab.open();
  expect(await lab.state()).toMatchObject({ method: 'line-ekf', setup: { settings: {} } });
  expect(await page.evaluate(() => localStorage.getItem('slamlab-choices'))).toBeNull();
  // Other invalid choices do not stop it either.
  for (const kept of ['[', '7', 'null', '{"settings":[]}']) {
    await page.evaluate((kept) => localStorage.setItem('slamlab-choices', kept), kept);
    await lab.open(`/?${kept.length}`);
  }
  expect(problems.filter((problem) => !problem.includes('oracle'))).toEqual([]);
  problems.length = 0;
});

test('every world of the page can be entered', async ({ lab }) => {
  test.setTimeout(120_000);
  await lab.open();
  const worlds = await lab.at('world').locator('option').evaluateAll((options) => options.map((o) => (o as HTMLOptionElement).value));
  expect(worlds, 'small ones and large ones').toEqual(expect.arrayContaining(['office', 'campus']));
  for (const world of worlds) {
    await lab.at('world').selectOption(world);
    await expect.poll(async () => (await lab.state()).title, { message: world, timeout: 30_000 }).toBe(world);
    await lab.watch((s) => s.scans, `the robot scans in ${world}`).toBeGreaterThan(0);
  }
});

test('the run pauses, steps one scan, and changes pace', async ({ lab }) => {
  await lab.open();
  await lab.pause();
  await expect(lab.at('caption')).toContainText('Paused');
  const { scans, time } = await lab.status();
  await lab.at('step').click();
  await lab.watch((s) => s.scans, 'one scan more').toBe(scans + 1);
  await lab.at('step').click();
  await lab.watch((s) => s.scans, 'and one more').toBe(scans + 2);
  expect((await lab.state()).playing).toBe(false);
  expect((await lab.status()).time).toBeLessThan(time + 2);
  await lab.speed('2');
  await lab.at('play').click();
  await lab.watch((s) => s.time, 'it goes on').toBeGreaterThan(time + 2);
});

test('layers are switched on and off', { tag: '@phone' }, async ({ lab, page }) => {
  await lab.open();
  await lab.pause();
  await lab.stillCamera();
  await lab.show('layers');
  /** Pixels that are drawn over; the faint ruled lines do not count. */
  const ink = () => page.evaluate(() => {
    const pixels = (window as unknown as { slamlab: { picture: ImageData } }).slamlab.picture.data;
    let count = 0;
    for (let i = 3; i < pixels.length; i += 4) count += pixels[i]! > 100 ? 1 : 0;
    return count;
  });
  await lab.stillCamera();
  const full = await ink();
  const switches = ['grid', 'scan', 'walls', 'lines', 'truth', 'trails', 'robot', 'frontiers', 'path'];
  for (const name of switches) {
    await lab.at(`layer-${name}`).uncheck();
    await expect(lab.at(`layer-${name}`)).not.toBeChecked();
  }
  await lab.stillCamera();
  await expect.poll(ink, 'nearly nothing is drawn').toBeLessThan(full / 3);
  for (const name of switches) await lab.at(`layer-${name}`).check();
  await lab.stillCamera();
  await expect.poll(ink, 'all is back').toBeGreaterThan(full * 0.95);
});

test('the theme changes and is remembered', async ({ lab, page }) => {
  await page.emulateMedia({ colorScheme: 'light' });
  await lab.open();
  const colour = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const light = await colour();
  await lab.at('theme').click();
  await expect.poll(colour).not.toBe(light);
  const dark = await colour();
  await page.reload();
  await expect.poll(colour, 'after a reload').toBe(dark);
});
