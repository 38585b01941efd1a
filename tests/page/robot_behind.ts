// A test of a robot behind a bridge of its own, with its token, in a temporary folder.
import { mkdtemp, readFile, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { BridgeState } from '../../www/src/protocol/devices.ts';
import { Bridge } from './bridge.ts';
import { expect, test } from './fixture.ts';

export { expect };

/** A bridge started with these flags besides that of its token file. */
export const behind = (flagsIn: (folder: string) => string[]) => test.extend<{ folder: string; bridge: Bridge; token: string; state: () => Promise<BridgeState | null> }>({
  folder: async ({}, use) => {
    const folder = await mkdtemp(join(tmpdir(), 'slamlab-bridge-'));
    await use(folder);
    await rm(folder, { recursive: true });
  },
  bridge: async ({ folder }, use) => {
    const bridge = await Bridge.start([...flagsIn(folder), '--token-file', join(folder, 'token')]);
    await use(bridge);
    await bridge.stop();
  },
  token: async ({ bridge, folder }, use) => {
    expect(bridge.url).toContain('http');
    await use((await readFile(join(folder, 'token'), 'utf8')).trim());
  },
  /** What the page knows of it. */
  state: async ({ lab }, use) => {
    await use(() => lab.bridge());
  },
});
