// End to end: the page in a browser - WebSocket - bridge - pseudo-terminal - robot. Once with a
// robot that speaks the protocol, once with the real firmware in a simulated microcontroller; both
// carry a lidar. The robot explores, somebody pulls the cables, nothing moves until somebody drives
// again, exploration goes on to its end, and the map is compared with the truth. Once more without
// the lidar: then the real firmware scans with its rangers.
import { mkdtemp, readFile, rm, writeFile } from 'node:fs/promises';
import { existsSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { Bridge } from './bridge.ts';
import { expect, test as base } from './fixture.ts';
import type { Lab } from './lab.ts';
import { exploreUntil, type MapTruth, PATIENCE, together, turnByHand, WiredRobot, withRobot } from './wired.ts';

/** The firmware stops this long after the last command, by its registers and its own time, s. */
const WATCHDOG = 0.4;

const ROBOTS = [
  { name: 'a robot that speaks the protocol', program: 'wired_robot', more: [] },
  { name: 'the real firmware in a simulated microcontroller', program: 'rp6_sim', more: ['lidar'] },
] as const;

const hasFirmware = existsSync(process.env.SLAMLAB_RP6_SIM ?? '');

const test = base.extend<{ folder: string }>({
  folder: async ({}, use) => {
    const folder = await mkdtemp(join(tmpdir(), 'slamlab-wired-'));
    await use(folder);
    await rm(folder, { recursive: true });
  },
});

interface Run {
  robot: WiredRobot;
  lab: Lab;
  folder: string;
}

/** Somebody opens the page with the token. */
async function open({ robot, lab, folder }: Run): Promise<Bridge> {
  const token = join(folder, 'token');
  const bridge = await Bridge.start([...robot.sources, '--token-file', token]);
  await lab.page.goto(`${bridge.url}#token=${(await readFile(token, 'utf8')).trim()}`);
  return bridge;
}

/** Pulls the cables of a driving robot: it stops by itself, and stays where it is when they are
    back. Returns after what time its registers were 0, s; null if they already were, undefined if
    it has none. */
async function pullTheCables({ robot, lab }: Run): Promise<number | null | undefined> {
  const disarmed = async () => (await lab.bridge())?.armed === false;
  await robot.pull();
  await expect.poll(async () => (await robot.facts()).moves, { ...PATIENCE, message: 'it stops by itself' }).toBe(false);
  await expect.poll(disarmed, { ...PATIENCE, message: 'the page learns it' }).toBe(true);
  await expect.poll(async () => stands(robot), { ...PATIENCE, message: 'it has come to rest' }).toBe(true);
  const { pose, stopped_after } = await robot.facts();
  // Only the real firmware has registers; they were 0 already if it happened to stand.
  if (typeof stopped_after === 'number') expect(stopped_after, 's of the chip, by OCR1A and OCR1B').toBeLessThanOrEqual(WATCHDOG);
  await robot.plug();
  const { scans } = await lab.status();
  const isBack = async () => (await lab.bridge())?.devices.every((device) => device.state === 'sending');
  await expect.poll(isBack, { ...PATIENCE, message: 'it is found again' }).toBe(true);
  expect((await lab.bridge())?.battery, 'it talks').toBeGreaterThan(0);
  // Long enough for a command that outlived the cut to arrive: the page sends 20 a second.
  for await (const { moves } of robot.during(2)) expect(moves, 'nothing moves before somebody arms it').toBe(false);
  expect((await robot.facts()).pose).toEqual(pose);
  expect(await disarmed()).toBe(true);
  expect((await lab.status()).scans, 'the map stays').toBeGreaterThanOrEqual(scans);
  return stopped_after;
}

/** Whether its pose is the same after a quarter of a second of its own time. */
async function stands(robot: WiredRobot): Promise<boolean> {
  const before = (await robot.facts()).pose;
  for await (const _ of robot.during(0.25));
  return (await robot.facts()).pose.every((value, i) => value === before[i]);
}

async function mapTruth({ robot, lab, folder }: Run): Promise<MapTruth> {
  const paths = { pgm: join(folder, 'map.pgm'), yaml: join(folder, 'map.yaml') };
  for (const { name, buffer } of await lab.savedMap()) await writeFile(name.endsWith('.pgm') ? paths.pgm : paths.yaml, buffer);
  await lab.hidePanels();
  return robot.map(paths.pgm, paths.yaml);
}

async function positionError({ robot, lab }: Run): Promise<number> {
  const { x, y } = await lab.status();
  const [trueX, trueY] = (await robot.facts()).pose;
  return Math.hypot(x - trueX, y - trueY);
}

for (const { name, program, more } of ROBOTS) {
  test(`${name} explores arena over two serial lines; pulled cables stop it until it is armed again`, async ({ lab, folder }, info) => {
    test.skip(program === 'rp6_sim' && !hasFirmware, 'simavr or avr-gcc is not there');
    test.setTimeout(1_500_000);
    const robot = await WiredRobot.start(program, 'arena', ...more);
    await withRobot(robot, async () => {
      const run = { robot, lab, folder };
      const bridge = await open(run);
      const begun = await robot.facts();
      await exploreUntil(lab, robot, 'it is on its way', async (s) => s.distance > 0.5 && (await robot.facts()).moves);
      const stops = [await pullTheCables(run)];
      await together(robot, begun, async () => {
        await exploreUntil(lab, robot, 'exploration ends by itself', (s) => s.finished);
        const truth = await mapTruth(run);
        const [error, { contacts, seconds, behind, lost }] = [await positionError(run), await robot.facts()];
        const found = JSON.stringify({ ...truth, error, contacts, seconds, behind, lost });
        info.annotations.push({ type: 'map', description: found });
        console.log(found);
        expect(truth.explored).toBeGreaterThan(0.95);
        expect(truth.true_walls).toBeGreaterThan(0.95);
        expect(truth.found_walls).toBeGreaterThan(0.9);
        expect(error).toBeLessThan(0.1);
        expect(contacts).toBe(0);
      });
      expect((await robot.facts()).fault ?? null).toBeNull();
      // By hand from here on: the key is held during the whole disconnection.
      await turnByHand(lab, robot);
      stops.push(await pullTheCables(run));
      info.annotations.push({ type: 'stopped after, s', description: JSON.stringify(stops) });
      console.log(JSON.stringify({ stops }));
      if (program === 'rp6_sim') expect(stops.at(-1), 's of the chip: it turned when the cables were pulled').toEqual(expect.any(Number));
      await turnByHand(lab, robot);
      await lab.page.keyboard.up('ArrowLeft');
      await bridge.stop();
    });
  });
}

test('the real firmware without a lidar sweeps its rangers, drives and maps', async ({ lab, folder }, info) => {
  test.skip(!hasFirmware, 'simavr or avr-gcc is not there');
  test.setTimeout(900_000);
  const robot = await WiredRobot.start('rp6_sim', 'arena');
  await withRobot(robot, async () => {
    const run = { robot, lab, folder };
    const bridge = await open(run);
    const sweeps = Number(process.env.SLAMLAB_SWEEPS ?? 6);
    // Between two scans it sees nothing: contacts are counted, not judged.
    await exploreUntil(lab, robot, 'its sweeps come as scans, from place to place', (s) => s.scans > sweeps, ['bumper']);
    const truth = await mapTruth(run);
    const { seconds, behind, fault, contacts } = await robot.facts();
    const error = await positionError(run);
    info.annotations.push({ type: 'map', description: JSON.stringify({ ...truth, error, seconds, behind, contacts }) });
    console.log(JSON.stringify({ ...truth, error, seconds, behind, contacts }));
    expect(fault).toBeNull();
    expect(truth.explored, 'a few looks from nearly one place').toBeGreaterThan(0.1);
    expect(truth.true_walls).toBeGreaterThan(0.8);
    expect(error).toBeLessThan(0.3);
    await bridge.stop();
  });
});
