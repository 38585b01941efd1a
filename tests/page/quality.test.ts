// The judgement of a recording's map, over time and where it is torn.
import type { Quality } from '../../www/src/protocol/module.ts';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';
import { carried, record, RING } from './recording.ts';

async function open(lab: Lab, text: string): Promise<void> {
  await lab.open();
  await lab.show('run');
  await lab.at('file').setInputFiles({ name: 'drive.log', mimeType: 'text/plain', buffer: Buffer.from(text) });
  await expect.poll(async () => (await lab.state()).source).toBe('replay');
}

const quality = (lab: Lab): Promise<Quality | null> =>
  lab.page.evaluate(() => (window as unknown as { slamlab: { quality: Quality | null } }).slamlab.quality);

test('a map is judged when its recording ends, and again when somebody asks', async ({ lab }) => {
  await lab.open();
  await lab.show('run');
  await lab.at('file').setInputFiles({ name: 'laps.log', mimeType: 'text/plain', buffer: Buffer.from(record(300).text) });
  await expect.poll(async () => (await lab.state()).source).toBe('replay');
  await lab.watch((s) => s.finished, 'it is mapped').toBe(true);
  await lab.show('status');
  const says = /both agree\.\s+\d+ % of what was seen again agrees/;
  await expect(lab.at('quality')).toHaveText(says);
  await lab.at('judge').click();
  await expect(lab.at('quality')).toHaveText(says);
  await expect(lab.at('tears')).toHaveCount(0);
});

test('of each loop it is said how far its way was off, in units of what was known of it', async ({ lab }) => {
  await open(lab, record(400).text);
  await lab.watch((s) => s.finished, 'it is mapped', 60_000).toBe(true);
  await lab.show('status');
  await expect(lab.at('loops')).toContainText(/Loops were closed from \d+ stretches of the way\./);
  const { loops, loopRatio } = (await quality(lab))!;
  expect(loops.length).toBeGreaterThan(4);
  const sorted = loops.map(({ ratio }) => ratio).sort((a, b) => a - b);
  expect(loopRatio, 'the median').toBe(sorted[sorted.length >> 1]);
  await expect(lab.at('loops')).toContainText(`off by ${loopRatio!.toFixed(loopRatio! < 1 ? 2 : 1)} times`);
  await expect(lab.at('loop-plot').locator('circle')).toHaveCount(loops.length);
});

test('of a single scan nothing good is said', async ({ lab }) => {
  await open(lab, record(1).text);
  await lab.watch((s) => s.finished, 'it is mapped').toBe(true);
  await expect(lab.at('caption')).toContainText('nothing can be said of the map');
  await lab.show('status');
  await expect(lab.at('quality')).toHaveText(/^There is one scan/);
});

test('of methods that keep no submaps it is said that their map is not judged', async ({ lab }) => {
  await lab.open();
  await lab.show('status');
  await expect(lab.at('quality')).toHaveText(/^Not judged/);
  await expect(lab.at('judge')).toHaveCount(0);
});

test('its quality is plotted over the time of the run, as it goes and at the end', { tag: '@phone' }, async ({ lab, page }) => {
  test.setTimeout(120_000);
  await open(lab, record(2500, RING).text);
  await expect.poll(async () => await quality(lab) !== null && !(await lab.status()).finished, { message: 'it is judged on the way', intervals: [20], timeout: 60_000 }).toBe(true);
  await lab.watch((s) => s.finished, 'it is mapped', 60_000).toBe(true);
  // The judgement of the whole map comes after the end.
  const last = async (): Promise<number> => (await quality(lab))?.overTime.at(-1)?.seen[1] ?? 0;
  await expect.poll(last, 'up to the end').toBeGreaterThan(480);
  const { overTime } = (await quality(lab))!;
  expect(overTime.length).toBeGreaterThan(10);
  const agreeing = overTime.flatMap(({ agreement }) => agreement ?? []);
  expect(Math.min(...agreeing), 'of its laps each stretch agrees with the others').toBeGreaterThan(0.5);
  await lab.show('plots');
  await expect(lab.at('quality-plot-1')).toHaveText(/^\d+ %$/);
  const figure = page.locator('slam-agreement figure');
  await expect(figure).toBeVisible();
  // The number under the pointer is that of the stretch there.
  const box = (await figure.locator('.u-over').boundingBox())!;
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  const shown = Number.parseInt(await lab.at('quality-plot-1').innerText(), 10);
  expect(agreeing.map((part) => Math.round(100 * part)), 'it is one of them').toContain(shown);
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
});

test('a click on a torn place says what is torn, and by how much', { tag: '@phone' }, async ({ lab, page, isMobile }) => {
  const text = carried();
  await open(lab, text);
  await lab.watch((s) => s.finished, 'it is mapped').toBe(true);
  // The judgement of the whole map comes after the end.
  const stamps = text.trimEnd().split('\n').map((line) => Number(line.split(' ').at(-3)));
  const end = stamps.at(-1)! - stamps[0]!;
  await expect.poll(async () => (await quality(lab))?.overTime.at(-1)?.seen[1] ?? 0, 'up to the end').toBeGreaterThan(end - 5);
  const { tears, verdict } = (await quality(lab))!;
  expect(verdict).toBe('torn');
  await expect(lab.at('caption'), 'nobody has to scroll for it').toContainText(tears.length === 1 ? 'the map is torn at one place' : `the map is torn at ${tears.length} places`);
  await lab.show('status');
  await expect(lab.at('tears').locator('li')).toHaveCount(tears.length);
  await expect(lab.at('quality')).toContainText('This map is torn');
  const close = () => lab.at('torn').getByRole('button', { name: 'Close' }).click();
  for (const [at, { kind, place, off }] of tears.entries()) {
    // On a phone the last card may cover the next place.
    if (at > 0) await close();
    await lab.hidePanels();
    await lab.stillCamera();
    await lab.pointAt(...place, !!isMobile);
    const why = { doubled: /walls stand twice/, contradicted: /Walls where nothing was/, loose: /lost in between/, unproven: /Nothing proves/ }[kind];
    await expect(lab.at('torn-title')).toHaveText(why);
    await expect(lab.at('torn-off')).toHaveText(off === null ? 'too far to tell' : /^±?[\d.]+ c?m$/);
    await expect(lab.at('torn-earlier')).toHaveText(/^\d+:\d\d to \d+:\d\d$/);
    if (!isMobile) await expect(lab.at('hover')).toContainText(/· (torn|doubtful): .+, click to see more/);
    expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  }
  await close();
  await expect(lab.at('torn')).toHaveCount(0);
});

test('the marks say nothing while their layer is off', async ({ lab }) => {
  await open(lab, carried());
  await expect.poll(async () => (await quality(lab))?.verdict, { timeout: 30_000 }).toBe('torn');
  const [{ place }] = (await quality(lab))!.tears as [Quality['tears'][number]];
  await lab.show('layers');
  await lab.at('layer-torn').uncheck();
  // The card of a loop closure there would move the map under the pointer.
  await lab.at('layer-closures').uncheck();
  await lab.stillCamera();
  await lab.pointAt(...place, false);
  await expect(lab.at('hover')).toBeVisible();
  await expect(lab.at('hover')).not.toContainText('torn');
  await expect(lab.at('torn')).toHaveCount(0);
});
