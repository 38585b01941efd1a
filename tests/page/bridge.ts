// Starts the bridge on a free port before the tests, tells them its address, and stops that very process after them.
import { spawn, type ChildProcess } from 'node:child_process';
import { once } from 'node:events';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';

const root = fileURLToPath(new URL('../..', import.meta.url));

export default async function startBridge(): Promise<() => Promise<void>> {
  const program = process.env.SLAMLAB_BRIDGE ?? `${root}/target/debug/slamlab-bridge`;
  const bridge = spawn(program, ['--port', '0', '--page', `${root}/www/dist`], { stdio: ['ignore', 'pipe', 'inherit'] });
  process.env.SLAMLAB_URL = await addressOf(bridge);
  return async () => {
    if (bridge.exitCode !== null) return;
    const gone = once(bridge, 'exit');
    bridge.kill('SIGTERM');
    await gone;
  };
}

async function addressOf(bridge: ChildProcess): Promise<string> {
  const failed = Promise.race([once(bridge, 'error'), once(bridge, 'exit')]).then(([why]) => {
    throw new Error(`the bridge did not start (${why}); build it by: cargo xtask build && cargo build -p slamlab-bridge`);
  });
  const announced = (async () => {
    for await (const line of createInterface({ input: bridge.stdout! })) {
      const url = /http:\/\/\S+/.exec(line)?.[0];
      if (url) return url;
    }
    return failed;
  })();
  return Promise.race([announced, failed]);
}
