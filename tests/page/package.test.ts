// The core's modules as an npm package: installed from its packed file, used from Node and from a
// page, as in its README.
import { execFile } from 'node:child_process';
import { existsSync } from 'node:fs';
import { mkdtemp, readFile, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { FileServer } from './file_server.ts';
import { expect, test as base } from './fixture.ts';

const run = promisify(execFile);
const packed = process.env.SLAMLAB_NPM ?? fileURLToPath(new URL('../../target/npm/slamlab-0.1.0.tgz', import.meta.url));
const tsc = fileURLToPath(new URL('node_modules/typescript/bin/tsc', import.meta.url));

/** The project of somebody who has just installed the package. */
const test = base.extend<{ project: string }>({
  project: async ({}, use) => {
    const folder = await mkdtemp(join(tmpdir(), 'slamlab-npm-'));
    await writeFile(join(folder, 'package.json'), '{ "private": true, "type": "module" }');
    await run('npm', ['install', '--offline', '--no-audit', '--no-fund', '--ignore-scripts', packed], { cwd: folder });
    await use(folder);
    await rm(folder, { recursive: true });
  },
});
test.skip(!existsSync(packed), `there is no ${packed}: cargo xtask npm makes it`);

const exampleOf = async (project: string): Promise<string> => {
  const readme = await readFile(join(project, 'node_modules/slamlab/README.md'), 'utf8');
  return /```js\n([^]*?)```/.exec(readme)![1]!;
};

test('the example of its README runs in Node, and in a page to the same state', async ({ project, page }) => {
  test.setTimeout(120_000);
  const example = await exampleOf(project);
  await writeFile(join(project, 'example.js'), example);
  const { stdout } = await run('node', ['example.js'], { cwd: project });
  expect(stdout).toMatch(/^.*explored.* after \d+ s and \d+\.\d m\noff by \d\.\d cm\n\d+ places of its way\nstate [0-9a-f]{16}\n$/i);

  const simulate = process.env.SLAMLAB_SIMULATE ?? fileURLToPath(new URL('../../target/debug/examples/simulate', import.meta.url));
  if (existsSync(simulate)) {
    const native = await run(simulate, ['--world', 'arena', '--sensor', 'lidar', '--seed', '7', '--mode', 'explore', '--json']);
    expect(stdout, 'the program comes to the same bits').toContain((JSON.parse(native.stdout) as { state_hash: string }).state_hash);
  } else {
    test.info().annotations.push({ type: 'left out', description: `the comparison with ${simulate}` });
  }

  await writeFile(join(project, 'index.html'), `<!doctype html><title>package</title><script type="importmap">
    { "imports": { "slamlab": "./node_modules/slamlab/browser.js", "slamlab/layout": "./node_modules/slamlab/layout.js" } }</script>
    <script type="module" src="example.js"></script><link rel="icon" href="data:,">`);
  const server = await FileServer.start(project, '/below/');
  const said: string[] = [];
  page.on('console', (message) => said.push(message.text()));
  await page.goto(`${server.origin}/below/`);
  await expect.poll(() => `${said.join('\n')}\n`, { timeout: 60_000 }).toBe(stdout);
  await server.stop();
});

test('every module starts in Node, has its types, and says what is wrong', async ({ project }) => {
  await writeFile(join(project, 'modules.ts'), `import { load, type Setup } from "slamlab";
    import { LINE_STRIDE } from "slamlab/layout";
    const { offer, WebRun } = await load();
    const { solve_graph } = await load("files");
    const { registration_offer } = await load("lab");
    const { WebLocalBridge } = await load("cable");
    const setup: Setup = { world: "moon", worldJson: null, sensor: "lidar", seed: 7, method: "line-ekf", mode: "explore", cycle: false, settings: {}, calibration: null, priorMap: null, lesson: null };
    let refused = "";
    try { WebRun.simulate(setup); } catch (error) { refused = (error as Error).message; }
    const unknown = await load("lidar" as "lab").catch((error: Error) => error.message);
    console.log(JSON.stringify([offer().worlds.length > 9, typeof solve_graph, registration_offer().methods.length > 3, typeof WebLocalBridge, LINE_STRIDE, refused, unknown]));
    // @ts-expect-error: there is no such method of mapping
    setup.method = "magic";
  `);
  const flags = ['--ignoreConfig', '--strict', '--target', 'es2022', '--module', 'nodenext', '--moduleResolution', 'nodenext', '--lib', 'es2022,dom,esnext.disposable', '--types', '', 'modules.ts'];
  await run('node', [tsc, ...flags], { cwd: project }).catch((error: { stdout: string }) => {
    throw new Error(error.stdout);
  });
  const { stdout } = await run('node', ['modules.js'], { cwd: project });
  const [worlds, solve, methods, bridge, stride, refused, unknown] = JSON.parse(stdout) as unknown[];
  expect([worlds, solve, methods, bridge]).toEqual([true, 'function', true, 'function']);
  expect(stride).toBeGreaterThan(10);
  expect(refused).toContain('there is no world `moon`');
  expect(unknown).toBe('there is no module lidar; expected one of run, files, lab, cable');
});
