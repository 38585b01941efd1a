// A robot behind a bridge: the page finds it by itself, watches without the token, drives with it,
// and survives a restart of the bridge.
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { Bridge } from './bridge.ts';
import { behind, expect } from './robot_behind.ts';

const SOURCE = ['--source', 'sim:office,lidar'];

const test = behind(() => SOURCE);

test('without the token a page watches: it maps, and anyone may stop', async ({ lab, page, bridge, state }) => {
  await lab.open(bridge.url);
  await lab.watch((s) => s.scans, 'scans come by themselves').toBeGreaterThan(5);
  expect((await lab.state()).source).toBe('bridge');
  await lab.watch((s) => s.features, 'walls are found').toBeGreaterThan(2);
  await expect(lab.at('lease')).toBeDisabled();
  await lab.show('run');
  await expect(lab.at('bridge-state')).toContainText('only watches');
  await expect(page.getByText('simulated rp6 with lidar')).toBeVisible();
  await lab.hidePanels();
  await lab.at('stop').click();
  await expect.poll(async () => (await state())?.reason).toBe('stop');
  await expect(lab.at('toast'), 'who only watches is told').toContainText('Stop was sent');
  await expect(lab.at('mode-cycle'), 'and does not choose how it drives').toBeDisabled();
});

test('a bridge that is private shows its robot to who has the token, and to nobody else', async ({ lab, page, folder, state, problems }) => {
  const file = join(folder, 'private');
  const bridge = await Bridge.start([...SOURCE, '--private', '--token-file', file]);
  const token = (await readFile(file, 'utf8')).trim();
  // There is no effect to wait for: it is refused.
  await page.goto(bridge.url);
  await expect.poll(async () => (await state())?.connection).toBe('refused');
  await lab.open(`${bridge.url}?again#token=${token}`);
  await lab.watch((s) => s.scans, 'scans come').toBeGreaterThan(5);
  // Without the token, what is behind the bridge is not shown, and the browser notes that.
  expect(problems.length).toBeGreaterThan(0);
  for (const problem of problems.splice(0)) expect(problem).toContain('403');
  await bridge.stop();
});

test('a page says whose right it has, and what became of it when that is taken away', async ({ lab, bridge, token, folder, state }) => {
  const right = async (words: string[]) => Bridge.run(['token', ...words, '--token-file', join(folder, 'token')]);
  const secretOf = (said: string) => /#token=(\w+)/.exec(said)?.[1] ?? '';
  const anna = secretOf(await right(['add', 'anna', '--role', 'driver']));
  const wall = secretOf(await right(['add', 'wall', '--role', 'watcher']));
  expect(anna).not.toBe('');
  expect(anna).not.toBe(token);
  // Until the running bridge has read the file again, it does not know this name.
  let tries = 0;
  await expect(async () => {
    tries += 1;
    await lab.open(`${bridge.url}?${tries}#token=${anna}`);
    expect((await state())?.connection).toBe('open');
  }).toPass();
  await lab.show('run');
  await expect(lab.at('bridge-right')).toHaveText('anna: may drive');
  await lab.hidePanels();
  await lab.at('lease').click();
  await expect.poll(async () => (await state())?.armed).toBe(true);
  await right(['revoke', 'anna']);
  await expect.poll(async () => (await state())?.connection).toBe('refused');
  await lab.show('run');
  await expect(lab.at('bridge-state')).toContainText('was taken away or changed');
  await lab.open(`${bridge.url}?again#token=${wall}`);
  await lab.show('run');
  await expect(lab.at('bridge-state')).toContainText('so says the right of wall');
  await expect(lab.at('lease')).toBeDisabled();
});

test('with the token it drives by hand and by itself, and Stop ends it', { tag: '@phone' }, async ({ lab, page, bridge, token, state, hasTouch }) => {
  await lab.open(`${bridge.url}#token=${token}`);
  expect(page.url(), 'the token does not stay in the address').not.toContain('token');
  await expect(lab.at('mode-explore'), 'nothing moves before somebody takes the wheel').toBeDisabled();
  await lab.at('lease').click();
  await expect.poll(async () => (await state())?.armed).toBe(true);
  if (!hasTouch) {
    const before = await lab.status();
    await page.keyboard.down('ArrowUp');
    await lab.watch((s) => Math.hypot(s.x - before.x, s.y - before.y), 'it goes while the key is held').toBeGreaterThan(0.1);
    await page.keyboard.up('ArrowUp');
    await page.waitForTimeout(700);
    const stood = await lab.status();
    await page.waitForTimeout(700);
    const stands = await lab.status();
    expect(Math.hypot(stands.x - stood.x, stands.y - stood.y), 'and stands when it is let go').toBeLessThan(0.01);
  }
  const { distance } = await lab.status();
  await lab.at('mode-explore').click();
  await lab.watch((s) => s.distance, 'it explores').toBeGreaterThan(distance + 0.5);
  await page.keyboard.press('Escape');
  await expect.poll(async () => (await state())?.armed).toBe(false);
  await lab.watch((s) => s.mode, 'and forgets its errand').toBe('manual');
  await expect(lab.at('mode-explore')).toBeDisabled();
});

test('the emergency stop is latched until it is undone, and nothing moves by that', async ({ lab, page, bridge, token, state }) => {
  await lab.open(`${bridge.url}#token=${token}`);
  await lab.at('lease').click();
  await expect.poll(async () => (await state())?.armed).toBe(true);
  await lab.at('mode-explore').click();
  await lab.watch((s) => s.distance, 'it explores').toBeGreaterThan(0.1);
  await lab.show('run');
  await lab.at('emergency').click();
  await expect.poll(async () => (await state())?.emergency).toBe(true);
  expect((await state())?.armed).toBe(false);
  await lab.at('emergency').click();
  await expect.poll(async () => (await state())?.emergency).toBe(false);
  expect((await state())?.armed, 'undoing arms nothing').toBe(false);
});

test('a bridge that is killed is found again, and the map stays', async ({ lab, page, folder, state, problems }) => {
  const flags = [...SOURCE, '--token-file', join(folder, 'token')];
  const first = await Bridge.start(flags);
  await lab.open(first.url);
  await lab.watch((s) => s.scans, 'it scans').toBeGreaterThan(10);
  const { blocks } = await lab.state();
  await first.stop('SIGKILL');
  await expect.poll(async () => (await state())?.connection).not.toBe('open');
  await lab.show('run');
  await expect(lab.at('bridge-state')).toContainText('map stays');
  await expect(lab.at('caption').locator('.dot'), 'no green light for a robot that is not heard').toHaveClass(/\boff\b/);
  await lab.hidePanels();
  await lab.at('stop').click();
  await expect(lab.at('toast')).toContainText('this Stop does not reach the robot');
  const { scans } = await lab.status();
  const second = await Bridge.start(flags, first.port);
  await expect.poll(async () => (await state())?.connection, { timeout: 20_000 }).toBe('open');
  await lab.watch((s) => s.scans, 'scans go on').toBeGreaterThan(scans + 5);
  expect((await lab.state()).blocks).toBeGreaterThanOrEqual(blocks);
  await second.stop();
  // The browser reports each failed attempt.
  problems.length = 0;
});
