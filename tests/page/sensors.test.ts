// Sensors described honestly and measured: calibration of the rangers, σ(ρ) of a standing robot and
// of a log, cones, materials.
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';
import { record } from './recording.ts';

async function openTool(lab: Lab, id: string): Promise<void> {
  await lab.show('settings');
  await lab.at(id).locator('summary').click();
}

const PAIRS = 'range_cm;volts\n10;2.28\n20;1.30\n30;0.90\n40;0.75\n50;0.60\n60;0.50\n70;0.45\n80;0.40\n';

test('pairs become a characteristic, which the simulated rangers use', async ({ lab, page }) => {
  await lab.open();
  await openTool(lab, 'calibration');
  await expect(lab.at('calibration-words')).toContainText(/15 pairs, ± [\d.]+ mm/);
  await lab.at('pairs').fill(PAIRS);
  await expect(lab.at('calibration-words')).toContainText(/8 pairs, ± [\d.]+ mm about the curve\. Volts outside of 0\.40 to 2\.28 V are clamped/);
  await expect(lab.at('calibration').locator('.uplot')).toHaveCount(2);
  await expect(lab.at('monotonic')).toBeVisible();
  await lab.at('apply-calibration').click();
  await expect.poll(async () => (await lab.state()).setup.sensor).toBe('rangers');
  expect((await lab.state()).setup.calibration?.text).toBe(PAIRS);
  await expect(lab.at('apply-calibration')).toHaveText('In use');
  await lab.show('run');
  await expect(lab.at('about-sensor')).toContainText('Own calibration');
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
});

test('pairs that cannot be are named by line and field; a bend is reported', async ({ lab }) => {
  await lab.open();
  await openTool(lab, 'calibration');
  await lab.at('pairs').fill(PAIRS.replace('30;0.90', '30;x'));
  await expect(lab.at('calibration-error')).toHaveText('calibration, line 4: volts is `x`, expected a finite number');
  await lab.at('pairs').fill(PAIRS.replace('30;0.90', '30;1.9'));
  await expect(lab.at('calibration-error')).toContainText('calibration, line 4:');
  await expect(lab.at('apply-calibration')).toBeDisabled();
  // Volts that hardly change, then drop: a polynomial of the fifth degree rises and falls between
  // them.
  await lab.at('pairs').fill('range_m,volts\n0.1,3.00\n0.11,2.99\n0.12,2.98\n0.9,2.97\n1.0,1.0\n1.1,0.99\n1.2,0.5\n1.5,0.1\n');
  await lab.at('variable').selectOption('volts');
  await expect(lab.at('not-monotonic')).toContainText(/Not monotonic: from [\d.]+ V on/);
  await lab.at('pairs-file').setInputFiles({ name: 'board.csv', mimeType: 'text/csv', buffer: Buffer.from(PAIRS.replaceAll(';', ',')) });
  await expect(lab.at('calibration-words')).toContainText('8 pairs');
});

test('σ(ρ) of the simulated lidar is estimated, compared with the truth, and used', async ({ lab }) => {
  await lab.open();
  await lab.watch((s) => s.scans, 'it has moved').toBeGreaterThan(10);
  await lab.pause();
  const { hash } = await lab.state();
  await openTool(lab, 'sigma');
  await lab.at('estimate-sigma').click();
  await expect(lab.at('sigma-words')).toContainText(/a = [\d.]+ ± [\d.]+ mm, b = [\d.]+ ± [\d.]+ mm\/m, from 120 scans/);
  const [, a, b] = /a = ([\d.]+) .*b = ([\d.]+) /.exec(await lab.at('sigma-words').innerText())!;
  // 10 mm and 5 mm/m, and somewhat more on slanted walls.
  expect(Number(a)).toBeGreaterThan(8);
  expect(Number(a)).toBeLessThan(13);
  expect(Number(b)).toBeGreaterThan(4);
  expect(Number(b)).toBeLessThan(8);
  expect((await lab.state()).hash, 'the run itself was not touched').toBe(hash);
  await lab.at('use-sigma').click();
  await expect(lab.at('use-sigma')).toHaveText('In use');
  expect((await lab.state()).setup.settings['points.sigma']).toBe(1);
});

test('a log in which the robot never stands says so', async ({ lab }) => {
  await lab.open();
  await lab.show('run');
  await lab.at('file').setInputFiles({ name: 'laps.log', mimeType: 'text/plain', buffer: Buffer.from(record(120).text) });
  await expect.poll(async () => (await lab.state()).source).toBe('replay');
  await lab.watch((s) => s.finished, 'it is mapped').toBe(true);
  await openTool(lab, 'sigma');
  await lab.at('estimate-sigma').click();
  await expect(lab.at('sigma-error')).toContainText(/expected at least 3; record longer/);
});

test('each sensor runs and is described honestly', async ({ lab }) => {
  await lab.open();
  await lab.at('speed').selectOption('Infinity');
  for (const [sensor, words] of [['sick', /Nothing behind the robot/], ['rangers', /only while the robot stands/], ['sonar', /wheels alone, and drifts/]] as const) {
    await lab.show('run');
    await lab.at('sensor').selectOption(sensor);
    await expect(lab.at('about-sensor')).toHaveText(words);
    await expect.poll(async () => (await lab.state()).setup.sensor).toBe(sensor);
    await lab.watch((s) => s.scans, `${sensor} scans`).toBeGreaterThan(2);
    const { beamHalfAngle } = await lab.status();
    if (sensor === 'sonar') expect(beamHalfAngle).toBeGreaterThan(0.2);
    else expect(beamHalfAngle).toBe(0);
  }
});

test('glass, dark walls and people have their signs in the legend where the world has them', async ({ lab }) => {
  await lab.open();
  await lab.show('layers');
  await expect(lab.at('material-Glass')).toBeHidden();
  await lab.hidePanels();
  await lab.enter('lab', '1');
  await lab.show('layers');
  await expect(lab.at('material-Glass')).toBeVisible();
  await expect(lab.at('material-Dark wall')).toBeVisible();
  await lab.hidePanels();
  await lab.enter('crowd', '1');
  await lab.show('layers');
  await expect(lab.at('material-People')).toBeVisible();
  await expect(lab.at('material-Glass')).toBeHidden();
});
