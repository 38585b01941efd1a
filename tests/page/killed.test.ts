// A browser that is killed while its person drives: a real process, with SIGKILL, so that the page
// cannot close its connection. The robot (the real firmware, by the registers of its motors) stops
// within the bounds, and the recording holds everything reported.
import { existsSync } from 'node:fs';
import { mkdtemp, readFile, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from '@playwright/test';
import { Bridge } from './bridge.ts';
import { expect, test } from './fixture.ts';
import { Lab } from './lab.ts';
import { PATIENCE, together, turnByHand, WiredRobot, withRobot } from './wired.ts';

/** The bridge's watchdog on driving, and the firmware's own, s: in the worst case one after the
    other. */
const BOUND = 0.25 + 0.4;
/** If the machine starves the bridge, a command may be as old as its driver allows, s, before the
    firmware's own watchdog begins. */
const BOUND_OF_A_STARVED_BRIDGE = 0.4 + 0.4;

test('a browser that is killed while it drives stops the robot, and the recording holds all', async ({ page }, info) => {
  test.skip(!existsSync(process.env.SLAMLAB_RP6_SIM ?? ''), 'simavr or avr-gcc is not there');
  test.setTimeout(300_000);
  const folder = await mkdtemp(join(tmpdir(), 'slamlab-killed-'));
  const [token, file] = [join(folder, 'token'), join(folder, 'drive.mcap')];
  const robot = await WiredRobot.start('rp6_sim', 'arena');
  const { args, executablePath } = info.project.use.launchOptions ?? {};
  const victim = await chromium.launchServer({ ...(args && { args }), ...(executablePath && { executablePath }) });
  const body = async () => {
    const bridge = await Bridge.start([...robot.sources, '--token-file', token, '--record', file]);
    const browser = await chromium.connect(victim.wsEndpoint());
    const lab = new Lab(await browser.newPage({ viewport: { width: 1280, height: 800 } }));
    await lab.page.goto(`${bridge.url}#token=${(await readFile(token, 'utf8')).trim()}`);
    await turnByHand(lab, robot);
    // The bridge reports it once a second.
    const recordedNow = async () => (await lab.bridge())?.recorded;
    await expect.poll(recordedNow, { ...PATIENCE, message: 'it is recorded' }).toBeGreaterThan(0);
    const recorded = (await recordedNow()) ?? NaN;
    const marked = await robot.facts();
    const before = performance.now();
    await robot.mark();
    victim.process().kill('SIGKILL');
    // Until then it drove; its own clock shows no more time than ours.
    const drove = (performance.now() - before) / 1000;
    await expect.poll(async () => (await robot.facts()).stopped_after ?? null, { ...PATIENCE, message: 'it stands' }).not.toBeNull();
    const { stopped_after } = await robot.facts();
    const judge = (bound: number) => expect(stopped_after, 's of the chip, by OCR1A and OCR1B').toBeLessThanOrEqual(bound + drove);
    judge(BOUND_OF_A_STARVED_BRIDGE);
    await together(robot, marked, async () => judge(BOUND));
    for await (const { moves } of robot.during(2)) expect(moves, 'and nothing moves it again').toBe(false);
    await bridge.stop();
    const messages = messagesIn(await readFile(file));
    const found = JSON.stringify({ stopped_after, recorded, messages });
    info.annotations.push({ type: 'killed', description: found });
    console.log(found);
    expect(messages, 'everything reported as recorded is there').toBeGreaterThanOrEqual(recorded);
  };
  try {
    await withRobot(robot, body);
  } finally {
    await victim.kill();
    await Bridge.stopAll();
    await rm(folder, { recursive: true });
  }
  expect(page.isClosed(), 'the browser of these tests is another').toBe(false);
});

/** The number of the bridge's own messages in a complete MCAP file, without those for other
    programs. Format by mcap.dev/spec: magic, records of a kind (4: a channel, 5: a message), a
    length and a content, magic. */
function messagesIn(file: Buffer): number {
  const magic = Buffer.from('\x89MCAP0\r\n', 'latin1');
  expect(file.subarray(0, 8)).toEqual(magic);
  expect(file.subarray(-8), 'it was finished').toEqual(magic);
  let [count, own] = [0, NaN];
  for (let at = 8; at < file.length - 8; at += 9 + Number(file.readBigUInt64LE(at + 1))) {
    const [kind, channel] = [file[at], file.readUInt16LE(at + 9)];
    if (kind === 4 && topicOf(file.subarray(at + 13)) === 'slamlab') own = channel;
    if (kind === 5 && channel === own) count += 1;
  }
  return count;
}

const topicOf = (text: Buffer): string => text.toString('utf8', 4, 4 + text.readUInt32LE(0));
