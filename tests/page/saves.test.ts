// The map is saved in files that other programs read.
import { readFile } from 'node:fs/promises';
import { expect, test } from './fixture.ts';
import { crc32 } from 'node:zlib';
import { filesIn, unzip } from './archive.ts';
import { drop } from './lab.ts';
import { record } from './recording.ts';

test('the map is saved as PGM and YAML', async ({ lab, page }) => {
  await lab.open();
  await lab.pause();
  const files = new Map((await lab.savedMap()).map(({ name, buffer }) => [name, buffer]));
  const pgm = files.get('office.pgm');
  const header = /^P5\s(?:#[^\n]*\n)*(\d+) (\d+)\s255\s/.exec(pgm?.subarray(0, 200).toString('latin1') ?? '');
  expect(header, 'a binary PGM with 256 tones').not.toBeNull();
  const [all = '', width, height] = header ?? [];
  expect(pgm?.length, 'one byte for each cell').toBe(all.length + Number(width) * Number(height));
  const tones = new Set(pgm?.subarray(all.length));
  for (const tone of [0, 205, 254]) expect([...tones], 'occupied, unknown and free').toContain(tone);

  const yaml = files.get('office.yaml')?.toString() ?? '';
  const value = (key: string): string => new RegExp(`^${key}: *(.+)$`, 'm').exec(yaml)?.[1] ?? '';
  expect(value('image')).toBe('office.pgm');
  expect(Number(value('resolution'))).toBeCloseTo(0.05);
  expect(JSON.parse(value('origin'))).toHaveLength(3);
  expect(value('negate')).toBe('0');
  expect(Number(value('occupied_thresh'))).toBeGreaterThan(Number(value('free_thresh')));
});

test('M, Y and Shift + A open the list of what can be saved, A alone steers, and in a recording A opens it too', async ({ lab, page }) => {
  await lab.open();
  const opens = async (key: string): Promise<void> => {
    await page.keyboard.press(key);
    await expect(lab.at('saving'), key).toBeVisible();
    await expect(lab.at('saving-map'), 'the map is what most come for').toBeChecked();
    await page.keyboard.press('Escape');
    await expect(lab.at('saving')).toBeHidden();
  };
  await lab.at('map').focus();
  for (const key of ['Shift+KeyA', 'm', 'y']) await opens(key);
  await lab.at('map').focus();
  await page.keyboard.down('a');
  await expect.poll(async () => (await lab.status()).mode, 'it is driven by hand').toBe('manual');
  const { heading } = await lab.status();
  await lab.watch((s) => Math.sin(s.heading - heading), 'it turns to the left').toBeGreaterThan(0.1);
  await page.keyboard.up('a');
  await expect(lab.at('saving'), 'steering saves nothing').toBeHidden();
  await drop(page, 'short.log', Buffer.from(record(40).text));
  await expect.poll(async () => (await lab.state()).source, 'the recording is shown').toBe('replay');
  await lab.watch((s) => s.finished, 'the recording ends').toBe(true);
  await opens('a');
});

test('the link of the experiment is saved with it, and does it again', async ({ lab, page, baseURL }) => {
  await lab.open();
  await lab.enter('doors', '4');
  await lab.watch((s) => s.time, 'it is under way').toBeGreaterThan(5);
  await lab.at('mode-manual').click();
  await lab.watch((s) => s.mode, 'something was done').toBe('manual');
  await lab.pause();
  const { time } = await lab.status();
  const coming = page.waitForEvent('download');
  await lab.save('link');
  const download = await coming;
  expect(download.suggestedFilename()).toBe('doors-experiment.url');
  const file = await readFile(await download.path());
  const link = /^\[InternetShortcut\]\r\nURL=(\S+)\r\n$/.exec(file.toString())?.[1] ?? '';
  expect(link.startsWith(`${baseURL!.replace(/\/$/, '')}/#run&`), 'an address of this page').toBe(true);

  // Dropped on the page, in another world.
  await lab.enter('arena', '1');
  await drop(page, 'doors-experiment.url', file);
  await expect.poll(async () => (await lab.state()).title).toBe('doors');
  await lab.speed('10');
  await lab.watch((s) => s.mode, 'what was done is done again').toBe('manual');
  expect((await lab.status()).time, 'at its moment').toBeGreaterThan(time - 3);

  await drop(page, 'elsewhere.url', Buffer.from('[InternetShortcut]\r\nURL=https://example.org/#here\r\n'));
  await expect(lab.at('toast')).toContainText('elsewhere.url leads to another page');
  // A foreign recording has no experiment.
  await drop(page, 'short.log', Buffer.from(record(40).text));
  await expect.poll(async () => (await lab.state()).source).toBe('replay');
  await lab.show('run');
  await lab.at('save').click();
  await expect(lab.at('saving-about-link')).toContainText('Not now: only a simulation has a link', { timeout: 30_000 });
});

test('the map is saved as a picture', async ({ lab, page }) => {
  await lab.open();
  await lab.show('run');
  const coming = page.waitForEvent('download');
  await lab.save('png');
  const download = await coming;
  expect(download.suggestedFilename()).toBe('office-picture.png');
  const png = await readFile(await download.path());
  expect(png.subarray(1, 4).toString()).toBe('PNG');
  expect(png.readUInt32BE(16), 'wide enough to see').toBeGreaterThan(50);
});

test('what is seen is saved as a drawing that shows the same', async ({ lab, page }) => {
  await lab.open();
  await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(20);
  await lab.pause();
  await lab.show('layers');
  // Filled outlines with text, ellipses, dashes.
  for (const layer of ['rooms', 'points', 'landmarks']) await lab.at(`layer-${layer}`).check();
  await lab.stillCamera();
  const drawn = async (): Promise<string> => {
    await lab.show('run');
    const coming = page.waitForEvent('download');
    await lab.save('svg');
    const download = await coming;
    expect(download.suggestedFilename()).toBe('office-view.svg');
    return readFile(await download.path(), 'utf8');
  };
  const svg = await drawn();
  expect(svg).toMatch(/^<svg [^>]*viewBox="0 0 \d+ \d+"/);
  // Rendered by the browser as an image, it has the same pixels as the page.
  const apart = await page.evaluate(async (svg) => {
    const { picture: shown } = (window as unknown as { slamlab: { picture: ImageData } }).slamlab;
    const { width, height } = shown;
    const pixels = (paint: (context: CanvasRenderingContext2D) => void): Uint8ClampedArray => {
      const context = Object.assign(document.createElement('canvas'), { width, height }).getContext('2d')!;
      paint(context);
      return context.getImageData(0, 0, width, height).data;
    };
    const background = getComputedStyle(document.querySelector('slam-map')!).backgroundColor;
    const page = pixels((context) => {
      context.fillStyle = background;
      context.fillRect(0, 0, width, height);
      const canvas = Object.assign(document.createElement('canvas'), { width, height });
      canvas.getContext('2d')!.putImageData(shown, 0, 0);
      context.drawImage(canvas, 0, 0);
    });
    const picture = new Image();
    picture.src = URL.createObjectURL(new Blob([svg], { type: 'image/svg+xml' }));
    await picture.decode();
    const file = pixels((context) => context.drawImage(picture, 0, 0, width, height));
    let [off, drawn] = [0, 0];
    const ground = page.slice(0, 3);
    for (let i = 0; i < page.length; i += 4) {
      const differs = (a: Uint8ClampedArray, at: number, b: Uint8ClampedArray) => [0, 1, 2].some((k) => Math.abs(a[at + k]! - b[i + k]!) > 60);
      if (differs(ground, 0, page)) drawn += 1;
      if (differs(file, i, page)) off += 1;
    }
    return { off, drawn };
  }, svg);
  expect(apart.drawn, 'there is something to see').toBeGreaterThan(5000);
  expect(apart.off, 'pixels that differ clearly').toBeLessThan(0.02 * apart.drawn);

  const images = (svg: string): number => svg.match(/<image /g)?.length ?? 0;
  expect(images(svg), 'cells').toBeGreaterThan(0);
  await lab.show('layers');
  await lab.at('layer-grid').click();
  expect(images(await drawn()), 'a layer that is off is not in it').toBe(0);
});

test('the walls are saved as a drawing, for drawing programs and as data', async ({ lab, page }) => {
  await lab.open();
  // Walls appear once they were seen three times.
  await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(10);
  await lab.pause();
  await lab.show('run');
  const coming = page.waitForEvent('download');
  await lab.save('plan');
  const files = new Map([...await filesIn(await coming)].map(([name, bytes]) => [name, bytes.toString()]));
  expect([...files.keys()].sort()).toEqual(['office.dxf', 'office.geojson', 'office.svg']);
  const plan = JSON.parse(files.get('office.geojson') ?? '{}') as { features: { geometry: { coordinates: [number, number][] }; properties: { length_m: number } }[] };
  expect(plan.features.length, 'the walls around the start').toBeGreaterThan(3);
  for (const { geometry, properties } of plan.features) {
    const [[x0, y0] = [NaN, NaN], [x1, y1] = [NaN, NaN]] = geometry.coordinates;
    expect(Math.hypot(x1 - x0, y1 - y0)).toBeCloseTo(properties.length_m, 9);
  }
  expect(files.get('office.svg')?.match(/<line /g)).toHaveLength(plan.features.length);
  expect(files.get('office.dxf')?.match(/^LINE$/gm)).toHaveLength(plan.features.length);
});

test('everything that can be saved is saved, and says so', { tag: '@phone' }, async ({ lab, page }) => {
  await lab.open();
  await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(10);
  await lab.pause();
  await lab.show('run');
  const save = async (what: string, count: number): Promise<Map<string, Buffer>> => {
    const coming = page.waitForEvent('download');
    await lab.save(what);
    const files = await filesIn(await coming);
    expect(files.size, what).toBe(count);
    return files;
  };
  const scale = await save('map-scale', 2);
  expect(scale.get('office-map.png')?.subarray(1, 4).toString()).toBe('PNG');
  expect(scale.get('office-map.yaml')?.toString()).toMatch(/^image: office-map\.png\nmode: scale\n/);
  expect((await save('map-raw', 2)).get('office-raw.yaml')?.toString()).toContain('mode: raw');
  const text = (await save('og-map', 1)).get('OGmap.txt')?.toString().trim().split('\n') ?? [];
  const [width, height] = text[0]?.split(' ').map(Number) ?? [];
  expect(text.length - 1).toBe(height);
  expect(text[1]?.split(' ').length).toBe(width);
  const poses = (await save('tum', 1)).get('office.tum')?.toString().match(/^\d.*$/gm) ?? [];
  const scans = (await save('carmen', 1)).get('office.clf')?.toString().match(/^ROBOTLASER1 .*$/gm) ?? [];
  expect(poses.length).toBeGreaterThan(10);
  expect(scans.length, 'a scan for each pose').toBe(poses.length);
  const revolutions = (await save('revolutions', 1)).get('office-revolutions.txt')?.toString().match(/^S_t:[^\n]*\|-END-$/gm) ?? [];
  expect(revolutions.length).toBe(poses.length);
  const smap = (await save('smap', 1)).get('office.smap')?.toString() ?? '';
  const count = (section: string): number => Number(new RegExp(`^#${section}\\n(\\d+)$`, 'm').exec(smap)?.[1]);
  expect(count('points')).toBeGreaterThan(100);
  expect(count('robot')).toBe(poses.length);
  expect(count('landmarks'), 'walls around the start').toBeGreaterThan(3);
});

test('everything is saved in one archive, and each file of it is read back', async ({ lab, page }) => {
  test.setTimeout(240_000);
  const everything = async (): Promise<{ archive: Buffer; files: Map<string, Buffer> }> => {
    await lab.show('run');
    await lab.at('save').click();
    await lab.at('saving-all').click();
    await expect(lab.at('saving-save')).toBeEnabled({ timeout: 30_000 });
    await expect(lab.at('saving-sum')).toContainText(/^\d+ files, [\d.]+ [kM]B$/);
    const coming = page.waitForEvent('download');
    await lab.at('saving-save').click();
    const download = await coming;
    expect(download.suggestedFilename()).toBe('office.zip');
    const archive = await readFile(await download.path());
    return { archive, files: unzip(archive) };
  };
  await lab.open();
  await lab.speed('10');
  await lab.watch((s) => s.explored, 'something is known', 60_000).toBeGreaterThan(0.3);
  await lab.pause();
  // Only the filter has walls, and only scan matching a pose graph.
  const ofLines = await everything();
  expect([...ofLines.files.keys()].filter((name) => /\.(?:g2o|slamlab)$/.test(name)), 'what there is not is not in it').toEqual([]);
  await lab.show('run');
  await lab.at('method').selectOption('scan-matching');
  await lab.watch((s) => s.scans, 'another run begins').toBeLessThan(20);
  if (!(await lab.state()).playing) await lab.at('play').click();
  await lab.watch((s) => s.explored, 'something is known', 60_000).toBeGreaterThan(0.3);
  await lab.pause();
  const { scans } = await lab.status();
  const ofScans = await everything();
  const files = new Map([...ofLines.files, ...ofScans.files]);
  const text = (name: string): string => files.get(name)?.toString() ?? '';

  // For other programs: checked by parsers that are not ours.
  expect(JSON.parse(text('office.geojson'))).toHaveProperty('features');
  expect(JSON.parse(text('office-rooms.geojson'))).toHaveProperty('features');
  const wellFormed = (svg: string) => page.evaluate((svg) => new DOMParser().parseFromString(svg, 'image/svg+xml').querySelector('parsererror') === null, svg);
  for (const name of ['office.svg', 'office-view.svg']) expect(await wellFormed(text(name)), name).toBe(true);
  expect(text('office.dxf').trim()).toMatch(/^0\s+SECTION[^]*0\s+EOF$/);
  const [header = [], ...rows] = text('office-plots.csv').trimEnd().split('\r\n').map(cellsOf);
  expect(header[0]).toBe('Time (s)');
  expect(rows.length).toBeGreaterThan(10);
  for (const row of rows) expect(row.length).toBe(header.length);
  const poses = text('office.tum').split('\n').filter((line) => /^\d/.test(line)).map((line) => line.split(' ').map(Number));
  expect(poses.length).toBe(scans);
  for (const pose of poses) expect(Math.hypot(...pose.slice(4)), 'a unit quaternion').toBeCloseTo(1, 6);
  for (const name of ['office-picture.png', 'office-map.png']) expect(files.get(name)?.subarray(1, 4).toString(), name).toBe('PNG');

  // By the page: each opens as what it is. If there are several in the archive, it asks.
  const opens = async (name: string, seen: () => Promise<unknown>) => test.step(name, async () => {
    await drop(page, 'office.zip', (ofScans.files.has(name) ? ofScans : ofLines).archive);
    await expect(lab.at('archive')).toBeVisible();
    await lab.at(`archive-${name}`).click();
    await seen();
  });
  const titled = (title: string) => expect.poll(async () => (await lab.state()).title, { timeout: 30_000 }).toBe(title);
  for (const map of ['office.yaml', 'office-map.yaml', 'office-raw.yaml', 'OGmap.txt', 'office.smap', 'office.svg']) {
    await opens(map, () => titled(map));
    expect((await lab.state()).source, map).toBe('sim');
  }
  for (const log of ['office.clf', 'office-revolutions.txt']) {
    await opens(log, () => titled(log));
    expect((await lab.state()).source, log).toBe('replay');
    await lab.watch((s) => s.scans, 'each scan is read', 60_000).toBe(scans);
  }
  await opens('office-experiment.url', () => titled('office'));
  await opens('office.g2o', () => expect(lab.at('toast').or(lab.at('log'))).toContainText(/office\.g2o is solved/));
  await opens('office.slamlab', () => expect(lab.at('going-on')).toContainText('office.slamlab'));
});

test('archives that are damaged, empty of maps, or lie about their size are refused in words, and the run goes on', async ({ lab, page }) => {
  await lab.open();
  const refused = async (archive: Buffer, words: string) => {
    await drop(page, 'strange.zip', archive);
    await expect(lab.at('toast')).toContainText(words);
  };
  await refused(Buffer.from('PK\x03\x04 and no more', 'latin1'), 'strange.zip: this is a ZIP archive that could not be opened: the archive is damaged');
  await refused(stored('holiday.jpg', Buffer.from([0xff, 0xd8, 0xff])), 'nothing in this archive can be opened here');
  await refused(stored('big.clf', Buffer.from('#'), 0xf000_0000), 'big.clf is too large: 4027 MB unpacked');
  // An entry with a wrong checksum is named, and the others are opened.
  const log = Buffer.from(record(5).text);
  const spoilt = Buffer.from(stored('drive.clf', log));
  spoilt[spoilt.indexOf('FLASER')] = 0x58;
  await refused(spoilt, 'strange.zip: damaged in the archive, and left out: drive.clf');
  const { time } = await lab.status();
  await lab.watch((s) => s.time, 'the run goes on').toBeGreaterThan(time);
});

/** The cells of a line, quoted as in RFC 4180. */
function cellsOf(line: string): string[] {
  return [...line.matchAll(/(?:^|,)(?:"((?:[^"]|"")*)"|([^,]*))/g)].map(([, quoted, plain]) => quoted?.replaceAll('""', '"') ?? plain ?? '');
}

/** An archive of one uncompressed file that claims to have this size. */
function stored(name: string, bytes: Buffer, size = bytes.length): Buffer {
  const fields = Buffer.alloc(26);
  fields.writeUInt16LE(20, 0);
  fields.writeUInt32LE(crc32(bytes), 10);
  fields.writeUInt32LE(bytes.length, 14);
  fields.writeUInt32LE(size, 18);
  fields.writeUInt16LE(name.length, 22);
  const local = Buffer.concat([Buffer.from('PK\x03\x04', 'latin1'), fields, Buffer.from(name), bytes]);
  const central = Buffer.concat([Buffer.from('PK\x01\x02\x14\0', 'latin1'), fields, Buffer.alloc(14), Buffer.from(name)]);
  const end = Buffer.alloc(18);
  end.writeUInt16LE(1, 4);
  end.writeUInt16LE(1, 6);
  end.writeUInt32LE(central.length, 8);
  end.writeUInt32LE(local.length, 12);
  return Buffer.concat([local, central, Buffer.from('PK\x05\x06', 'latin1'), end]);
}
