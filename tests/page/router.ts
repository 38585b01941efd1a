// A Zenoh router, and a driver that uses it, each in a process of its own. The program is that of
// `cargo xtask report router`, named by SLAMLAB_ROUTER: its dependencies take minutes to compile,
// so only measurements have it.
import { spawn, type ChildProcess } from 'node:child_process';
import { once } from 'node:events';
import { createServer, type AddressInfo } from 'node:net';
import { createInterface } from 'node:readline';

/** The result of a drive. */
export interface Stopped {
  reason: string;
  /** Unix time, ms. */
  told_at_ms: number;
}

class Program {
  static readonly #started: Program[] = [];
  readonly #process: ChildProcess;
  readonly #lines: AsyncIterator<string>;

  constructor(...words: string[]) {
    const program = process.env.SLAMLAB_ROUTER;
    if (!program) throw new Error('SLAMLAB_ROUTER names no program; `cargo xtask report fleet` builds it');
    this.#process = spawn(program, words, { stdio: ['ignore', 'pipe', 'inherit'] });
    this.#lines = createInterface({ input: this.#process.stdout! })[Symbol.asyncIterator]();
    Program.#started.push(this);
  }

  /** Ends all of them, whatever the result of the test. */
  static async killAll(): Promise<void> {
    await Promise.all(this.#started.splice(0).map((program) => program.kill()));
  }

  async next(): Promise<string> {
    const { value, done } = await this.#lines.next();
    if (done) throw new Error('the program beside the router has ended');
    return value;
  }

  async expect(word: string): Promise<void> {
    const line = await this.next();
    if (line !== word) throw new Error(`expected ${word}, and it says ${line}`);
  }

  async kill(): Promise<void> {
    if (this.#process.exitCode !== null || this.#process.signalCode !== null) return;
    const gone = once(this.#process, 'exit');
    this.#process.kill('SIGKILL');
    await gone;
  }
}

export const killAll = (): Promise<void> => Program.killAll();

export class Router {
  private constructor(readonly endpoint: string, readonly kill: () => Promise<void>) {}

  /** At this endpoint, or at a free port. */
  static async start(endpoint?: string): Promise<Router> {
    const at = endpoint ?? `tcp/127.0.0.1:${await freePort()}`;
    const config = { mode: 'router', 'listen/endpoints': [at], 'scouting/multicast/enabled': false };
    const program = new Program('router', JSON.stringify(config));
    await program.expect('there');
    return new Router(at, () => program.kill());
  }
}

/** Drives a robot through the router by its token until it is stopped. */
export class Driver {
  readonly #program: Program;

  private constructor(...words: string[]) {
    this.#program = new Program('driver', ...words);
  }

  /** Resolves once the robot moves, by its odometry. */
  static async drives(router: Router, robot: string, token: string): Promise<Driver> {
    const driver = new Driver(router.endpoint, robot, token);
    await driver.#program.expect('there');
    await driver.#program.expect('driving');
    return driver;
  }

  /** Resolves once the robot stands, by its odometry. */
  async stopped(): Promise<Stopped> {
    const stopped = JSON.parse(await this.#program.next()) as Stopped;
    await this.#program.expect('still');
    return stopped;
  }
}

async function freePort(): Promise<number> {
  const server = createServer().listen(0, '127.0.0.1');
  await once(server, 'listening');
  const { port } = server.address() as AddressInfo;
  server.close();
  await once(server, 'close');
  return port;
}
