// A first visit: what SLAM is, in four steps, by a live run.
import { DoubtHistory, doubtOf } from '../../www/src/doubt.ts';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

const layers = (lab: Lab): Promise<Record<string, boolean>> =>
  lab.page.evaluate(() => JSON.parse(localStorage.getItem('slamlab-view') ?? '{}') as Record<string, boolean>);

/** Number of pixels on the ground in about the colour of odometry. */
const byWheels = (lab: Lab): Promise<number> => lab.page.evaluate(() => {
  const canvas = document.querySelector('slam-map')!.shadowRoot!.querySelector<HTMLCanvasElement>('#ground')!;
  const { data } = canvas.getContext('2d')!.getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) count += data[i]! > data[i + 1]! + 60 && data[i + 2]! > data[i + 1]! + 30 ? 1 : 0;
  return count;
});

test.describe('a first visit', () => {
  test.use({ firstVisit: true });

  test('tells in four steps what the robot knows, and ends with the truth', { tag: '@phone' }, async ({ lab, page }) => {
    test.setTimeout(180_000);
    await lab.open();
    await expect(lab.at('tour')).toContainText('never been here');
    expect((await layers(lab))['truth'], 'the answer is not given away').toBe(false);
    expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
    await expect(lab.at('tab-settings'), 'few controls first').toBeHidden();
    await expect(lab.at('caption'), 'in words that nobody has to know').toContainText('heads for a place not seen yet');
    await expect(lab.at('caption')).not.toContainText('frontier');

    expect(await byWheels(lab)).toBe(0);
    await lab.at('tour-next').click();
    await expect(lab.at('tour')).toContainText('wheels');
    await lab.watch((s) => s.odometryError, 'the wheels err', 60_000).toBeGreaterThan(0.5);
    await expect.poll(() => byWheels(lab), 'what they would draw is seen').toBeGreaterThan(200);

    await lab.at('tour-next').click();
    const doubt = async (): Promise<number> => doubtOf(await lab.status());
    await expect.poll(doubt, { message: 'doubt grows', timeout: 60_000 }).toBeGreaterThan(0.15);
    await expect(lab.at('tour-doubt')).toContainText('cm');
    // It comes round: the last step appears by itself.
    await expect(lab.at('tour')).toContainText(/from [\d.]+ c?m its doubt fell to [\d.]+ c?m/, { timeout: 120_000 });
    expect(await doubt()).toBeLessThan(0.15);

    await lab.at('tour-truth').click();
    await expect(lab.at('tour-truth')).toHaveAttribute('aria-pressed', 'true');
    await lab.at('tour-next').click();
    await expect(lab.at('tour')).toHaveCount(0);
    await expect(lab.at('tab-settings')).toBeVisible();

    await page.reload();
    await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(0);
    await expect(lab.at('tour'), 'nobody is greeted twice').toHaveCount(0);
    expect((await lab.state()).setup.world).toBe('office');
  });

  test('shows who stays at the first step what goes wrong, and its words stay true when the run is over', async ({ lab }) => {
    test.setTimeout(240_000);
    await lab.open();
    await expect(lab.at('tour')).not.toContainText('wheels');
    await expect(lab.at('tour')).toContainText(/its wheels alone would have drawn: wrong by [\d.]+ c?m/, { timeout: 90_000 });
    await expect(lab.at('tour')).toContainText('never been here');
    expect((await lab.status()).time, 'there was time to read').toBeGreaterThan(140);
    await expect.poll(() => byWheels(lab), 'it is seen').toBeGreaterThan(200);
    await lab.watch((s) => s.finished, 'the run ends', 120_000).toBe(true);
    await expect(lab.at('tour')).toContainText('This robot had never been here');
    await expect(lab.at('tour')).toContainText('what its laser saw last');
    await expect(lab.at('tour')).not.toContainText('just now');
    await lab.at('tour-next').click();
    await expect(lab.at('tour')).toContainText('Its wheels are not enough');
  });

  test('goes on when the map is clicked: the robot comes round all the same', async ({ lab }) => {
    test.setTimeout(180_000);
    await lab.open();
    for (let step = 0; step < 3; step += 1) await lab.at('tour-next').click();
    await lab.watch((s) => s.distance, 'it drives').toBeGreaterThan(1);
    const { x, y } = await lab.status();
    const box = (await lab.at('map').boundingBox())!;
    await lab.page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
    await lab.watch((s) => Math.hypot(s.x - x, s.y - y), 'it goes on').toBeGreaterThan(1);
    expect((await lab.status()).mode, 'it was sent nowhere').toBe('explore');
    await expect(lab.at('toast'), 'nor asked about').toHaveCount(0);
    await expect(lab.at('tour')).toContainText('its doubt fell to', { timeout: 120_000 });
  });

  test('says at its last step what to do with a robot that was taken by hand', async ({ lab, page }) => {
    test.setTimeout(180_000);
    await lab.open();
    for (let step = 0; step < 3; step += 1) await lab.at('tour-next').click();
    await lab.watch((s) => s.distance, 'it drives').toBeGreaterThan(0.5);
    await page.keyboard.press('ArrowUp');
    await expect(lab.at('tour')).toContainText('bring it round');
    await lab.at('tour-explore').click();
    await expect(lab.at('tour')).toContainText('Watch the ellipse');
    await expect(lab.at('tour')).toContainText('its doubt fell to', { timeout: 120_000 });
  });

  test('can be left at any step, and taken again', async ({ lab, page }) => {
    await lab.open();
    await lab.at('tour-next').click();
    await lab.at('tour-back').click();
    await expect(lab.at('tour')).toContainText('never been here');
    await lab.at('tour-leave').click();
    await expect(lab.at('tour')).toHaveCount(0);
    await page.keyboard.press('?');
    await lab.at('tour-begin').click();
    await expect(lab.at('tour')).toContainText('never been here');
    // Another world has another story.
    await lab.at('tour-leave').click();
    await lab.enter('arena');
    await expect(lab.at('tour')).toHaveCount(0);
  });
});

test('on a phone the truth can be peeked at beside the map', { tag: '@phone-only' }, async ({ lab }) => {
  await lab.open();
  await expect(lab.at('peek-map')).toHaveAttribute('aria-pressed', 'true');
  await lab.at('peek-map').tap();
  await expect(lab.at('peek-map')).toHaveAttribute('aria-pressed', 'false');
  await lab.show('layers');
  await expect(lab.at('layer-truth')).not.toBeChecked();
});

test('the truth can be peeked at, by key and button, and layers stay as they were left', async ({ lab, page }) => {
  await lab.open();
  await expect(lab.at('peek')).toHaveAttribute('aria-pressed', 'true');
  await page.keyboard.press('x');
  await expect(lab.at('peek')).toHaveAttribute('aria-pressed', 'false');
  await lab.show('layers');
  await lab.at('layer-wheels').check();
  await page.reload();
  await lab.show('layers');
  await expect(lab.at('layer-wheels')).toBeChecked();
  await expect(lab.at('layer-truth')).not.toBeChecked();
  await lab.at('peek').click();
  await expect(lab.at('layer-truth')).toBeChecked();
});

test('what is kept of the view may be anything', async ({ lab, page }) => {
  for (const kept of ['null', '{"grid":7,"wheels":true,"__proto__":{"truth":false}}', '[', '"grid"']) {
    await page.addInitScript((text) => localStorage.setItem('slamlab-view', text), kept);
    await lab.open();
    await lab.show('layers');
    await expect(lab.at('layer-grid')).toBeChecked();
    await expect(lab.at('layer-truth')).toBeChecked();
  }
});

test('doubt is the longer half axis of the ellipse of 95 %', () => {
  // χ² of two degrees of freedom: P(r² < s) = 1 - exp(-s / 2).
  const radius = Math.sqrt(-2 * Math.log(0.05));
  expect(doubtOf({ covXx: 0.04, covXy: 0, covYy: 0.01 })).toBeCloseTo(0.2 * radius, 3);
  // The same ellipse turned by 30°.
  const [c, s] = [Math.cos(Math.PI / 6), Math.sin(Math.PI / 6)];
  expect(doubtOf({ covXx: 0.04 * c * c + 0.01 * s * s, covXy: 0.03 * c * s, covYy: 0.04 * s * s + 0.01 * c * c })).toBeCloseTo(0.2 * radius, 3);
});

test('doubt collapses where it shrinks by half within seconds', () => {
  const history = new DoubtHistory();
  for (let t = 0; t < 100; t += 1) expect(history.add(t, 0.003 * t)).toBeNull();
  expect(history.add(100, 0.1)).toEqual({ from: expect.closeTo(0.297, 6), to: 0.1 });
  // A slow decrease is not a collapse.
  const slow = new DoubtHistory();
  for (let t = 0; t < 200; t += 1) expect(slow.add(t, 0.5 - 0.002 * t)).toBeNull();
  const long = new DoubtHistory();
  for (let t = 0; t < 10_000; t += 1) long.add(t, 0.01);
  expect(long.samples.length).toBeLessThanOrEqual(DoubtHistory.MOST);
});
