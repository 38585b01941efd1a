// A teacher with a mouse: shows an experiment, compares two methods before the class, and passes on
// a lesson and the very run by their addresses.
import { expect, test } from './fixture.ts';

test('a teacher shows, compares, and passes on', async ({ lab, page, browser }) => {
  test.setTimeout(240_000);
  await lab.open();

  // Shown: an experiment, its world explained beside the map.
  await lab.at('show-gallery').click();
  await lab.at('exhibit-wheels').click();
  await expect(lab.at('exhibit')).toBeVisible();
  const { setup } = await lab.state();
  await lab.speed('10');
  await lab.watch((s) => s.positionError, 'wheels alone go astray', 90_000).toBeGreaterThan(0.3);

  // Compared: the same world, at the same moment, by a method that also uses the sensor.
  await lab.pause();
  await lab.at('compare').click();
  await lab.at('race-scan-matching').check();
  await lab.at('race-go').click();
  interface Beside { isThere: boolean; status: { positionError: number; time: number } | null }
  const other = (): Promise<Beside | undefined> => page.evaluate(() => (window as unknown as { slamlab: { beside: Beside[] } }).slamlab.beside[0]);
  const { time, positionError } = await lab.status();
  await expect.poll(async () => (await other())?.status?.time ?? NaN, { message: 'it has caught up', timeout: 90_000 }).toBeCloseTo(time, 6);
  expect((await other())!.status!.positionError, 'who looks knows better').toBeLessThan(positionError / 2);

  // Passed on: the run itself, to the bit.
  await lab.show('run');
  const before = page.url();
  await lab.at('copy-link').click();
  await expect.poll(() => page.url(), 'the address is the link').not.toBe(before);
  const address = page.url();
  expect(address).toContain(`world=${setup.world}`);
  const theirs = await browser.newContext();
  await theirs.addInitScript(() => localStorage.setItem('slamlab-visited', '1'));
  const pupil = await theirs.newPage();
  await pupil.goto(address);
  await pupil.getByTestId('speed').selectOption('Infinity');
  const noted = (): Promise<string[]> => pupil.evaluate(() => (window as unknown as { slamlab: { log: { text: string }[] } }).slamlab.log.map(({ text }) => text));
  await expect.poll(noted, { message: 'the same state', timeout: 90_000 }).toContainEqual(expect.stringContaining('the state is the same, to the bit'));

  // Passed on: a lesson, by its address; a pupil begins it there.
  await lab.at('show-gallery').click();
  await lab.at('lesson-blind-faith').click();
  await expect(lab.at('lesson')).toBeVisible();
  await expect.poll(() => new URL(page.url()).hash).toBe('#lesson=blind-faith');
  await pupil.goto(page.url());
  await expect(pupil.getByTestId('lesson')).toContainText('It never looks twice');
  await theirs.close();
});
