// A bridge of its own for a test, on a free port, with a simulated robot behind it.
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { mkdtemp, readFile, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';

const root = fileURLToPath(new URL('../..', import.meta.url));

/** Starts it with these flags; `{ port, token, stop }`. Needs a built bridge: cargo build -p
    slamlab-bridge. */
export async function startBridge(flags) {
  const folder = await mkdtemp(join(tmpdir(), 'slamlab-interop-'));
  const program = process.env.SLAMLAB_BRIDGE ?? `${root}/target/debug/slamlab-bridge`;
  // Any folder with an index.html: the page is not what is tested.
  const page = process.env.SLAMLAB_PAGE ?? `${root}/www`;
  const args = ['--port', '0', '--page', page, '--source', 'sim:arena,lidar', '--token-file', join(folder, 'token'), ...flags];
  const bridge = spawn(program, args, { stdio: ['ignore', 'pipe', 'inherit'] });
  for await (const line of createInterface({ input: bridge.stdout })) {
    const url = /http:\/\/\S+/.exec(line)?.[0];
    if (!url) continue;
    const token = (await readFile(join(folder, 'token'), 'utf8')).trim();
    return {
      port: new URL(url).port,
      token,
      async stop() {
        const gone = once(bridge, 'exit');
        bridge.kill('SIGTERM');
        await gone;
        await rm(folder, { recursive: true });
      },
    };
  }
  throw new Error('the bridge did not start');
}
