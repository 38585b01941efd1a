// A drive reveals its robot's parameters: wheels with known errors are fitted, used as a preset,
// saved and opened; a twin shows the difference.
import { readFile } from 'node:fs/promises';
import { expect, test } from './fixture.ts';
import { drop } from './lab.ts';
import { record } from './recording.ts';

/** The wheels of `record` measure each distance 3 % too long and veer by 0.012 rad per metre; track
    width of a Pioneer. */
const COUNTED = 1.03;
const VEER = 0.012;
const WIDTH = 0.33;

test('wheels that err are fitted, and a twin with their figures stays with the robot', async ({ lab, page }) => {
  test.setTimeout(180_000);
  await lab.open();
  await drop(page, 'laps.log', Buffer.from(record(420).text));
  await lab.watch((s) => s.source === 'replay' && s.finished, 'the recording ends').toBe(true);

  // A twin with the parameters of the model drifts away from the robot.
  await lab.show('settings');
  await lab.at('fit').locator('summary').click();
  await lab.at('twin').check();
  const twin = (): Promise<number[]> => page.evaluate(() => (window as unknown as { slamlab: { twin: number[] } }).slamlab.twin);
  const ended = async (): Promise<void> => {
    await expect.poll(async () => (await lab.status()).finished && (await lab.status()).scans === 420 && Number.isFinite((await twin())[4]), { message: 'mapped again with a twin', timeout: 60_000 }).toBe(true);
  };
  await ended();
  const [, , , , nominal = 0] = await twin();
  expect(nominal, 'the model is not this robot').toBeGreaterThan(0.4);

  // The fit finds the errors of the wheels.
  await lab.at('fit-drive').click();
  await expect(lab.at('fit-table')).toContainText('Effective track width');
  const fit = await page.evaluate(() => (window as unknown as { slamlab: { fit: { settings: Record<string, number>; parameters: { name: string; sigma: number }[] } } }).slamlab.fit);
  const { settings } = fit;
  const mean = ((settings['odometry.left'] ?? NaN) + (settings['odometry.right'] ?? NaN)) / 2;
  expect(Math.abs(mean - (1 / COUNTED - 1)), `both tracks run ${mean} farther than counted`).toBeLessThan(0.004);
  const bend = ((settings['odometry.right'] ?? NaN) - (settings['odometry.left'] ?? NaN)) / WIDTH;
  expect(Math.abs(bend + VEER / COUNTED), `the tracks bend the way by ${bend} rad/m`).toBeLessThan(0.004);

  // With the fitted parameters the twin stays, and the robot's own odometry is corrected.
  await lab.at('fit-use').click();
  await expect(lab.at('fit-used')).toContainText('fit of laps.log');
  await expect.poll(async () => (await twin())[4] ?? NaN, { message: 'the twin stays with the robot', timeout: 60_000 }).toBeLessThan(0.25);
  await ended();
  const [, , , , fitted = NaN, sigma3 = NaN] = await twin();
  expect(fitted).toBeLessThan(nominal / 2);
  expect(sigma3, 'what chance allows is shown').toBeGreaterThan(0);

  // As a file, and back.
  await lab.at('fit-drive').click();
  const download = page.waitForEvent('download');
  await lab.at('fit-save').click();
  const text = await readFile((await (await download).path()) ?? '', 'utf8');
  expect(JSON.parse(text)).toMatchObject({ slamlab_preset: 1, settings: { 'wear.given': 1 } });
  await lab.at('fit-drop').click();
  await expect(lab.at('fit-used')).toBeHidden();
  await drop(page, 'preset.json', Buffer.from(text));
  await expect(lab.at('fit-used')).toContainText('In use');
});
