// Input that cannot be read is refused with a sentence that says what is wrong and where, and the
// page keeps what it shows.
import { gzipSync } from 'node:zlib';
import { expect, test } from './fixture.ts';
import { drop } from './lab.ts';
import { record } from './recording.ts';

const log = record(5).text;
const lines = log.split('\n');
const scan = lines.at(-2)!;
const jpeg = Buffer.from([0xff, 0xd8, 0xff, 0xe0, 0, 16, 0x4a, 0x46, 0x49, 0x46, 0, 1, 1, 0, 0, 1, 0, 1, 0, 0, 0xff, 0xdb, 10, 13, 0]);
const world = (x: number) => JSON.stringify({
  slamlab_world: 1, name: 'walled', start: { x, y: 1 }, obstacles: [{ shape: 'polyline', closed: true, points: [[0, 0], [4, 0], [4, 3], [0, 3]] }],
});

const CASES: readonly [what: string, file: string, bytes: string | Buffer, says: RegExp][] = [
  ['an empty log', 'empty.log', '', /empty\.log.*empty.*expected a CARMEN log/is],
  ['a JPEG named .log: that is enough, whatever else would be read', 'photo.log', jpeg, /photo\.log: this is a JPEG picture(?!;)/],
  ['a log that is cut off', 'cut.log', log.slice(0, -scan.length / 2), /cut\.log.*line 7.*cut off/is],
  ['a packed log that is cut off', 'cut.log.gz', gzipSync(log).subarray(0, -20), /cut\.log\.gz.*gzip file is damaged/is],
  ['a log with a word for a range', 'word.log', log.replace(scan, scan.replace(/ \d+\.\d+/, ' far')), /word\.log.*line 7: field 3.*`far`/is],
  ['a text without a scan', 'notes.log', 'ODOM 0 0 0 0 0 0 1 host 1\nhello\n', /notes\.log.*no laser message/is],
  ['a world whose robot stands in a wall', 'walled.json', world(0.05), /walled\.json.*(start|robot)/is],
  ['a world with a word for a number', 'word.json', world(1).replace('"x":1', '"x":"one"'), /word\.json: world file, line \d+, column \d+: start\.x: invalid type: string "one", expected a number/s],
  ['a world that is no JSON', 'broken.json', '{ "slamlab_world": 1,', /broken\.json.*line 1/is],
];

test('bad files are refused in words, and the map stays', async ({ lab, page }) => {
  await lab.open();
  await lab.enter('arena', '4');
  await lab.watch((s) => s.distance, 'there is a map').toBeGreaterThan(0.3);
  await lab.pause();
  const before = await lab.state();
  for (const [what, file, bytes, says] of CASES) {
    await test.step(what, async () => {
      await drop(page, file, Buffer.from(bytes));
      await lab.says(says);
      const after = await lab.state();
      expect(after.blocks).toBe(before.blocks);
      expect(after.hash).toBe(before.hash);
      expect(after.setup).toEqual(before.setup);
      await page.getByRole('button', { name: 'Close the message' }).click();
      await expect(lab.at('toast')).toBeHidden();
    });
  }
  await lab.at('play').click();
  await lab.watch((s) => s.time, 'the run goes on').toBeGreaterThan((before.status?.time ?? 0) + 0.5);
});

test('ranges and poses that are none cost only themselves, and the page says so', async ({ lab, page }) => {
  await lab.open();
  const words = scan.split(' ');
  const nan = (place: number): string => words.map((word, i) => (i === place ? 'nan' : word)).join(' ');
  const pose = words.length - 9;
  const damaged = [...lines.slice(0, -2), nan(2), nan(pose), scan, ''].join('\n');
  await drop(page, 'nan.log', Buffer.from(damaged));
  await expect.poll(async () => (await lab.state()).title, 'it is opened').toBe('nan.log');
  await lab.watch((s) => s.finished, 'it is mapped').toBe(true);
  await lab.show('log');
  const log = lab.at('log');
  await expect(log).toContainText('1 range is no measurement and was left out: line 7: field 3 of FLASER is `nan`');
  await expect(log).toContainText(`1 line cannot be used and was left out: line 8: field ${pose + 1} of FLASER is \`nan\``);
});

/** A ROS map: 20 x 10 cells, free. */
const yaml = (changes: Readonly<Record<string, string | null>> = {}): string => Object.entries({
  image: 'hall.pgm', resolution: '0.05', origin: '[0, 0, 0]', negate: '0', occupied_thresh: '0.65', free_thresh: '0.196', ...changes,
}).flatMap(([key, value]) => (value === null ? [] : [`${key}: ${value}\n`])).join('');
const pgm = (width: number, height: number, bytes = 200): Buffer => Buffer.concat([Buffer.from(`P5\n${width} ${height}\n255\n`), Buffer.alloc(bytes, 254)]);

const MAPS: readonly [what: string, yaml: string, pgm: Buffer, says: RegExp][] = [
  ['no resolution', yaml({ resolution: null }), pgm(20, 10), /hall\.yaml.*resolution/is],
  ['resolution 0', yaml({ resolution: '0' }), pgm(20, 10), /hall\.yaml.*resolution.* 0/is],
  ['a resolution in words', yaml({ resolution: 'fine' }), pgm(20, 10), /hall\.yaml.*resolution.*fine/is],
  ['fewer cells than the header says', yaml(), pgm(20, 10, 150), /hall\.yaml.*150/is],
  ['an image without end', yaml(), pgm(4_000_000_000, 4_000_000_000), /hall\.yaml.*4000000000/is],
];

test('bad maps are refused in words, as a world and as a map to be found in, and the run stays', async ({ lab, page }) => {
  test.setTimeout(120_000);
  await lab.open();
  await lab.pause();
  await lab.showMaps();
  const before = await lab.state();
  for (const [what, text, image, says] of MAPS) {
    for (const input of ['file', 'prior-map-file']) {
      await test.step(`${what}, ${input}`, async () => {
        await lab.at(input).setInputFiles([
          { name: 'hall.yaml', mimeType: 'text/yaml', buffer: Buffer.from(text) },
          { name: 'hall.pgm', mimeType: 'image/x-portable-graymap', buffer: image },
        ]);
        await lab.says(says);
        const after = await lab.state();
        expect([after.blocks, after.hash, after.method], what).toEqual([before.blocks, before.hash, before.method]);
        expect(after.setup).toEqual(before.setup);
        await page.getByRole('button', { name: 'Close the message' }).click();
        await expect(lab.at('toast')).toBeHidden();
      });
    }
  }
});

test('a goal far off the map is refused in words', { tag: '@phone' }, async ({ lab, isMobile }) => {
  await lab.open();
  await lab.enter('arena', '4');
  await lab.watch((s) => s.distance, 'there is a map').toBeGreaterThan(0.3);
  // A phone has no buttons for it.
  const box = (await lab.at('map').boundingBox())!;
  await lab.page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  for (let i = 0; i < 12; i += 1) await lab.page.mouse.wheel(0, 400);
  await lab.at('mode-goto').click();
  await lab.pointAt(20, 120, !!isMobile);
  await lab.watch((s) => s.reason, 'it says why').toMatch(/the goal at \(\d+\.\d\d, 1\d\d\.\d\d\) m is inside an obstacle, too near to one, or off the map/);
  expect((await lab.status()).finished, 'and the errand is over').toBe(true);
});

test('a good world file is entered', async ({ lab, page }) => {
  await lab.open();
  await drop(page, 'room.json', Buffer.from(world(1)));
  await expect.poll(async () => (await lab.state()).title).toBe('room.json');
  await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(0);
});

test('files written for other programs are recognised, and files that are no building together are refused', async ({ lab, page }) => {
  await lab.open();
  await lab.showMaps();
  const { setup } = await lab.state();
  const contents: Readonly<Record<string, string>> = {
    geojson: '{ "type": "FeatureCollection", "features": [] }', svg: '<svg/>', yaml: 'image: a.pgm\n', pgm: 'P2 1 1', txt: '3 2 0.1 0 0\n',
  };
  // The content counts, not the name.
  const file = (name: string) => ({ name: `x-${name.replace(/\.(?:dxf|geojson)$/, '')}`, mimeType: '', buffer: Buffer.from(contents[/\.(\w+)$/.exec(name)?.[1] ?? ''] ?? '0\nSECTION\n') });
  const cases: readonly [names: string[], says: RegExp][] = [
    [['office.dxf'], /x-office is for other programs.*does not read it.*DXF.*\.svg/],
    [['office.geojson'], /x-office is for other programs.*GeoJSON.*\.svg/],
    [['office.svg', 'office.dxf', 'office.geojson'], /These are 3 files/],
    [['office.yaml', 'office.pgm', 'OGmap.txt'], /These are 3 files/],
    [['office.yaml', 'other.yaml'], /These are 2 files/],
  ];
  for (const [names, says] of cases) {
    for (const input of ['file', 'prior-map-file']) {
      await lab.at(input).setInputFiles(names.map(file));
      await lab.says(says, `${names.join()}, ${input}`);
      await page.getByRole('button', { name: 'Close the message' }).click();
    }
  }
  expect((await lab.state()).setup).toEqual(setup);
});

test('what is no seed, and two files at once, are refused in words', async ({ lab, page }) => {
  await lab.open();
  await lab.show('run');
  const { setup } = await lab.state();
  for (const seed of ['-5', '', '3.5', '99999999999']) {
    await lab.at('seed').fill(seed);
    await lab.at('seed').blur();
    await expect(lab.at('toast')).toContainText('A seed is a whole number');
    await expect(lab.at('seed'), 'the field says what runs').toHaveValue(String(setup.seed));
    await page.getByRole('button', { name: 'Close the message' }).click();
  }
  expect((await lab.state()).setup).toEqual(setup);
  await page.evaluate(() => {
    const data = new DataTransfer();
    for (const name of ['a.log', 'b.log']) data.items.add(new File(['x'], name));
    document.body.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
  });
  await expect(lab.at('toast')).toContainText('2 files');
  expect((await lab.state()).source).toBe('sim');
});
