// Buildings from files: a floor plan, a ROS map, and saved files become worlds to drive in and
// prior maps.
import { filesIn } from './archive.ts';
import { expect, test } from './fixture.ts';

const plan = `<svg xmlns="http://www.w3.org/2000/svg" data-metres-per-unit="0.01">
  <rect width="500" height="400" fill="none" stroke="black"/>
  <path d="M250 0v150m0 100v150" stroke="black"/>
  <circle id="start" cx="100" cy="200" r="10"/>
</svg>`;

test('a floor plan is a world, and a prior map for the robot in it', async ({ lab }) => {
  await lab.open();
  await lab.show('run');
  await lab.at('file').setInputFiles({ name: 'flat.svg', mimeType: 'image/svg+xml', buffer: Buffer.from(plan) });
  await expect.poll(async () => (await lab.state()).title).toBe('flat.svg');
  await lab.watch((s) => s.distance, 'it explores').toBeGreaterThan(0.5);
  await lab.at('method').selectOption('prior-map');
  await expect.poll(async () => (await lab.state()).method).toBe('prior-map');
  await lab.watch((s) => s.distance, 'it explores').toBeGreaterThan(0.5);
  expect((await lab.status()).positionError).toBeLessThan(0.1);
});

test('a map that was saved is a world again; half of one is asked for its other half', async ({ lab, page }) => {
  await lab.open();
  await lab.enter('arena', '4');
  await lab.watch((s) => s.explored, 'most is known').toBeGreaterThan(0.9);
  await lab.pause();
  const files = await lab.savedMap();
  const yaml = files.find(({ name }) => name.endsWith('.yaml'))!;
  await lab.at('file').setInputFiles(yaml);
  await expect(lab.at('toast')).toContainText('drop it together with the image');
  await lab.at('file').setInputFiles(files);
  await expect.poll(async () => (await lab.state()).title).toBe('arena.yaml');
  await lab.watch((s) => s.distance, 'it explores').toBeGreaterThan(0.3);
  await lab.at('file').setInputFiles([{ ...yaml, buffer: Buffer.from('image: arena.pgm') }, files.find(({ name }) => name.endsWith('.pgm'))!]);
  await lab.says('the key `resolution` is missing');
  expect((await lab.state()).title).toBe('arena.yaml');
});

test('walls that were saved are a map and a world again, in which the robot begins where it did', async ({ lab, page }) => {
  test.setTimeout(120_000);
  await lab.open();
  await lab.enter('arena', '10');
  await lab.watch((s) => s.explored, 'most is known').toBeGreaterThan(0.9);
  await lab.pause();
  await lab.showMaps();
  const coming = page.waitForEvent('download');
  await lab.save('plan');
  const drawing = (await filesIn(await coming)).get('arena.svg')!;
  const plan = { name: 'walls.svg', mimeType: 'image/svg+xml', buffer: drawing };
  await lab.at('prior-map-file').setInputFiles(plan);
  await expect(lab.at('prior-map-name')).toContainText('walls.svg');
  for (const name of ['x', 'y']) expect(Math.abs(Number(await lab.at(`prior-map-${name}`).inputValue())), name).toBeLessThan(0.02);
  await expect(lab.at('prior-map-fit')).toContainText('The map fits', { timeout: 60_000 });
  await lab.watch((s) => s.distance, 'it explores').toBeGreaterThan(0.5);
  expect((await lab.status()).positionError, 'its place is the true one').toBeLessThan(0.15);
  await lab.at('file').setInputFiles(plan);
  await expect.poll(async () => (await lab.state()).title).toBe('walls.svg');
  await lab.watch((s) => s.scans, 'it scans').toBeGreaterThan(0);
});
