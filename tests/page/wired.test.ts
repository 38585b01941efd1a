// End to end: the page in a browser - WebSocket - bridge - pseudo-terminal - robot. Once with a robot that speaks the protocol and
// carries a lidar, once with the real firmware in a simulated microcontroller, which sweeps its rangers. The robot explores,
// somebody pulls the cable, nothing moves until somebody drives again, and the map is compared with the truth.
import { mkdtemp, readFile, rm } from 'node:fs/promises';
import { existsSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Download, Page } from '@playwright/test';
import type { BridgeState, Status } from '../../www/src/protocol.ts';
import { Bridge } from './bridge.ts';
import { expect, test as base } from './fixture.ts';
import type { Lab } from './lab.ts';
import { type MapTruth, WiredRobot, withRobot } from './wired.ts';

/** A busy machine makes everything late; nothing here waits longer than it must. */
const PATIENCE = { timeout: 60_000, intervals: [100, 200, 400] };

const test = base.extend<{ folder: string; state: () => Promise<BridgeState | null> }>({
  folder: async ({}, use) => {
    const folder = await mkdtemp(join(tmpdir(), 'slamlab-wired-'));
    await use(folder);
    await rm(folder, { recursive: true });
  },
  state: async ({ page }, use) => {
    await use(() => page.evaluate(() => (window as unknown as { slamlab: { bridge: BridgeState | null } }).slamlab.bridge));
  },
});

interface Run {
  robot: WiredRobot;
  lab: Lab;
  page: Page;
  folder: string;
  state: () => Promise<BridgeState | null>;
}

/** Somebody opens the page with the token. */
async function open({ robot, lab, folder }: Run): Promise<Bridge> {
  const token = join(folder, 'token');
  const bridge = await Bridge.start([...robot.sources, '--token-file', token]);
  await lab.page.goto(`${bridge.url}#token=${(await readFile(token, 'utf8')).trim()}`);
  return bridge;
}

/** Takes the wheel, as soon as the robot's link is up. */
async function arm({ lab, state }: Run): Promise<void> {
  await expect(async () => {
    if (!(await state())?.armed) await lab.at('wheel').click();
    await expect.poll(async () => (await state())?.armed, { timeout: 3_000 }).toBe(true);
  }).toPass(PATIENCE);
}

/** Sends it exploring. */
async function explore(run: Run): Promise<void> {
  await arm(run);
  await run.lab.at('mode-explore').click();
}

/** Explores until something is so. A machine that starves the robot looks to the bridge like a robot that fell silent: it is armed again. */
async function exploreUntil(run: Run, message: string, done: (status: Status) => boolean): Promise<void> {
  const look = async () => {
    const status = await run.lab.status();
    if (done(status)) return true;
    if (!(await run.state())?.armed || status.mode !== 'explore') await explore(run);
    return false;
  };
  await expect.poll(look, { timeout: 400_000, intervals: [250], message }).toBe(true);
}

/** Pulls the cable of a robot that drives: it stops by itself, and stays where it is when the cable is back. */
async function pullTheCable(run: Run): Promise<void> {
  const { robot, lab, state } = run;
  const drives = async () => {
    if (!(await state())?.armed) await explore(run);
    return (await robot.facts()).moves;
  };
  await expect.poll(drives, { ...PATIENCE, message: 'it drives', intervals: [20] }).toBe(true);
  await robot.pull();
  await expect.poll(async () => (await robot.facts()).moves, { ...PATIENCE, message: 'it stops by itself' }).toBe(false);
  await expect.poll(async () => (await state())?.armed, { ...PATIENCE, message: 'the page learns it' }).toBe(false);
  await expect.poll(async () => stands(robot), { ...PATIENCE, message: 'it has come to rest' }).toBe(true);
  const stood = (await robot.facts()).pose;
  await robot.plug();
  const { scans } = await lab.status();
  const isBack = async () => (await state())?.devices.every((device) => device.state === 'sending');
  await expect.poll(isBack, { ...PATIENCE, message: 'it is found again' }).toBe(true);
  const battery = (await state())?.battery;
  expect(battery, 'it talks').toBeGreaterThan(0);
  // Long enough for an order that outlived the cut: the page sends 20 a second.
  for (let look = 0; look < 40; look++) expect((await robot.facts()).moves, 'nothing moves before somebody arms it').toBe(false);
  expect((await robot.facts()).pose).toEqual(stood);
  expect((await state())?.armed).toBe(false);
  expect((await lab.status()).scans, 'the map stays').toBeGreaterThanOrEqual(scans);
}

/** Two looks see it at the same place. */
async function stands(robot: WiredRobot): Promise<boolean> {
  const before = (await robot.facts()).pose;
  await new Promise((done) => setTimeout(done, 100));
  return (await robot.facts()).pose.every((value, i) => value === before[i]);
}

async function mapTruth({ robot, lab, page, folder }: Run): Promise<MapTruth> {
  await lab.show('run');
  const downloads: Download[] = [];
  const note = (download: Download) => downloads.push(download);
  page.on('download', note);
  await lab.at('save-map').click();
  await expect.poll(() => downloads.length, 'two files come').toBe(2);
  page.off('download', note);
  const paths = { pgm: join(folder, 'map.pgm'), yaml: join(folder, 'map.yaml') };
  for (const download of downloads) await download.saveAs(download.suggestedFilename().endsWith('.pgm') ? paths.pgm : paths.yaml);
  await lab.hidePanels();
  return robot.map(paths.pgm, paths.yaml);
}

async function positionError({ robot, lab }: Run): Promise<number> {
  const { x, y } = await lab.status();
  const [trueX, trueY] = (await robot.facts()).pose;
  return Math.hypot(x - trueX, y - trueY);
}

test('a robot with a lidar explores arena over two serial lines; a pulled cable stops it until it is armed again', async ({ lab, page, folder, state }, info) => {
  test.skip(info.project.name !== 'desktop', 'the robot is the same for a phone');
  test.setTimeout(600_000);
  const robot = await WiredRobot.start('wired_robot', 'arena');
  await withRobot(robot, async () => {
    const run = { robot, lab, page, folder, state };
    const bridge = await open(run);
    await explore(run);
    await exploreUntil(run, 'exploration ends by itself', (s) => s.finished);
    const truth = await mapTruth(run);
    const error = await positionError(run);
    info.annotations.push({ type: 'map', description: JSON.stringify({ ...truth, error }) });
    console.log(JSON.stringify({ ...truth, error }));
    expect(truth.explored).toBeGreaterThan(0.95);
    expect(truth.true_walls).toBeGreaterThan(0.95);
    expect(truth.found_walls).toBeGreaterThan(0.9);
    expect(error).toBeLessThan(0.1);
    expect((await robot.facts()).contacts).toBe(0);
    // By hand from here on: it turns while the key is held, and the key is held all through the cut.
    await page.keyboard.down('ArrowLeft');
    await pullTheCable(run);
    await page.keyboard.up('ArrowLeft');
    await arm(run);
    await page.keyboard.down('ArrowLeft');
    await expect.poll(async () => (await robot.facts()).moves, { ...PATIENCE, message: 'armed again it turns again' }).toBe(true);
    await page.keyboard.up('ArrowLeft');
    await bridge.stop();
  });
});

test('the real firmware sweeps, drives and maps in a simulated microcontroller; a pulled cable stops its motors within 400 ms', async ({ lab, page, folder, state }, info) => {
  test.skip(info.project.name !== 'desktop', 'the robot is the same for a phone');
  test.skip(!existsSync(process.env.SLAMLAB_RP6_SIM ?? ''), 'simavr or avr-gcc is not there');
  test.setTimeout(600_000);
  const robot = await WiredRobot.start('rp6_sim', 'arena');
  await withRobot(robot, async () => {
    const run = { robot, lab, page, folder, state };
    const bridge = await open(run);
    await explore(run);
    await exploreUntil(run, 'its sweeps come as scans', (s) => s.scans > 0);
    await pullTheCable(run);
    const { stopped_after } = await robot.facts();
    expect(stopped_after, 's of the chip, by OCR1A and OCR1B').toBeLessThanOrEqual(0.4);
    const { scans } = await lab.status();
    const sweeps = Number(process.env.SLAMLAB_SWEEPS ?? 5);
    await exploreUntil(run, 'it goes on from place to place', (s) => s.scans > scans + sweeps);
    const truth = await mapTruth(run);
    const { seconds, behind, fault, contacts } = await robot.facts();
    const error = await positionError(run);
    info.annotations.push({ type: 'map', description: JSON.stringify({ ...truth, error, seconds, behind, stopped_after, contacts }) });
    console.log(JSON.stringify({ ...truth, error, seconds, behind, stopped_after, contacts }));
    expect(fault).toBeNull();
    expect(truth.explored, 'a few looks from nearly one place').toBeGreaterThan(0.1);
    expect(truth.true_walls).toBeGreaterThan(0.8);
    expect(error).toBeLessThan(0.3);
    await bridge.stop();
  });
});
