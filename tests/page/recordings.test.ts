// A recorded log becomes a map: dropped, chosen, cancelled; and a real building if its recording is
// available.
import { existsSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { expect, test } from './fixture.ts';
import { drop } from './lab.ts';
import { record } from './recording.ts';

test('a dropped log becomes the map of its room', async ({ lab, page }) => {
  const recording = record(420);
  await lab.open();
  await drop(page, 'laps.log', Buffer.from(recording.text));
  await expect.poll(async () => (await lab.state()).source, 'the recording is shown').toBe('replay');
  await expect(lab.at('progress')).toBeVisible();
  await lab.watch((s) => s.finished, 'the recording ends').toBe(true);
  await expect(lab.at('caption')).toContainText('Mapped laps.log');
  await expect(lab.at('progress')).toContainText('100 %');
  const status = await lab.status();
  expect(status.scans).toBe(420);
  const { end, wheelsEnd } = recording;
  expect(Math.hypot(wheelsEnd.x - end.x, wheelsEnd.y - end.y), 'the wheels alone err').toBeGreaterThan(0.4);
  expect(Math.hypot(status.x - end.x, status.y - end.y), 'the estimate does not').toBeLessThan(0.1);
  // The free floor that a half circle of beams sees on these laps: the room of 48 m² less its
  // boxes.
  expect(status.knownArea).toBeGreaterThan(40);
  expect(status.knownArea).toBeLessThan(48);

  await lab.at('to-simulation').click();
  await expect.poll(async () => (await lab.state()).source, 'the simulation comes back').toBe('sim');
  await lab.watch((s) => s.scans, 'and runs').toBeGreaterThan(0);
});

test('a chosen log can be cancelled, and the map so far stays', async ({ lab }) => {
  await lab.open();
  await lab.show('run');
  await lab.at('file').setInputFiles({ name: 'long.clf', mimeType: 'text/plain', buffer: Buffer.from(record(2500).text) });
  await expect.poll(async () => (await lab.state()).source, { message: 'the recording is shown', timeout: 30_000 }).toBe('replay');
  await lab.speed('4');
  await lab.watch((s) => s.scans, 'scans are mapped').toBeGreaterThan(20);
  await lab.hidePanels();
  await lab.at('cancel').click();
  await lab.watch((s) => s.reason, 'it ends here').toBe('cancelled');
  const { scans } = await lab.status();
  expect(scans).toBeLessThan(2500);
  expect((await lab.state()).blocks, 'the map stays').toBeGreaterThan(0);
  await lab.show('log');
  await expect(lab.at('log')).toContainText('the map so far stays');
});

test('the page has a recording by itself: it comes when it is asked for, is mapped, and closes its loop', { tag: '@phone' }, async ({ lab, page, isMobile }) => {
  test.setTimeout(240_000);
  const asked: string[] = [];
  page.on('request', (request) => asked.push(new URL(request.url()).pathname));
  await lab.open();
  await lab.show('run');
  await page.getByText('What can be opened').click();
  expect(asked.filter((path) => path.includes('examples')), 'a first visit does without it').toEqual([]);
  await lab.at('example').click();
  await expect.poll(async () => (await lab.state()).title, { timeout: 30_000 }).toBe('ring.log');
  expect((await lab.state()).source).toBe('replay');
  if (isMobile) await lab.hidePanels();
  await lab.watch((s) => s.finished, 'the recording ends', 120_000).toBe(true);
  const status = await lab.status();
  expect(status.scans).toBe(457);
  expect(status.loopClosures, 'all the way round').toBeGreaterThan(0);
  await expect(lab.at('caption')).toContainText('Mapped ring.log');
  await expect(lab.at('caption')).not.toContainText(/doubtful|torn/);

  // The gallery has it, too.
  await lab.at('to-simulation').click();
  await expect.poll(async () => (await lab.state()).source).toBe('sim');
  await lab.at('show-gallery').click();
  await lab.at('exhibit-recording').click();
  await expect.poll(async () => (await lab.state()).title, { timeout: 30_000 }).toBe('ring.log');
});

test('where the recording of the page does not come, that is said', async ({ lab, page, problems }) => {
  await page.route('**/examples/*', (route) => route.abort());
  await lab.open();
  await lab.at('show-gallery').click();
  await lab.at('exhibit-recording').click();
  await lab.says('The recording could not be loaded. Is the server still there?');
  problems.length = 0;
});

const INTEL = 'intel/intel.clf';
const folder = process.env.SLAMLAB_DATA ?? fileURLToPath(new URL('../../../shared/data', import.meta.url));

test(`the recording ${INTEL} becomes a map, and the page lives`, async ({ lab, page }, info) => {
  const file = `${folder}/${INTEL}`;
  test.skip(!existsSync(file), `recorded data ${INTEL} is absent from ${folder}`);
  // The time is measured where nothing else runs: `cargo xtask report browser-cost`.
  test.setTimeout(300_000);
  await lab.open();
  await page.evaluate(() => {
    const gaps = { longest: 0, count: 0 };
    Object.assign(window, { gaps });
    let last = performance.now();
    const tick = (now: number): void => {
      gaps.longest = Math.max(gaps.longest, now - last);
      gaps.count += 1;
      last = now;
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  });
  const begin = Date.now();
  await lab.at('file').setInputFiles(file);
  await expect.poll(async () => (await lab.state()).source, { timeout: 30_000 }).toBe('replay');
  const opened = Date.now();
  let seq = 0;
  while (!(await lab.status()).finished) {
    await expect.poll(async () => (await lab.state()).seq, { message: 'frames keep coming' }).toBeGreaterThan(seq);
    ({ seq } = await lab.state());
  }
  const seconds = (Date.now() - begin) / 1000;
  const gaps = await page.evaluate(() => (window as unknown as { gaps: { longest: number; count: number } }).gaps);
  const said = `${seconds.toFixed(1)} s (opened after ${((opened - begin) / 1000).toFixed(1)} s), ${(gaps.count / seconds).toFixed(0)} pictures a second, longest gap ${gaps.longest.toFixed(0)} ms, ${seq} frames`;
  info.annotations.push({ type: INTEL, description: said });
  console.log(`${INTEL}: ${said}`);
  expect((await lab.status()).scans).toBe(13631);
});
