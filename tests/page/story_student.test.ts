// A student who was told nothing, on a phone, by touch alone: learns what SLAM is, drives, breaks
// it, and finds it again the next day.
import { expect, test } from './fixture.ts';
import { fits, pushUntil } from './hands.ts';

test.use({ firstVisit: true });

test('a student meets SLAM on a phone', { tag: '@phone-only' }, async ({ lab, page }) => {
  test.setTimeout(240_000);
  await lab.open();

  // What is this? A robot in a new place, with odometry errors.
  await expect(lab.at('tour')).toContainText('never been here');
  await lab.at('tour-next').tap();
  await expect(lab.at('tour')).toContainText('wheels');
  await lab.watch((s) => s.odometryError, 'the wheels err', 90_000).toBeGreaterThan(0.3);
  await lab.at('tour-leave').tap();
  await expect(lab.at('tour')).toHaveCount(0);
  await fits(page);

  // "Choose Go to and tap the map: the robot drives there."
  await lab.at('mode-goto').tap();
  const { x, y } = await lab.status();
  await lab.pointAt(x + 0.4, y, true);
  await lab.watch((s) => s.mode, 'it drives there').toBe('goto');

  // By hand, with the thumb, as long as it is down.
  await lab.at('mode-manual').tap();
  await lab.standsStill();
  const { distance, heading } = await lab.status();
  await pushUntil(lab.at('stick'), [50, 0], () =>
    lab.watch((s) => Math.abs(Math.sin(s.heading - heading)), 'it turns').toBeGreaterThan(0.2));
  await lab.standsStill();
  expect((await lab.status()).distance - distance, 'it turned on the spot').toBeLessThan(0.3);

  // An experiment: beside it stands what to watch, and a tap can break it.
  await lab.at('show-gallery').tap();
  await lab.at('exhibit-look-alikes').tap();
  await expect(lab.at('exhibit')).toBeVisible();
  await fits(page);
  await lab.watch((s) => s.scans, 'it runs').toBeGreaterThan(5);
  await lab.at('kidnap-here').tap();
  await lab.watch((s) => s.localisation !== 'localised', 'it is not sure where it is', 60_000).toBe(true);
  await lab.at('stop').tap();
  await lab.standsStill();

  // The next day the page remembers what was under way.
  await expect.poll(() => page.evaluate(() => localStorage.getItem('slamlab-view')), 'the view is kept').not.toBeNull();
  await page.reload();
  await lab.watch((s) => s.scans, 'a robot explores').toBeGreaterThan(0);
  await expect(lab.at('tour'), 'nobody is greeted twice').toHaveCount(0);
});
