// The first thing a visitor sees: a robot that explores by itself, to the end, without help.
import { expect, test } from './fixture.ts';
import { simulate } from './simulate.ts';

test('the robot explores by itself and the map grows', { tag: '@phone' }, async ({ lab }, info) => {
  const begin = Date.now();
  await lab.open();
  info.annotations.push({ type: 'first picture', description: `${Date.now() - begin} ms` });
  const { blocks, status } = await lab.state();
  expect(status?.mode).toBe('explore');
  await lab.watch((s) => s.distance, 'it drives').toBeGreaterThan(0.5);
  await expect(lab.at('caption')).toContainText('Exploring');
  await expect.poll(async () => (await lab.state()).blocks, 'the map grows').toBeGreaterThan(blocks);
  await lab.watch((s) => s.explored, 'more becomes known').toBeGreaterThan(status?.explored ?? 0);
  info.annotations.push({ type: 'frames per second', description: String((await lab.state()).framesPerSecond) });
});

test('arena is explored to the end, with the same bits as natively', async ({ lab }) => {
  await lab.open();
  await lab.enter('arena');
  await lab.watch((s) => s.finished, 'exploration ends by itself', 60_000).toBe(true);
  await expect(lab.at('caption')).toContainText(/explored/i);
  const status = await lab.status();
  expect(status.explored).toBeGreaterThan(0.95);
  expect(status.contacts).toBe(0);
  expect(status.positionError).toBeLessThan(0.1);
  expect(status.positionError).toBeLessThan(status.odometryError);

  await lab.show('status');
  const { setup } = await lab.state();
  const native = simulate(setup.world, setup.sensor, setup.seed);
  await expect(lab.at('hash')).toHaveText(native.state_hash);
  expect(native.sim_seconds).toBeCloseTo(status.time, 9);
});

test('a run that is over begins once more, with another seed', async ({ lab }) => {
  await lab.open();
  await lab.enter('arena');
  await lab.watch((s) => s.finished, 'exploration ends by itself', 60_000).toBe(true);
  const { seed } = (await lab.state()).setup;
  await lab.at('play-again').click();
  await lab.watch((s) => s.finished, 'another run begins').toBe(false);
  const { setup } = await lab.state();
  expect(setup.world).toBe('arena');
  expect(setup.seed).not.toBe(seed);
});

test('a robot that was stopped is said to be stopped, until it is asked for something else', async ({ lab, page }) => {
  await lab.open();
  await lab.watch((s) => s.distance, 'it drives').toBeGreaterThan(0.3);
  await lab.at('stop').click();
  await expect(lab.at('caption')).toContainText('Stopped');
  await page.keyboard.down('ArrowUp');
  await expect(lab.at('caption')).toContainText('You drive');
  await page.keyboard.up('ArrowUp');
  await page.keyboard.press('Escape');
  await expect(lab.at('caption')).toContainText('Stopped');
  await lab.at('mode-explore').click();
  await expect(lab.at('caption')).toContainText('Exploring');
});
