// The run that was under way when the page was left is back on the next visit.
import { expect, test } from './fixture.ts';
import { drop } from './lab.ts';
import { record, RING } from './recording.ts';

const kept = () => localStorage.getItem('slamlab-last-run');

test('a simulation goes on where it was left, to the bit, with what was done to it', { tag: '@phone' }, async ({ lab, page, isMobile }) => {
  test.setTimeout(120_000);
  await lab.open();
  await lab.enter('doors', '4');
  await lab.show('settings');
  await lab.at('settings-search').fill('kept from obstacles');
  await lab.at('s-pilot.gap').fill('9');
  await lab.at('s-pilot.gap').blur();
  await expect.poll(async () => (await lab.state()).setup.settings).toEqual({ 'pilot.gap': 0.09 });
  if (isMobile) await lab.hidePanels();
  await lab.watch((s) => s.time, 'it is worth to be kept').toBeGreaterThan(21);
  await lab.pause();
  await expect.poll(async () => page.evaluate(kept)).not.toBeNull();
  const { time } = await lab.status();
  await expect.poll(async () => JSON.parse((await page.evaluate(kept)) ?? '{}').time, { timeout: 10_000 }).toBe(time);
  await expect.poll(async () => (await lab.state()).hash).not.toBe('');
  await page.waitForTimeout(700);
  const { hash } = await lab.state();

  await page.reload();
  await expect(lab.at('last-run')).toContainText('Doors: rooms and narrow gaps, Line EKF-SLAM, at 0:');
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  await lab.at('go-on').click();
  await expect(lab.at('last-run')).toHaveCount(0);
  await expect.poll(async () => (await lab.state()).setup.world).toBe('doors');
  await lab.watch((s) => s.time, 'it comes to where it was').toBe(time);
  await expect.poll(async () => (await lab.state()).playing).toBe(false);
  await expect.poll(async () => (await lab.state()).hash, 'to the bit').toBe(hash);
});

test('a recording is there again with its file, and closing the offer forgets it', async ({ lab, page }) => {
  test.setTimeout(120_000);
  await lab.open();
  await drop(page, 'loop.clf', new TextEncoder().encode(record(600, RING).text));
  await expect.poll(async () => (await lab.state()).source).toBe('replay');
  await lab.watch((s) => s.time, 'it is worth to be kept').toBeGreaterThan(21);
  await expect.poll(async () => JSON.parse((await page.evaluate(kept)) ?? '{}').kind, { timeout: 10_000 }).toBe('replay');

  await page.reload();
  await expect(lab.at('last-run')).toContainText('loop.clf');
  await lab.at('go-on').click();
  await expect.poll(async () => (await lab.state()).title).toBe('loop.clf');
  await lab.watch((s) => s.scans, 'it is mapped again').toBeGreaterThan(5);

  await page.reload();
  await lab.at('last-run').getByRole('button', { name: 'Forget it' }).click();
  await expect(lab.at('last-run')).toHaveCount(0);
});

test('who goes on without an answer has the new run kept, and may go back once', async ({ lab, page }) => {
  test.setTimeout(120_000);
  await lab.open();
  await lab.enter('doors', '20');
  await lab.watch((s) => s.time, 'it is worth to be kept').toBeGreaterThan(21);
  await expect.poll(async () => JSON.parse((await page.evaluate(kept)) ?? '{}').title, { timeout: 10_000 }).toBe('doors');

  await page.reload();
  await expect(lab.at('last-run')).toContainText('Doors');
  await lab.watch((s) => s.time, 'the new run is one to be kept').toBeGreaterThan(20);
  await expect(lab.at('last-run'), 'the card goes').toHaveCount(0, { timeout: 30_000 });
  await lab.says('The run before, in Doors: rooms and narrow gaps');
  await expect.poll(async () => JSON.parse((await page.evaluate(kept)) ?? '{}').title, { timeout: 10_000 }).toBe('office');
  await lab.at('toast-way').click();
  await expect.poll(async () => (await lab.state()).setup.world, 'it is done again').toBe('doors');
});

test('who does something else is not asked again, and what is no run of ours is nothing', async ({ lab, page }) => {
  await page.addInitScript(() => localStorage.setItem('slamlab-last-run', '{"kind":"sim","title":7}'));
  await lab.open();
  await expect(lab.at('last-run')).toHaveCount(0);
  await page.addInitScript(() => localStorage.setItem('slamlab-last-run', JSON.stringify({ kind: 'sim', title: 'office', method: 'line-ekf', time: 30, link: 'run&nonsense', setup: {} })));
  await page.reload();
  await lab.at('go-on').click();
  await expect(lab.at('toast')).toContainText('nonsense');
  await page.reload();
  await expect(lab.at('last-run')).toBeVisible();
  await lab.enter('arena');
  await expect(lab.at('last-run')).toHaveCount(0);
});
