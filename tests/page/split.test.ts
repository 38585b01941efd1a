// The module in two parts (xtask/src/bin/split-module): however it is split, the result of a run is
// the same, to the bit.
import { execFileSync } from 'node:child_process';
import { mkdtemp, readFile, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { expect, test } from './fixture.ts';
import { simulate } from './simulate.ts';

const SPLITTER = process.env.SLAMLAB_SPLITTER ?? fileURLToPath(new URL('../../target/debug/split-module', import.meta.url));
const MODULE = fileURLToPath(new URL('../../www/pkg/slamlab_web_bg.wasm', import.meta.url));

/** More than the module has. */
const FUNCTIONS = 20_000;
const all = Array.from({ length: FUNCTIONS }, (_, number) => number);
/** Which functions are in the first part; the rest has the others. */
const SPLITS: readonly (readonly [string, number[]])[] = [
  ['in the rest is everything', []],
  ['every other function is in the rest', all.filter((number) => number % 2 === 0)],
  ['and the other half', all.filter((number) => number % 2 === 1)],
];

for (const [name, called] of SPLITS) {
  test(`arena is explored with the same bits as natively: ${name}`, async ({ lab, page }) => {
    test.setTimeout(120_000);
    const folder = await mkdtemp(join(tmpdir(), 'slamlab-split-'));
    await writeFile(join(folder, 'called.json'), JSON.stringify(called));
    execFileSync(SPLITTER, ['split', MODULE, join(folder, 'called.json'), folder]);
    const loaded: string[] = [];
    for (const part of ['slamlab_web_bg.wasm', 'slamlab_web_rest.wasm']) {
      const body = await readFile(join(folder, part));
      await page.route(`**/${part}*`, (route) => {
        loaded.push(part);
        return route.fulfill({ contentType: 'application/wasm', body });
      });
    }
    await lab.open();
    await lab.enter('arena');
    await lab.watch((s) => s.finished, 'exploration ends by itself', 60_000).toBe(true);
    await lab.show('status');
    const { setup } = await lab.state();
    await expect(lab.at('hash')).toHaveText(simulate(setup.world, setup.sensor, setup.seed).state_hash);
    expect(loaded).toEqual(['slamlab_web_bg.wasm', 'slamlab_web_rest.wasm']);
    await rm(folder, { recursive: true });
  });
}

test('parts of two modules are not joined, and that is said', async ({ lab, page, problems }) => {
  const folder = await mkdtemp(join(tmpdir(), 'slamlab-split-'));
  await writeFile(join(folder, 'called.json'), '[]');
  // A module of another build: the same with one more section, which browsers ignore.
  const other = Buffer.concat([await readFile(MODULE), Buffer.from([0, 2, 1, 0x78])]);
  await writeFile(join(folder, 'other.wasm'), other);
  execFileSync(SPLITTER, ['split', join(folder, 'other.wasm'), join(folder, 'called.json'), folder]);
  const body = await readFile(join(folder, 'slamlab_web_rest.wasm'));
  await page.route('**/slamlab_web_rest.wasm*', (route) => route.fulfill({ contentType: 'application/wasm', body }));
  await lab.open();
  await lab.at('save').click();
  await expect(lab.at('saving-about-map')).toContainText('of another version than this page. Reload the page.');
  const { time } = await lab.status();
  await lab.watch((s) => s.time, 'the run goes on').toBeGreaterThan(time + 1);
  problems.length = 0;
  await rm(folder, { recursive: true });
});
