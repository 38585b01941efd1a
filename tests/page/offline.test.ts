// Without a server: what the browser keeps of the page, and what happens to it when the server has
// another build, or is another program.
import { createHash } from 'node:crypto';
import { existsSync } from 'node:fs';
import { cp, mkdtemp, readFile, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import type { Page } from '@playwright/test';
import { Bridge } from './bridge.ts';
import { FileServer } from './file_server.ts';
import { expect, test as base } from './fixture.ts';
import { drop, Lab } from './lab.ts';
import { record } from './recording.ts';

const site = process.env.SLAMLAB_DIST ?? fileURLToPath(new URL('../../target/dist', import.meta.url));
const BELOW = '/a/b/';
const RENEWAL = 'A newer version of this page is here.';

const test = base.extend<{ folder: string }>({
  isKept: true,
  firstVisit: false,
  /** A copy of the page that a test may change. */
  folder: async ({}, use) => {
    const folder = await mkdtemp(join(tmpdir(), 'slamlab-page-'));
    await cp(site, folder, { recursive: true });
    await use(folder);
    await rm(folder, { recursive: true });
  },
});
test.skip(!existsSync(`${site}/index.html`), `no page in ${site}: cargo xtask dist makes one`);

interface Kept { offline: { kind: string }; renewal: string | null; source: string }
const look = (page: Page): Promise<Kept> => page.evaluate(() => {
  const { offline, renewal, source } = (window as unknown as { slamlab: Kept }).slamlab;
  return { offline, renewal, source };
});
const isKept = (page: Page): Promise<void> => expect.poll(async () => (await look(page)).offline.kind, { message: 'the page is kept', timeout: 30_000 }).toBe('kept');

/** Makes another build: the page has another title, and its worker knows that. */
async function rebuild(folder: string, title: string): Promise<void> {
  const digest = (bytes: string): string => createHash('sha256').update(bytes).digest('hex').slice(0, 16);
  const page = await readFile(join(folder, 'index.html'), 'utf8');
  const changed = page.replace(/<title>.*<\/title>/, `<title>${title}</title>`);
  const worker = await readFile(join(folder, 'offline_worker.js'), 'utf8');
  expect(worker, 'the worker knows the page by its content').toContain(digest(page));
  const build = /slamlab [^]*?"([0-9a-f]{16})"/.exec(worker)?.[1] ?? '';
  await writeFile(join(folder, 'index.html'), changed);
  await writeFile(join(folder, 'offline_worker.js'), worker.replaceAll(digest(page), digest(changed)).replaceAll(build, digest(title)));
}

/** Ignores the failed requests for bridge.json of a page without its server. */
const without = (problems: string[]): void => {
  expect(problems.filter((problem) => !/bridge\.json|offline_worker\.js|ERR_INTERNET_DISCONNECTED|ERR_CONNECTION|WebSocket/.test(problem))).toEqual([]);
  problems.length = 0;
};

test('opened once, the page runs without network and server: robot, log, building, registration lab', async ({ lab, page, context, problems }) => {
  test.setTimeout(120_000);
  const bridge = await Bridge.start();
  await lab.open(bridge.url);
  await isKept(page);
  await page.keyboard.press('?');
  await expect(lab.at('offline')).toContainText('opens and runs without its server');
  await page.keyboard.press('Escape');
  await context.setOffline(true);
  await bridge.stop('SIGKILL');

  await page.reload();
  await lab.watch((s) => s.features, 'the simulated robot maps').toBeGreaterThan(2);
  expect(await page.evaluate(() => crossOriginIsolated), 'with the headers that it came with').toBe(true);
  await drop(page, 'laps.log', Buffer.from(record(60).text));
  await expect.poll(async () => (await lab.state()).source, 'a log opens').toBe('replay');
  await lab.watch((s) => s.finished, 'and is mapped').toBe(true);
  await drop(page, 'flat.svg', Buffer.from(`<svg xmlns="http://www.w3.org/2000/svg" data-metres-per-unit="1"><polygon points="0,0 5,0 5,4 0,4" fill="none" stroke="black"/></svg>`));
  await expect.poll(async () => (await lab.state()).title, 'a building too').toBe('flat.svg');
  await page.keyboard.press('l');
  await expect(page.locator('slam-registration').getByTestId('lab-reset'), 'and the lab').toBeVisible();
  await page.keyboard.press('Escape');
  await lab.show('run');
  await lab.at('elsewhere').locator('summary').click();
  await expect(lab.at('no-bridge')).toContainText('cannot be reached');
  without(problems);
});

test('the rest of the page is fetched after its first picture; what a server says of itself is not kept', async ({ lab, page, context, folder }) => {
  const server = await FileServer.start(folder, BELOW);
  await lab.open(`${server.origin}${BELOW}`);
  const first = [...server.asked];
  expect(first).toContain(`${BELOW}slamlab_web_bg.wasm`);
  for (const later of ['offline_worker.js', 'registration.js', 'slamlab_files_bg.wasm']) expect(first).not.toContain(`${BELOW}${later}`);
  await isKept(page);
  const kept = await page.evaluate(async () => {
    const names = await caches.keys();
    const requests = await Promise.all(names.map(async (name) => (await caches.open(name)).keys()));
    return requests.flat().map(({ url }) => new URL(url).pathname);
  });
  for (const file of ['', 'main.js', 'slamlab_cable_bg.wasm', 'icons/maskable-512.png']) expect(kept).toContain(`${BELOW}${file}`);
  expect(kept.filter((path) => /bridge\.json|metrics|\.map$|offline_worker/.test(path))).toEqual([]);

  // It asks again each time, even if the page itself is kept.
  const asked = server.asked.length;
  await page.reload();
  await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(0);
  const again = server.asked.slice(asked);
  expect(again).toContain(`${BELOW}bridge.json`);
  expect(again).not.toContain(`${BELOW}main.js`);
  await server.stop();
  // Only below its own path.
  expect(await context.serviceWorkers()[0]?.evaluate(() => new URL((self as unknown as { registration: { scope: string } }).registration.scope).pathname)).toBe(BELOW);
});

test('a newer build waits for a word, and runs go on', async ({ lab, page, context, folder, problems }) => {
  test.setTimeout(120_000);
  const server = await FileServer.start(folder, BELOW);
  const address = `${server.origin}${BELOW}`;
  await lab.open(address);
  await isKept(page);
  await rebuild(folder, 'build two');
  const other = await context.newPage();
  await other.addInitScript(() => localStorage.setItem('slamlab-visited', '1'));
  const theirs = new Lab(other);
  await theirs.open(address);
  await expect(theirs.at('renewal')).toContainText(RENEWAL, { timeout: 30_000 });
  await expect(other).not.toHaveTitle('build two');
  const { time } = await theirs.status();
  await theirs.watch((s) => s.time, 'the run goes on').toBeGreaterThan(time);
  await theirs.at('renewal').getByRole('button', { name: 'Later' }).click();
  await expect(theirs.at('renewal')).toBeHidden();

  await other.reload();
  await theirs.watch((s) => s.scans, 'it runs').toBeGreaterThan(0);
  await theirs.at('renew').click({ timeout: 30_000 });
  await expect(other).toHaveTitle('build two');
  await theirs.watch((s) => s.scans, 'it runs').toBeGreaterThan(0);
  const later = (await lab.status()).time;
  await lab.watch((s) => s.time, 'and that of the other window goes on').toBeGreaterThan(later);
  await expect(page).not.toHaveTitle('build two');
  await page.reload();
  await expect(page).toHaveTitle('build two');
  await other.close();
  await server.stop();
});

test('a bridge that was renewed while the page was open is found to have a newer one', async ({ lab, page, folder, problems }) => {
  test.setTimeout(120_000);
  await rm(join(folder, 'bridge.json'));
  const flags = ['--source', 'sim:arena,lidar', '--page', folder];
  const bridge = await Bridge.start(flags);
  await lab.open(bridge.url);
  expect((await lab.state()).source).toBe('bridge');
  await isKept(page);
  await bridge.stop();
  await rebuild(folder, 'build two');
  const newer = await Bridge.start(flags, bridge.port);
  await expect(lab.at('renewal'), 'without a reload').toContainText(RENEWAL, { timeout: 60_000 });
  expect((await lab.state()).source).toBe('bridge');
  await lab.at('renew').click();
  await expect(page).toHaveTitle('build two');
  await expect.poll(async () => (await look(page).catch(() => null))?.source, 'with the robot behind it').toBe('bridge');
  await expect(page.locator('slam-plots .uplot').first(), 'all of it has come').toBeAttached();
  await newer.stop();
  without(problems);
});

test('another program at this address is not hidden by what was kept', async ({ lab, page, folder, problems }) => {
  test.setTimeout(120_000);
  const server = await FileServer.start(folder);
  await lab.open(server.origin);
  await isKept(page);
  const { origin, port } = server;
  await server.stop();
  const elsewhere = await mkdtemp(join(tmpdir(), 'slamlab-other-'));
  await writeFile(join(elsewhere, 'index.html'), '<!doctype html><title>something else</title><link rel="icon" href="data:,">');
  const other = await FileServer.start(elsewhere, '/', port);
  await page.goto(origin);
  await expect(page).toHaveTitle('something else', { timeout: 30_000 });
  await other.stop();
  await rm(elsewhere, { recursive: true });
  expect(problems.every((problem) => /404|bridge\.json|offline_worker/.test(problem)), problems.join('\n')).toBe(true);
  problems.length = 0;
});

test('the page can be installed', async ({ lab, page, folder, context }) => {
  const server = await FileServer.start(folder, BELOW);
  await lab.open(`${server.origin}${BELOW}`);
  await isKept(page);
  const devtools = await context.newCDPSession(page);
  const { errors, data, url } = await devtools.send('Page.getAppManifest');
  expect(errors).toEqual([]);
  expect(url).toBe(`${server.origin}${BELOW}manifest.webmanifest`);
  const manifest = JSON.parse(data!) as { name: string; icons: { src: string; sizes: string; purpose?: string }[] };
  expect(manifest.name).toContain('slamlab');
  expect(manifest.icons.map(({ purpose }) => purpose)).toContain('maskable');
  for (const { src, sizes } of manifest.icons) {
    const size = await page.evaluate(async (src) => {
      const image = new Image();
      image.src = src;
      await image.decode();
      return `${image.naturalWidth}x${image.naturalHeight}`;
    }, src);
    if (sizes !== 'any') expect(size, src).toBe(sizes);
  }
  const { installabilityErrors } = await devtools.send('Page.getInstallabilityErrors');
  // Tests use a private window, in which nothing can be installed.
  expect(installabilityErrors.filter(({ errorId }) => errorId !== 'in-incognito')).toEqual([]);
  await server.stop();
});

test.describe('at an address where a browser keeps nothing', () => {
  test.use({ isKept: false });

  test('the page says so, and runs', async ({ lab, page }) => {
    await lab.open();
    await page.keyboard.press('?');
    await expect(lab.at('offline')).toContainText('needs its server each time that it is opened: this browser keeps a page only where its address begins with https');
  });
});
