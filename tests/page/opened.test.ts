// A drive recorded by the bridge is opened in the page: complete, truncated, and damaged.
import { mkdtemp, readFile, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Status } from '../../www/src/protocol/frame.ts';
import { Bridge } from './bridge.ts';
import { expect, test as base } from './fixture.ts';

interface Drive {
  bytes: Buffer;
  /** The state of the page when the drive ended. */
  live: Status;
}

const test = base.extend<{ drive: Drive }>({
  // The robot explores behind a bridge that records, while the page maps it live.
  drive: async ({ lab, page, problems }, use) => {
    const folder = await mkdtemp(join(tmpdir(), 'slamlab-opened-'));
    const file = join(folder, 'drive.mcap');
    const bridge = await Bridge.start(['--source', 'sim:arena,lidar', '--record', file, '--token-file', join(folder, 'token')]);
    const token = (await readFile(join(folder, 'token'), 'utf8')).trim();
    await lab.open(`${bridge.url}#token=${token}`);
    await lab.at('lease').click();
    const armed = async () => (await lab.bridge())?.armed;
    await expect.poll(armed, { timeout: 30_000 }).toBe(true);
    await lab.at('mode-explore').click();
    await lab.watch((s) => s.distance, 'it explores').toBeGreaterThan(0.6);
    await page.keyboard.press('Escape');
    await expect.poll(armed, { timeout: 30_000 }).toBe(false);
    const { scans } = await lab.status();
    await lab.watch((s) => s.scans, 'it stands').toBeGreaterThan(scans + 10);
    const live = await lab.status();
    await bridge.stop();
    const bytes = await readFile(file);
    await rm(folder, { recursive: true });
    // The browser reports that the bridge is gone.
    problems.length = 0;
    await use({ bytes, live });
    problems.splice(0, problems.length, ...problems.filter((problem) => !/WebSocket|ERR_CONNECTION/.test(problem)));
  },
});

test('a recorded drive is mapped as it was live, and damage is reported', async ({ lab, drive }) => {
  test.setTimeout(180_000);
  await lab.open(process.env.SLAMLAB_URL);
  const open = async (name: string, buffer: Buffer): Promise<Status> => {
    await lab.show('run');
    await lab.at('file').setInputFiles({ name, mimeType: 'application/octet-stream', buffer });
    await expect.poll(async () => (await lab.state()).title, { message: `${name} is shown`, timeout: 30_000 }).toBe(name);
    await lab.watch((s) => s.finished, `${name} ends`).toBe(true);
    return lab.status();
  };
  const whole = await open('drive.mcap', drive.bytes);
  expect(whole.scans).toBeGreaterThanOrEqual(drive.live.scans - 1);
  expect(Math.hypot(whole.x - drive.live.x, whole.y - drive.live.y), 'it ends where it ended').toBeLessThan(0.05);
  expect(whole.distance, 'and came as far').toBeGreaterThan(0.5);
  expect(whole.knownArea).toBeGreaterThan(0.5);

  // The disk was full, or the bridge was killed.
  const cut = await open('cut.mcap', drive.bytes.subarray(0, Math.floor(drive.bytes.length * 0.6)));
  expect(cut.scans).toBeGreaterThan(5);
  expect(cut.scans).toBeLessThan(whole.scans);
  await lab.show('log');
  await expect(lab.at('log')).toContainText('cut off');

  const damaged = Buffer.from(drive.bytes);
  const middle = Math.floor(damaged.length / 2);
  damaged.fill(0xee, middle, middle + 40_000);
  const patched = await open('damaged.mcap', damaged);
  expect(patched.scans).toBeGreaterThan(cut.scans / 2);
  await lab.show('log');
  await expect(lab.at('log')).toContainText('are damaged');
});

test('a file of somebody else is refused in words, and the run goes on', async ({ lab }) => {
  await lab.open();
  await lab.show('run');
  const buffer = Buffer.concat([Buffer.from('\x89MCAP0\r\n', 'latin1'), Buffer.alloc(300, 7)]);
  await lab.at('file').setInputFiles({ name: 'foreign.mcap', mimeType: 'application/octet-stream', buffer });
  await expect(lab.at('toast')).toContainText('the file holds no scan');
  expect((await lab.state()).source).toBe('sim');
});
