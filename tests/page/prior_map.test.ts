// A prior map: of the world in another frame, of another building, or the one drawn so far.
import { readFile } from 'node:fs/promises';
import { Bridge } from './bridge.ts';
import { expect, test } from './fixture.ts';
import { drop } from './lab.ts';
import { record } from './recording.ts';

/** Doors of a flat of two rooms, 5 m x 4 m; `shift` moves its frame. */
function flat(shift: number): Buffer {
  const at = (x: number, y: number): string => `${x + shift},${y - 2 * shift}`;
  return Buffer.from(`<svg xmlns="http://www.w3.org/2000/svg" data-metres-per-unit="1">
    <polygon points="${at(0, 0)} ${at(5, 0)} ${at(5, 4)} ${at(0, 4)}" fill="none" stroke="black"/>
    <path d="M${at(2.5, 0)}v1.5m0 1v1.5" stroke="black"/>
    <circle id="start" cx="${1 + shift}" cy="${2 - 2 * shift}" r=".1"/></svg>`);
}
/** A hall with eight sides of 6 m: its walls do not stand like those of a flat. */
const hall = Buffer.from(`<svg xmlns="http://www.w3.org/2000/svg" data-metres-per-unit="1">
    <polygon points="5,0 11,0 15.2,4.2 15.2,10.2 11,14.4 5,14.4 .8,10.2 .8,4.2" fill="none" stroke="black"/>
    <circle id="start" cx="8" cy="7" r=".1"/></svg>`);
const file = (name: string, buffer: Buffer) => ({ name, mimeType: '', buffer });
const fit = 'prior-map-fit';

test('a robot localises itself in another map than its world, given its start there', async ({ lab, page }) => {
  test.setTimeout(150_000);
  await lab.open();
  await lab.showMaps();
  await lab.at('file').setInputFiles(file('flat.svg', flat(0)));
  await expect.poll(async () => (await lab.state()).title).toBe('flat.svg');
  await lab.at('prior-map-file').setInputFiles(file('moved.svg', flat(7)));
  await expect.poll(async () => (await lab.state()).method).toBe('prior-map');
  await expect(lab.at('prior-map-name')).toContainText('moved.svg');
  expect((await lab.state()).title, 'the world stays').toBe('flat.svg');
  await expect(lab.at('prior-map-x'), 'where the drawing says').toHaveValue('8');
  await lab.speed('20');
  await expect(lab.at(fit)).toContainText('The map fits', { timeout: 60_000 });
  await lab.watch((s) => s.distance, 'it explores').toBeGreaterThan(0.5);
  expect((await lab.status()).positionError).toBeLessThan(0.15);
  // With the map of another building, it reports that this cannot be.
  await lab.at('prior-map-file').setInputFiles(file('hall.svg', hall));
  await expect(lab.at('prior-map-name')).toContainText('hall.svg');
  await expect(lab.at(fit)).toContainText('does not fit', { timeout: 60_000 });
  await expect(lab.at('toast')).toContainText('The prior map does not fit');
  await lab.at('prior-map-world').click();
  await expect(lab.at('prior-map-name')).toContainText('true walls');
  await expect(lab.at(fit)).toContainText('The map fits', { timeout: 60_000 });
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
});

test('what was mapped is a map to be found in; what is no map leaves the run as it is', async ({ lab }) => {
  test.setTimeout(150_000);
  await lab.open();
  await lab.enter('arena', '20');
  await lab.watch((s) => s.explored, 'most is known', 90_000).toBeGreaterThan(0.9);
  await lab.showMaps();
  await lab.at('prior-map-file').setInputFiles(file('OGmap.txt', Buffer.from('3 2 0.05 0 0\n0.5 0.5 0.5\n0.5 7 0.5\n')));
  await lab.says('line 3: field 2 is `7`, expected a number from 0 to 1');
  await lab.at('prior-map-file').setInputFiles(file('half.yaml', Buffer.from('image: half.pgm\n')));
  await expect(lab.at('toast')).toContainText('one half of a map');
  expect((await lab.state()).method, 'the run goes on').toBe('line-ekf');
  await lab.at('prior-map-this').click();
  await expect(lab.at('prior-map-name')).toContainText('map of arena');
  await expect(lab.at(fit)).toContainText('The map fits', { timeout: 60_000 });
});

test('a submap that was saved is a map to be found in', async ({ lab, page }) => {
  test.setTimeout(150_000);
  await lab.open();
  await lab.enter('arena', '20');
  await lab.watch((s) => s.explored, 'most is known', 90_000).toBeGreaterThan(0.9);
  await lab.pause();
  await lab.showMaps();
  const coming = page.waitForEvent('download');
  await lab.save('smap');
  const download = await coming;
  expect(download.suggestedFilename()).toBe('arena.smap');
  const saved = await readFile(await download.path());
  await lab.at('prior-map-file').setInputFiles(file('arena.smap', saved));
  await expect(lab.at('prior-map-name')).toContainText('arena.smap');
  await expect(lab.at(fit)).toContainText('The map fits', { timeout: 60_000 });
  await lab.at('prior-map-file').setInputFiles(file('cut.smap', saved.subarray(0, 300)));
  await expect(lab.at('toast')).toContainText('expected');
  expect((await lab.state()).method, 'the run goes on').toBe('prior-map');
});

test('OGmap.txt is a world too', async ({ lab }) => {
  await lab.open();
  const rows = Array.from({ length: 60 }, (_, row) => Array.from({ length: 80 }, (_, col) => (row % 59 === 0 || col % 79 === 0 ? 0.97 : 0.02)).join(' '));
  await lab.at('file').setInputFiles(file('OGmap.txt', Buffer.from(`80 60 0.05 -1 -1\n${rows.join('\n')}\n`)));
  await expect.poll(async () => (await lab.state()).title).toBe('OGmap.txt');
  await lab.watch((s) => s.scans, 'it scans').toBeGreaterThan(3);
});

test('a recording is found in the map that was made of it', async ({ lab, page }) => {
  test.setTimeout(150_000);
  const recording = record(420);
  await lab.open();
  await drop(page, 'laps.log', Buffer.from(recording.text));
  await expect.poll(async () => (await lab.state()).source, 'the recording is shown').toBe('replay');
  await lab.watch((s) => s.finished, 'the recording ends').toBe(true);
  const map = await lab.savedMap();
  await lab.showMaps();
  await lab.at('prior-map-file').setInputFiles(map);
  await expect.poll(async () => (await lab.state()).method, 'it begins again').toBe('prior-map');
  await lab.watch((s) => s.finished, 'and ends again').toBe(true);
  await expect(lab.at(fit)).toContainText('The map fits');
  const { x, y } = await lab.status();
  expect(Math.hypot(x - recording.end.x, y - recording.end.y), 'it ends where the robot did').toBeLessThan(0.1);
});

test('a robot at a bridge is found in a map that was saved before', async ({ lab, page }) => {
  test.setTimeout(180_000);
  const bridge = await Bridge.start(['--source', 'sim:office,lidar']);
  await lab.open(bridge.url);
  await expect.poll(async () => (await lab.state()).source).toBe('bridge');
  await lab.watch((s) => s.scans, 'it scans').toBeGreaterThan(30);
  const map = await lab.savedMap();
  await lab.showMaps();
  await lab.at('prior-map-file').setInputFiles(map);
  await expect.poll(async () => (await lab.state()).method, 'the bridge is asked again').toBe('prior-map');
  await expect(lab.at('prior-map-name')).toContainText('.yaml');
  await expect(lab.at(fit)).toContainText('The map fits', { timeout: 60_000 });
  expect(Math.hypot((await lab.status()).x, (await lab.status()).y), 'the robot has not moved').toBeLessThan(0.1);
  // With a start farther off than its own search reaches (4 m), it reports that this cannot be.
  await lab.at('prior-map-x').fill('9.3');
  await lab.at('prior-map-x').press('Enter');
  await expect(lab.at(fit)).toContainText('does not fit', { timeout: 60_000 });
  await lab.at('method').selectOption('line-ekf');
  await lab.watch((s) => s.features, 'without the map it draws its own').toBeGreaterThan(2);
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  await bridge.stop();
});
