// A robot on a pseudo-terminal, in a program of its own: its cable can be pulled, and it tells what
// is true. And who takes its wheel.
import { spawn, type ChildProcess } from 'node:child_process';
import { once } from 'node:events';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';
import { expect, test } from '@playwright/test';
import type { Status } from '../../www/src/protocol/frame.ts';
import type { Lab } from './lab.ts';

const root = fileURLToPath(new URL('../..', import.meta.url));

/** What is true of the robot. */
export interface Facts {
  /** Map frame: m, m, rad. */
  pose: [number, number, number];
  /** Whether its motors are driven: for the real firmware, by the chip's compare registers. */
  moves: boolean;
  contacts: number;
  /** Real time that its own and its lidar's have lost, because the machine let them wait for the
      processor, s. */
  lost: number;
  /** Its own time, s: where the machine starves it, less passes than outside. */
  seconds: number;
  /** Real firmware: s of its own time from the pull of the cable, or a mark, until the registers
      were 0. */
  stopped_after?: number | null;
  /** Real firmware: the real time that it lost, s. */
  behind?: number;
  fault?: string | null;
}

/** How true a map is; see tests/src/map_truth.rs. */
export interface MapTruth {
  explored: number;
  true_walls: number;
  wall_error: number;
  found_walls: number;
  error?: string;
}

export class WiredRobot {
  /** Path of each port, by the name of its kind of source. */
  ports: Record<string, string> = {};
  readonly #process: ChildProcess;
  readonly #lines: AsyncIterator<string>;
  /** What a starved machine left unproved. */
  readonly unproved: string[] = [];

  private constructor(process: ChildProcess) {
    this.#process = process;
    // What a test's own process inherits is shown nowhere.
    process.stderr!.on('data', (said) => console.log(`the robot: ${String(said).trim()}`));
    this.#lines = createInterface({ input: process.stdout! })[Symbol.asyncIterator]();
  }

  /** `wired_robot` speaks the protocol and carries a lidar; `rp6_sim` runs the real firmware, and
      carries one where `lidar` follows the world. */
  static async start(program: 'wired_robot' | 'rp6_sim', world: string, ...more: string[]): Promise<WiredRobot> {
    const known = { wired_robot: process.env.SLAMLAB_WIRED_ROBOT, rp6_sim: process.env.SLAMLAB_RP6_SIM };
    const built = { wired_robot: 'examples/wired_robot', rp6_sim: 'rp6_sim' };
    const path = known[program] ?? `${root}/target/debug/${built[program]}`;
    const robot = new WiredRobot(spawn(path, [world, ...more], { stdio: ['pipe', 'pipe', 'pipe'] }));
    robot.ports = await robot.#next<Record<string, string>>();
    return robot;
  }

  /** The arguments with which a bridge finds it. */
  get sources(): string[] {
    return Object.entries(this.ports).flatMap(([kind, path]) => ['--source', `${kind}:${path}`]);
  }

  async pull(): Promise<void> {
    await this.#ask('pull');
  }

  async plug(): Promise<void> {
    await this.#ask('plug');
  }

  /** Something happens that should stop it: how long it takes is a fact. Real firmware only. */
  async mark(): Promise<void> {
    await this.#ask('mark');
  }

  /** What is true of it, again and again for so long by its own time, s. */
  async *during(seconds: number): AsyncGenerator<Facts> {
    const end = (await this.facts()).seconds + seconds;
    for (let facts = await this.facts(); facts.seconds < end; facts = await this.facts()) {
      yield facts;
      await new Promise((done) => setTimeout(done, 5));
    }
  }

  async facts(): Promise<Facts> {
    return this.#ask<Facts>('facts');
  }

  async map(pgm: string, yaml: string): Promise<MapTruth> {
    return this.#ask<MapTruth>(`map ${pgm} ${yaml}`);
  }

  async stop(): Promise<void> {
    if (this.#process.exitCode !== null) return;
    const gone = once(this.#process, 'exit');
    this.#process.kill();
    await gone;
  }

  async #ask<T>(command: string): Promise<T> {
    this.#process.stdin!.write(`${command}\n`);
    return this.#next<T>();
  }

  async #next<T>(): Promise<T> {
    const { value, done } = await this.#lines.next();
    if (done) throw new Error('the robot has ended; it is built by: cargo xtask test page');
    return JSON.parse(value) as T;
  }
}

/** A busy machine makes everything late; nothing here waits longer than it must. */
export const PATIENCE = { timeout: 60_000, intervals: [100, 200, 400] };

/** All devices send, and have for a while: a robot whose link has just come up takes no order to
    move before none came for 0.3 s (core/src/device/rp6.rs). Whoever drives at once and goes on
    would be waited for in vain. */
async function settled(lab: Lab, robot: WiredRobot): Promise<void> {
  const devices = async () => (await lab.bridge())?.devices.map((device) => device.state).join();
  await expect.poll(devices, { ...PATIENCE, message: 'all devices send' }).toMatch(/^sending(,sending)*$/);
  for await (const _ of robot.during(0.6));
}

/** Takes the wheel, where it is not taken, as soon as the robot's link is up. */
export async function arm(lab: Lab, robot: WiredRobot): Promise<void> {
  if ((await lab.bridge())?.armed) return;
  await settled(lab, robot);
  await expect(async () => {
    if (!(await lab.bridge())?.armed) await lab.at('lease').click();
    await expect.poll(async () => (await lab.bridge())?.armed, { timeout: 3_000 }).toBe(true);
  }).toPass(PATIENCE);
}

/** Turns by hand: the key is held from here on. Where the robot does not turn yet, its driver is
    armed and the key pressed again, as a person would. */
export async function turnByHand(lab: Lab, robot: WiredRobot): Promise<void> {
  const press = async () => {
    await lab.page.keyboard.up('ArrowLeft');
    await settled(lab, robot);
    await arm(lab, robot);
    await lab.page.keyboard.down('ArrowLeft');
  };
  const turns = async () => {
    const { moves } = await robot.facts();
    if (!moves) await press();
    return moves;
  };
  await press();
  await expect.poll(turns, { ...PATIENCE, intervals: [500, 2_000], message: 'it turns while the key is held' }).toBe(true);
}

/** Reasons for which a robot may stand before it was armed, or on a machine that starves it, its
    bridge or the page. */
const UNARMED = ['', 'start', 'silence', 'link', 'lease-expired', 'driver-gone'];

/** Sends it exploring. */
async function explore(lab: Lab, robot: WiredRobot): Promise<void> {
  await arm(lab, robot);
  await lab.at('mode-explore').click();
}

/** Explores until something is so. A machine that starves the robot looks to its rules like a robot
    that fell silent: it is armed again. Whatever else disarms it is a fault, but for the reasons
    `others`. */
export async function exploreUntil(lab: Lab, robot: WiredRobot, message: string, done: (status: Status) => boolean | Promise<boolean>, others: readonly string[] = []): Promise<void> {
  const reasons: string[] = [];
  const look = async () => {
    const status = await lab.status();
    if (await done(status)) return true;
    const state = await lab.bridge();
    const [armed, reason] = [state?.armed ?? false, state?.reason ?? ''];
    if (!armed && ![...UNARMED, ...others].includes(reason)) {
      reasons.push(reason);
      return true;
    }
    if (!armed || status.mode !== 'explore') await explore(lab, robot);
    return false;
  };
  await expect.poll(look, { timeout: 600_000, intervals: [250], message }).toBe(true);
  expect(reasons, `${message}: nothing but a slow machine disarms it`).toEqual([]);
}

/** Judges what depends on several programs being in time: what robot and lidar measured, when a
    bridge stopped its robot. Where the machine kept robot or lidar waiting meanwhile, their times
    went apart (tests/src/devices/socket.rs), and what they saw is not of one world: a failure
    proves nothing then. `lost` is what they had lost when it began. */
export async function together(robot: WiredRobot, { lost: before }: Pick<Facts, 'lost'>, body: () => Promise<void>): Promise<void> {
  try {
    await body();
  } catch (error) {
    const lost = (await robot.facts()).lost - before;
    if (lost < 0.01) throw error;
    const why = `robot and lidar waited ${lost.toFixed(2)} s too long for the processor: ${error instanceof Error ? error.message.split('\n')[0] : String(error)}`;
    console.log(`not proved: ${why}`);
    robot.unproved.push(why);
  }
}

/** Runs it, and ends the robot after it. What a starved machine left unproved makes a test whose
    other claims all hold a skipped one; in CI, where nothing may be skipped, it is tried once
    more. */
export async function withRobot(robot: WiredRobot, body: () => Promise<void>): Promise<void> {
  try {
    await body();
  } finally {
    await robot.stop();
  }
  if (process.env.CI) expect(robot.unproved, 'everything is proved').toEqual([]);
  test.skip(robot.unproved.length > 0, robot.unproved.join('; '));
}
