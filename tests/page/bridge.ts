// Starts the bridge on a free port before the tests, tells them its address, and stops that same
// process after them. Tests of a robot behind a bridge start one more of their own.
import { execFile, spawn, type ChildProcess } from 'node:child_process';
import { once } from 'node:events';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';

const root = fileURLToPath(new URL('../..', import.meta.url));
const PROGRAM = process.env.SLAMLAB_BRIDGE ?? `${root}/target/debug/slamlab-bridge`;

export default async function startBridge(): Promise<() => Promise<void>> {
  const bridge = await Bridge.start();
  process.env.SLAMLAB_URL = bridge.url;
  return () => bridge.stop();
}

/** A bridge for one test. */
export class Bridge {
  /** Bridges that this process started. */
  static readonly #started: Bridge[] = [];

  url = '';

  private constructor(private readonly process: ChildProcess) {}

  /** Starts one with these flags besides those of the page, on a free port unless one is given. */
  static async start(flags: string[] = [], port = '0'): Promise<Bridge> {
    const page = flags.includes('--page') ? [] : ['--page', `${root}/www/dist`];
    const bridge = new Bridge(spawn(PROGRAM, ['--port', port, ...page, ...flags], { stdio: ['ignore', 'pipe', 'inherit'] }));
    // Before it has printed anything, so that one that never does is ended too.
    this.#started.push(bridge);
    bridge.url = await addressOf(bridge.process);
    return bridge;
  }

  /** Ends what a failed test left behind: its bridge would look for its robot's port for ever,
      which may soon be that of the next test. */
  static async stopAll(): Promise<void> {
    await Promise.all(this.#started.splice(0).map((bridge) => bridge.stop('SIGKILL')));
  }

  /** The output of the program with these arguments, once it has ended. */
  static async run(words: string[]): Promise<string> {
    const { stdout } = await promisify(execFile)(PROGRAM, words);
    return stdout;
  }

  get port(): string {
    return new URL(this.url).port;
  }

  async stop(signal: NodeJS.Signals = 'SIGTERM'): Promise<void> {
    if (this.process.exitCode !== null || this.process.signalCode !== null) return;
    const gone = once(this.process, 'exit');
    this.process.kill(signal);
    await gone;
  }
}

async function addressOf(bridge: ChildProcess): Promise<string> {
  const failed = Promise.race([once(bridge, 'error'), once(bridge, 'exit')]).then(([why]) => {
    throw new Error(`the bridge did not start (${why}); build it by: cargo xtask build && cargo build -p slamlab-bridge`);
  });
  const announced = (async () => {
    for await (const line of createInterface({ input: bridge.stdout! })) {
      const url = /https?:\/\/\S+/.exec(line)?.[0];
      if (url) return url;
    }
    return failed;
  })();
  return Promise.race([announced, failed]);
}
