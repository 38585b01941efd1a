// An experiment in a link: repeated by somebody else, to the bit.
import { readFile } from 'node:fs/promises';
import { deflateRawSync, inflateRawSync } from 'node:zlib';
import { expect, test } from './fixture.ts';
import { drop, type Lab } from './lab.ts';

/** The link of a run in a drawn world; `same_run.rs` repeats the same run natively, and in the
    browser without the page. */
const DRAWN = (await readFile(new URL('../drawn_link.txt', import.meta.url), 'utf8')).trim();

const notes = (lab: Lab): Promise<string[]> => lab.page.evaluate(() => (window as unknown as { slamlab: { log: { text: string }[] } }).slamlab.log.map(({ text }) => text));
const HOLDS = expect.stringContaining('the state is the same, to the bit');

const copied = async (lab: Lab): Promise<string> => {
  const before = lab.page.url();
  await lab.show('run');
  await lab.at('copy-link').click();
  await expect.poll(() => lab.page.url(), 'the address is the link').not.toBe(before);
  return lab.page.url();
};

test('a run with all that was done in it is done again by its link, in another browser', { tag: '@phone' }, async ({ lab, page, browser, isMobile }) => {
  test.setTimeout(120_000);
  await lab.open();
  await lab.enter('doors');
  await lab.speed('4');
  await lab.watch((s) => s.scans, 'it explores').toBeGreaterThan(20);
  await lab.at('mode-goto').click();
  await lab.pointAt(0.6, 0.1, !!isMobile);
  await lab.watch((s) => s.mode, 'it drives to the goal').toBe('goto');
  const scans = (await lab.status()).scans;
  await lab.watch((s) => s.scans, 'for a while').toBeGreaterThan(scans + 10);
  await lab.at('mode-explore').click();
  await lab.watch((s) => s.scans, 'and goes on').toBeGreaterThan(scans + 30);
  await lab.pause();
  const address = await copied(lab);
  expect(address).toMatch(/#run&world=doors&sensor=lidar&method=line-ekf&seed=\d+&do=\d+:goto,.*&until=\d+&hash=[0-9a-f]{16}$/);
  const { hash } = await lab.state();
  expect(address.endsWith(hash), 'the hash is that of the state').toBe(true);

  const other = await browser.newContext();
  await other.addInitScript(() => localStorage.setItem('slamlab-visited', '1'));
  const theirs = await other.newPage();
  await theirs.goto(address);
  await theirs.getByTestId('speed').selectOption('Infinity');
  const noted = (): Promise<string[]> => theirs.evaluate(() => (window as unknown as { slamlab: { log: { text: string }[] } }).slamlab.log.map(({ text }) => text));
  await expect.poll(noted, { message: 'it comes to the same state', timeout: 60_000 }).toContainEqual(expect.stringContaining('the state is the same, to the bit'));
  await other.close();
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
});

test('a run in a drawn world comes with its world, and to the state that it has natively', async ({ lab, page }) => {
  await page.goto(`/#${DRAWN}`);
  await expect.poll(() => notes(lab), { timeout: 60_000 }).toContainEqual(HOLDS);
  const { world, worldJson } = (await lab.state()).setup as { world: string; worldJson: string };
  expect(world).toBe('Studio & hall');
  expect(JSON.parse(worldJson)).toMatchObject({ slamlab_world: 1, doors: [{ from: [4, 1.5], to: [4, 2.5] }] });
});

test('a world of one\'s own is given away with the run, as an address and as a file', async ({ lab, page }) => {
  test.setTimeout(120_000);
  await lab.open();
  const text = JSON.stringify({ slamlab_world: 1, name: 'cell', start: { x: 1, y: 1, heading: 0.3 }, obstacles: [{ shape: 'polyline', closed: true, points: [[0, 0], [5, 0], [5, 3.5], [0, 3.5]] }] });
  await drop(page, 'cell.json', Buffer.from(text));
  await expect.poll(async () => (await lab.state()).setup.world).toBe('cell.json');
  await lab.watch((s) => s.scans, 'it looks around').toBeGreaterThan(8);
  await lab.pause();
  const address = await copied(lab);
  const letters = /&drawn=([\w-]+)$/.exec(address)?.[1] ?? '';
  expect(inflateRawSync(Buffer.from(letters, 'base64url')).toString(), 'the file, letter for letter').toBe(text);
  await lab.at('save').click();
  await lab.at('saving-none').click();
  await lab.at('saving-link').click();
  const coming = page.waitForEvent('download');
  await lab.at('saving-save').click();
  const download = await coming;
  expect(download.suggestedFilename()).toMatch(/\.url$/);
  const file = await readFile(await download.path());
  expect(file.toString()).toContain(`URL=${address}\r\n`);

  await lab.enter('arena');
  await drop(page, 'from-a-friend.url', file);
  await expect.poll(() => notes(lab), { timeout: 60_000 }).toContainEqual(HOLDS);
  expect((await lab.state()).setup.world).toBe('cell');
});

/** Each link is refused in these words; the world stays, and the run goes on. */
async function refuses(lab: Lab, cases: readonly (readonly [link: string, words: string])[]): Promise<void> {
  for (const [link, words] of cases) {
    await lab.page.evaluate((link) => (location.hash = link), link);
    await lab.says(words);
    expect((await lab.state()).setup.world).toBe('office');
  }
  const { scans } = await lab.status();
  await lab.watch((s) => s.scans, 'it goes on').toBeGreaterThan(scans);
}

test('a link whose world is hostile is refused in words, and what was there stays', async ({ lab }) => {
  await lab.open();
  await lab.watch((s) => s.scans, 'it explores').toBeGreaterThan(3);
  const of = (packed: string): string => `run&sensor=lidar&method=line-ekf&seed=7&drawn=${packed}`;
  const packed = (text: string | Buffer): string => of(deflateRawSync(text).toString('base64url'));
  await refuses(lab, [
    [DRAWN.slice(0, -9), 'damaged'],
    [of('%%%'), 'damaged'],
    [packed(Buffer.alloc(100_000_000, 0x20)), 'at most 1000000'],
    [packed('{"a":1}'), 'world file, line 1'],
    [`${DRAWN}&world=arena`, 'one of them'],
    [of('A'.repeat(1_500_000)), 'bytes long'],
  ]);
});

test('a link that is wrong is refused in words, and what was there stays', async ({ lab }) => {
  await lab.open();
  await lab.watch((s) => s.scans, 'it explores').toBeGreaterThan(3);
  await refuses(lab, [
    ['run&world=moon&sensor=lidar&method=line-ekf&seed=7', 'world is `moon`'],
    ['run&world=office', 'no `sensor`'],
    ['run&world=%3Cimg%20src=x%20onerror=alert(1)%3E&sensor=lidar&method=line-ekf&seed=7', 'expected one of'],
    [`run&world=office&sensor=lidar&method=line-ekf&seed=7&do=1:${'goto,1'.repeat(20)}`, '`do` is'],
    [`run&${'x'.repeat(70_000)}`, 'bytes long'],
    ['run&world=office&sensor=lidar&method=line-ekf&seed=99999999999', 'at most 4294967295'],
  ]);
});

test('a page that is opened by a link that is wrong says so, and has a robot all the same', async ({ lab, page }) => {
  await page.goto('/#run&world=moon&sensor=lidar&method=line-ekf&seed=7');
  await lab.says('world is `moon`');
  await lab.watch((s) => s.scans, 'the office').toBeGreaterThan(1);
  expect(page.url()).not.toContain('moon');
});

test('a run that no list of actions can tell makes no link, and says why', async ({ lab, page }) => {
  await lab.open();
  await lab.show('run');
  await lab.at('method').selectOption('scan-matching');
  await expect.poll(async () => (await lab.state()).method, 'the run before has ended').toBe('scan-matching');
  await lab.watch((s) => s.scans, 'it maps').toBeGreaterThan(10);
  await lab.hidePanels();
  await page.keyboard.press('e');
  await lab.pointAt(0.5, 0.5, false);
  await lab.pointAt(1, 1, false);
  await lab.show('run');
  await lab.at('copy-link').click();
  await expect(lab.at('toast')).toContainText('the map was changed by hand');
});

test('another result than the link tells is said', async ({ page, lab }) => {
  await page.goto('/#run&world=arena&sensor=lidar&method=line-ekf&seed=7&until=40&hash=0123456789abcdef');
  const noted = (): Promise<string[]> => page.evaluate(() => (window as unknown as { slamlab: { log: { text: string }[] } }).slamlab.log.map(({ text }) => text));
  await expect.poll(noted, { timeout: 30_000 }).toContainEqual(expect.stringContaining('the state is not the one that it tells'));
  expect((await lab.state()).setup.world).toBe('arena');
});
