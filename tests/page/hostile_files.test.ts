// Malicious files of each kind that the page opens: none hangs it, runs a script in it or ends what
// is shown, and each is answered in words.
import { readFileSync } from 'node:fs';
import { gzipSync } from 'node:zlib';
import { expect, test } from './fixture.ts';
import { drop, type Lab } from './lab.ts';
import { record } from './recording.ts';

const bag = (name: string): Buffer => readFileSync(new URL(`../../core/src/format/ros/files/${name}`, import.meta.url));
const room = readFileSync(new URL('../../core/src/format/revolution_log/room.txt', import.meta.url));

/** A good file of each kind, to be spoilt. */
const KINDS: readonly [name: string, good: Buffer][] = [
  ['log.clf', Buffer.from(record(5).text)],
  ['packed.clf.gz', gzipSync(record(5).text)],
  ['lidar.txt', room],
  ['ros1.bag', bag('plain.bag')],
  ['ros2.mcap', bag('zstd.mcap')],
  ['graph.g2o', Buffer.from('VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 500 0 0 500 0 500\n')],
  ['room.json', Buffer.from(JSON.stringify({ slamlab_world: 1, name: 'room', start: { x: 1, y: 1 }, obstacles: [{ shape: 'polyline', closed: true, points: [[0, 0], [4, 0], [4, 3], [0, 3]] }] }))],
  ['plan.svg', Buffer.from('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 4 3"><path d="M0 0H4V3H0Z" stroke="black" fill="none"/></svg>')],
  ['map.smap', Buffer.from('#points\n3\n0,0,0\n1000,0,0\n1000,1000,0\n#robot\n1\n0,0,0\n#landmarks\n0\n')],
  ['OGmap.txt', Buffer.from(`3 2 0.1 0 0\n${'0.1 0.9 0.5\n'.repeat(2)}`)],
];

/** Random enough, and the same each time. */
function noise(length: number): Buffer {
  let state = 0x9e3779b9;
  return Buffer.from(Uint8Array.from({ length }, () => {
    state = (Math.imul(state, 1_664_525) + 1_013_904_223) >>> 0;
    return state >>> 24;
  }));
}

const asText = (change: (text: string) => string) => (good: Buffer): Buffer => Buffer.from(change(good.toString('latin1')), 'latin1');
const INJECTED = '<img src=x onerror="window.isHacked=1"><script>window.isHacked=1</script>';

/** `isHopeless`: nothing can be made of it, whatever kind it claims to be. */
const WRONGS: readonly { what: string; isHopeless: boolean; spoil: (good: Buffer) => Buffer }[] = [
  { what: 'empty', isHopeless: true, spoil: () => Buffer.alloc(0) },
  { what: 'one byte', isHopeless: true, spoil: (good) => good.subarray(0, 1) },
  { what: 'noise', isHopeless: true, spoil: () => noise(5000) },
  { what: 'noise behind its first bytes', isHopeless: true, spoil: (good) => Buffer.concat([good.subarray(0, 8), noise(5000)]) },
  { what: 'zeros', isHopeless: true, spoil: () => Buffer.alloc(100_000) },
  { what: 'cut in half', isHopeless: false, spoil: (good) => good.subarray(0, good.length >> 1) },
  { what: 'numbers that are none', isHopeless: false, spoil: asText((text) => text.replace(/\b\d+\.\d+\b/g, 'NaN')) },
  { what: 'numbers beyond all bounds', isHopeless: false, spoil: asText((text) => text.replace(/\b[1-9]\d*\b/g, '1e308')) },
  { what: 'counts beyond all bounds', isHopeless: false, spoil: asText((text) => text.replace(/\b[1-9]\d*\b/g, '4294967295')) },
  { what: 'a script in it', isHopeless: false, spoil: asText((text) => text.replace(/[A-Za-z_]{4,}/, INJECTED)) },
  { what: 'bytes that are no text', isHopeless: false, spoil: (good) => Buffer.concat([good.subarray(0, good.length >> 1), Buffer.from([0xff, 0xfe, 0, 0xc3]), good.subarray(good.length >> 1)]) },
];

/** Whether the page refused a file in words, or opened it as a run or pose graph. */
async function answer(lab: Lab, name: string): Promise<'refused' | 'opened'> {
  let made: 'refused' | 'opened' | null = null;
  await expect.poll(async () => {
    const said = await lab.at('toast').allTextContents();
    if (said.some((words) => words.includes(name))) made = 'refused';
    else if ((await lab.state()).title === name || (await lab.at('topics').isVisible()) || (await lab.at('graph-says').allTextContents()).some((words) => words.startsWith(name))) made = 'opened';
    return made;
  }, { message: `${name} is answered`, timeout: 20_000, intervals: [50, 100] }).not.toBeNull();
  return made!;
}

/** No content of a file became part of the page. */
async function unharmed(lab: Lab): Promise<void> {
  expect(await lab.page.evaluate(() => (window as { isHacked?: number }).isHacked), 'no script ran').toBeUndefined();
}

for (const [kind, good] of KINDS) {
  test(`nothing that is called ${kind} hangs or ends the page`, async ({ lab, page }) => {
    test.setTimeout(180_000);
    await lab.open();
    await lab.pause();
    for (const [i, { what, isHopeless, spoil }] of WRONGS.entries()) {
      await test.step(what, async () => {
        const name = `${i}-${kind}`;
        await drop(page, name, spoil(good));
        const made = await answer(lab, name);
        if (isHopeless) expect(made, what).toBe('refused');
        await unharmed(lab);
        const close = page.getByRole('button', { name: 'Close the message' });
        if (await close.isVisible()) await close.click();
      });
    }
    await lab.enter('arena', '4');
    await lab.watch((s) => s.scans, 'another run begins').toBeGreaterThan(2);
  });
}

test('a little that unpacks to much is read in bounded memory, or refused, and can be cancelled', async ({ lab, page }) => {
  test.setTimeout(180_000);
  await lab.open();
  // 200 MB of one byte, of blanks, of empty lines.
  for (const [name, fill] of [['zeros.clf.gz', 0], ['blanks.clf.gz', 0x20]] as const) {
    await drop(page, name, gzipSync(Buffer.alloc(200_000_000, fill)));
    expect(await answer(lab, name), name).toBe('refused');
    await page.getByRole('button', { name: 'Close the message' }).click();
  }
  await drop(page, 'twice.clf.gz', gzipSync(gzipSync(record(5).text)));
  expect(await answer(lab, 'twice.clf.gz')).toBe('refused');
  await lab.watch((s) => s.scans, 'the run goes on').toBeGreaterThan(1);
});

test('the name of a file is a name, and nothing else', async ({ lab, page }) => {
  await lab.open();
  for (const name of [`${INJECTED}.log`, '../../../etc/passwd.log', `${'x'.repeat(5000)}.log`, '\u202Egol.exe']) {
    await drop(page, name, Buffer.from('hello'));
    await expect(lab.at('toast')).toBeVisible();
    await unharmed(lab);
    const box = (await lab.at('toast').boundingBox())!;
    expect(box.height, 'the message fits the page, and its button').toBeLessThan(page.viewportSize()!.height - 72);
    await page.getByRole('button', { name: 'Close the message' }).click();
  }
  await drop(page, `${INJECTED}.clf`, Buffer.from(record(5).text));
  await expect.poll(async () => (await lab.state()).source, 'a log is a log, whatever it is called').toBe('replay');
  await lab.watch((s) => s.finished, 'it is mapped').toBe(true);
  await lab.show('log');
  await unharmed(lab);
  expect(await page.locator('img[src="x"]').count()).toBe(0);
});
