// At the end of a run the page suggests what to do next.
import { expect, test } from './fixture.ts';
import { record } from './recording.ts';

test('at the end of a run the page offers what next, and does it', { tag: '@phone' }, async ({ lab, page }) => {
  await lab.open();
  const offer = lab.at('next');
  await expect(offer, 'not while it explores').toHaveCount(0);
  await lab.speed('Infinity');
  await lab.watch((s) => s.finished, 'the building is explored', 90_000).toBe(true);
  await expect(offer).toContainText('What next?');
  const box = (await offer.boundingBox())!;
  expect(box.x).toBeGreaterThanOrEqual(0);
  expect(box.x + box.width).toBeLessThanOrEqual(page.viewportSize()!.width);
  await lab.at('next-gallery').click();
  await expect(lab.at('gallery')).toBeVisible();
  await expect(offer, 'it was taken').toHaveCount(0);
  await page.keyboard.press('Escape');
  const { world } = (await lab.state()).setup;
  await page.keyboard.press('r');
  await lab.watch((s) => s.finished, 'another run begins').toBe(false);
  await lab.watch((s) => s.finished, 'the building is explored', 90_000).toBe(true);
  await lab.at('next-world').click();
  await expect.poll(async () => (await lab.state()).setup.world).not.toBe(world);
  await lab.watch((s) => s.mode, 'it explores').toBe('explore');
  await expect(offer).toHaveCount(0);
});

test('stop at the end of a run leaves the offer, which covers no walls', { tag: '@phone' }, async ({ lab, page }) => {
  await lab.open();
  await lab.enter('arena', 'Infinity');
  await lab.watch((s) => s.finished, 'the building is explored', 90_000).toBe(true);
  const offer = lab.at('next');
  await expect(offer).toBeVisible();
  await lab.stillCamera();
  // The lowest wall of the building, outside of it.
  const lowest = await page.evaluate(() => {
    const { toScreen } = (window as unknown as { slamlab: { toScreen(x: number, y: number): [number, number] } }).slamlab;
    return toScreen(0, -1)[1];
  });
  const [map, box] = [(await lab.at('map').boundingBox())!, (await offer.boundingBox())!];
  expect(map.y + lowest, 'the walls are above it').toBeLessThan(box.y);
  const dot = page.locator('slam-header .dot');
  await lab.at('stop').click();
  await expect(lab.at('caption')).toContainText('Stopped');
  await expect(dot, 'no green light').not.toHaveClass(/on/);
  await expect(offer).toBeVisible();
  await page.getByRole('button', { name: 'Close the offer' }).click();
  await lab.at('stop').click();
  await expect(offer, 'closed is closed').toHaveCount(0);
});

test('the hint of a first visit goes by itself, and at the first click on the map', async ({ lab, page }) => {
  await lab.open();
  await lab.speed('20');
  await expect(lab.at('tip')).toContainText('Click the map');
  await lab.speed('1');
  await expect(lab.at('tip'), 'it was read').toHaveCount(0, { timeout: 15_000 });
  await page.evaluate(() => localStorage.removeItem('slamlab-tip-seen'));
  await lab.open('/?again');
  await lab.speed('20');
  await expect(lab.at('tip')).toBeVisible();
  await lab.speed('1');
  const { x, y } = await lab.status();
  await lab.pointAt(x, y, false);
  await expect(lab.at('tip')).toHaveCount(0, { timeout: 2000 });
});

test('at the end of a recording there is no other building to offer, and an offer can be closed', async ({ lab, page }) => {
  await lab.open();
  await lab.show('run');
  await lab.at('file').setInputFiles({ name: 'laps.log', mimeType: 'text/plain', buffer: Buffer.from(record(200).text) });
  await expect.poll(async () => (await lab.state()).source).toBe('replay');
  await lab.watch((s) => s.finished, 'it is mapped').toBe(true);
  await expect(lab.at('next-compare')).toBeVisible();
  await expect(lab.at('next-save')).toBeVisible();
  await expect(lab.at('next-world')).toHaveCount(0);
  await page.getByRole('button', { name: 'Close the offer' }).click();
  await expect(lab.at('next')).toHaveCount(0);
});
