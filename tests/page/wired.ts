// A robot on a pseudo-terminal, in a program of its own: its cable can be pulled, and it reports
// the truth. Also: how to drive it.
import { spawn, type ChildProcess } from 'node:child_process';
import { once } from 'node:events';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';
import { expect, test } from '@playwright/test';
import type { Status } from '../../www/src/protocol/frame.ts';
import type { Lab } from './lab.ts';

const root = fileURLToPath(new URL('../..', import.meta.url));

/** The truth about the robot. */
export interface Facts {
  /** Map frame: m, m, rad. */
  pose: [number, number, number];
  /** Whether its motors are driven: for the real firmware, by the chip's compare registers. */
  moves: boolean;
  contacts: number;
  /** Real time that it and its lidar have lost because the machine kept them waiting for the
      processor, s. */
  lost: number;
  /** Its own time, s: on a starved machine it passes more slowly than real time. */
  seconds: number;
  /** Real firmware: s of its own time from the pull of the cable, or a mark, until the registers
      were 0. */
  stopped_after?: number | null;
  /** Real firmware: the real time that it lost, s. */
  behind?: number;
  fault?: string | null;
}

/** How accurate a map is; see tests/src/map_truth.rs. */
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
  /** Claims that could not be proved on a starved machine. */
  readonly unproved: string[] = [];

  private constructor(process: ChildProcess) {
    this.#process = process;
    // What the process of a test inherits is not shown anywhere.
    process.stderr!.on('data', (said) => console.log(`the robot: ${String(said).trim()}`));
    this.#lines = createInterface({ input: process.stdout! })[Symbol.asyncIterator]();
  }

  /** `wired_robot` speaks the protocol and carries a lidar; `rp6_sim` runs the real firmware, and
      carries one if `lidar` follows the world. */
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

  /** Marks an event that should stop it: the time until then becomes a fact. Real firmware only. */
  async mark(): Promise<void> {
    await this.#ask('mark');
  }

  /** The truth about it, again and again for so long by its own time, s. */
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

/** A busy machine delays everything; nothing here waits longer than it must. */
export const PATIENCE = { timeout: 60_000, intervals: [100, 200, 400] };

/** Waits until all devices have been sending for a while. A robot whose link has just come up
    accepts no command to move until there was none for 0.3 s (core/src/device/rp6.rs), so a driver
    that starts at once and goes on would wait in vain. */
async function settled(lab: Lab, robot: WiredRobot): Promise<void> {
  const devices = async () => (await lab.bridge())?.devices.map((device) => device.state).join();
  await expect.poll(devices, { ...PATIENCE, message: 'all devices send' }).toMatch(/^sending(,sending)*$/);
  for await (const _ of robot.during(0.6));
}

/** Takes the right to drive, if it is free, as soon as the robot's link is up. */
export async function arm(lab: Lab, robot: WiredRobot): Promise<void> {
  if ((await lab.bridge())?.armed) return;
  await settled(lab, robot);
  await expect(async () => {
    if (!(await lab.bridge())?.armed) await lab.at('lease').click();
    await expect.poll(async () => (await lab.bridge())?.armed, { timeout: 3_000 }).toBe(true);
  }).toPass(PATIENCE);
}

/** Turns by hand: the key is held from here on. While the robot does not turn, its driver is armed
    and the key pressed again, as a person would. */
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

/** Reasons for which a robot may stand before it is armed, or on a machine that starves it, its
    bridge or the page. */
const UNARMED = ['', 'start', 'silence', 'link', 'lease-expired', 'driver-gone'];

/** Sends it exploring. */
async function explore(lab: Lab, robot: WiredRobot): Promise<void> {
  await arm(lab, robot);
  await lab.at('mode-explore').click();
}

/** Explores until a condition holds. To its rules, a robot on a starved machine looks like one that
    fell silent: it is armed again. Any other reason for disarming is a failure, except for
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

/** Judges what depends on the timing of several programs: what robot and lidar measured, when a
    bridge stopped its robot. If the machine kept robot or lidar waiting meanwhile, their clocks
    diverged (tests/src/devices/socket.rs), and their readings are not of one world: then a failure
    proves nothing. `lost` is the time that they had lost at the start. */
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

/** Runs it, and ends the robot after it. A test with claims left unproved on a starved machine
    counts as skipped if its other claims hold; in CI, where nothing may be skipped, it is tried
    once more. */
export async function withRobot(robot: WiredRobot, body: () => Promise<void>): Promise<void> {
  try {
    await body();
  } finally {
    await robot.stop();
  }
  if (process.env.CI) expect(robot.unproved, 'everything is proved').toEqual([]);
  test.skip(robot.unproved.length > 0, robot.unproved.join('; '));
}
