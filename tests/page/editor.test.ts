// The world editor: a building is drawn by mouse, touch or keys, corrected where it is invalid, and
// mapped by a robot; it is saved, read back and shared.
import { readFileSync } from 'node:fs';
import { AxeBuilder } from '@axe-core/playwright';
import type { Page } from '@playwright/test';
import type { Drawing as World } from '../../www/src/editor/drawing.ts';
import { isOpenWorld } from '../../www/src/editor/open_world.ts';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

interface Drawing {
  name: string;
  start: { x: number; y: number; heading: number };
  goal?: { x: number; y: number };
  obstacles: { shape: string; points?: number[][]; closed?: boolean; centre?: number[]; size?: number[]; angle?: number; radius?: number; material?: string }[];
  doors?: { from: number[]; to: number[] }[];
  movers?: { waypoints: number[][] }[];
}

type Board = HTMLElement & { camera: { toScreen(x: number, y: number): [number, number] } };

/** Where a place of the drawing is on the page, pixels. */
async function at(page: Page, x: number, y: number): Promise<[number, number]> {
  return page.evaluate(([x, y]) => {
    const board = document.querySelector('slam-editor')!.shadowRoot!.querySelector('editor-board') as unknown as Board;
    const box = board.shadowRoot!.querySelector('canvas')!.getBoundingClientRect();
    const [sx, sy] = board.camera.toScreen(x, y);
    return [box.left + sx, box.top + sy] as [number, number];
  }, [x, y] as const);
}

async function press(page: Page, x: number, y: number): Promise<void> {
  await page.mouse.click(...(await at(page, x, y)));
}

async function drag(page: Page, from: [number, number], to: [number, number]): Promise<void> {
  const end = await at(page, ...to);
  await page.mouse.move(...(await at(page, ...from)));
  await page.mouse.down();
  await page.mouse.move(...end, { steps: 6 });
  await page.mouse.up();
}

/** The drawing as the browser keeps it, once it stops changing. */
async function drawn(page: Page): Promise<Drawing> {
  await page.waitForTimeout(350);
  return page.evaluate(() => JSON.parse(localStorage.getItem('slamlab-drawing') ?? 'null') as Drawing);
}

async function openEditor(lab: Lab): Promise<void> {
  await lab.open();
  await lab.show('run');
  await lab.at('draw-world').click();
  await expect(lab.at('editor-board')).toBeVisible();
  // The world of the run is there first.
  await expect(lab.at('editor-name')).toHaveValue(/office/i);
}

async function emptyFloor(lab: Lab): Promise<void> {
  await lab.at('editor-begin').selectOption('(empty)');
  await expect(lab.at('editor-name')).toHaveValue('my world');
}

/** A room of 6 x 4 m around the start. */
const ROOM = [[-3, -2], [3, -2], [3, 2], [-3, 2]] as const;

async function drawRoom(lab: Lab): Promise<void> {
  await lab.at('tool-wall').click();
  for (const [x, y] of ROOM) await press(lab.page, x, y);
  await press(lab.page, ...ROOM[0]);
}

test('a room is drawn with the mouse, and a robot maps it', async ({ lab, page }) => {
  const asked: string[] = [];
  page.on('request', (request) => asked.push(new URL(request.url()).pathname));
  await lab.open();
  expect(asked.filter((path) => path.includes('editor')), 'the first visit does without it').toEqual([]);
  await lab.at('draw-world').click();
  await expect(lab.at('editor-name')).toHaveValue(/office/i);
  await emptyFloor(lab);
  await drawRoom(lab);
  await lab.at('tool-box').click();
  await drag(page, [1, 0.5], [2, 1.5]);
  await lab.at('editor-name').fill('two minutes');
  await lab.at('editor-name').press('Enter');
  const drawing = await drawn(page);
  expect(drawing.obstacles).toHaveLength(2);
  expect(drawing.obstacles[0]).toEqual({ shape: 'polyline', points: ROOM.map((p) => [...p]), closed: true });
  expect(drawing.obstacles[1]).toMatchObject({ shape: 'rectangle', centre: [1.5, 1], size: [1, 1] });
  await expect(lab.at('editor-fault')).toHaveCount(0);
  await lab.at('editor-run').click();
  await expect(page.locator('slam-editor')).toHaveCount(0);
  await expect.poll(async () => (await lab.state()).title).toBe('two minutes');
  await lab.speed('20');
  await lab.watch((s) => s.knownArea, 'the room is mapped', 50_000).toBeGreaterThan(18);
});

test('what is drawn is undone, done again, chosen, moved, turned, resized, doubled and deleted', async ({ lab, page }) => {
  await openEditor(lab);
  await emptyFloor(lab);
  await lab.at('tool-box').click();
  await drag(page, [1, 1], [2, 1.5]);
  await lab.at('tool-post').click();
  await drag(page, [-2, 1], [-1.5, 1]);
  await lab.at('tool-door').click();
  await drag(page, [-1, -1], [0, -1]);
  await lab.at('tool-person').click();
  await press(page, 1, -1);
  await press(page, 2, -1);
  await page.keyboard.press('Enter');
  await lab.at('tool-goal').click();
  await press(page, 3, 1);
  await lab.at('tool-glass').click();
  await press(page, -3, -2);
  await press(page, -1, -2);
  await page.keyboard.press('Enter');
  expect((await drawn(page)).obstacles.at(-1)).toEqual({ shape: 'polyline', points: [[-3, -2], [-1, -2]], material: 'glass' });
  await lab.at('editor-undo').click();
  let drawing = await drawn(page);
  expect(drawing.obstacles.map(({ shape }) => shape)).toEqual(['rectangle', 'circle']);
  expect(drawing.obstacles[1]).toMatchObject({ centre: [-2, 1], radius: 0.5 });
  expect(drawing.doors).toEqual([{ from: [-1, -1], to: [0, -1], open: false }]);
  expect(drawing.movers![0]).toMatchObject({ waypoints: [[1, -1], [2, -1]] });
  expect(drawing.goal).toEqual({ x: 3, y: 1 });

  await lab.at('editor-undo').click();
  await lab.at('editor-undo').click();
  drawing = await drawn(page);
  expect([drawing.goal, drawing.movers ?? []]).toEqual([undefined, []]);
  await page.keyboard.press('Control+y');
  await page.keyboard.press('Control+Shift+Z');
  drawing = await drawn(page);
  expect(drawing.goal).toEqual({ x: 3, y: 1 });

  await lab.at('tool-select').click();
  await drag(page, [1.5, 1.25], [1.5, 0.25]);
  await expect(lab.at('editor-chosen')).toHaveText('Box');
  expect((await drawn(page)).obstacles[0]).toMatchObject({ centre: [1.5, 0.25], size: [1, 0.5] });
  // The opposite corner stays where it is.
  await drag(page, [2, 0.5], [2.5, 1]);
  expect((await drawn(page)).obstacles[0]).toMatchObject({ centre: [1.75, 0.5], size: [1.5, 1] });
  await lab.at('editor-turn-left').click();
  expect((await drawn(page)).obstacles[0]!.angle).toBeCloseTo(Math.PI / 12, 5);
  await lab.at('field-angle').fill('90');
  await lab.at('field-angle').press('Enter');
  expect((await drawn(page)).obstacles[0]!.angle).toBeCloseTo(Math.PI / 2, 5);
  await lab.at('field-material').selectOption('glass');
  await expect(lab.at('editor-chosen')).toHaveText('Glass box');
  await lab.at('editor-duplicate').click();
  expect((await drawn(page)).obstacles).toHaveLength(3);
  await page.keyboard.press('Delete');
  drawing = await drawn(page);
  expect(drawing.obstacles).toHaveLength(2);
  expect(drawing.obstacles[0]!.material).toBe('glass');
});

test('points go to the grid, to right angles and to ends, and with Alt nowhere', async ({ lab, page }) => {
  await openEditor(lab);
  await emptyFloor(lab);
  await lab.at('tool-wall').click();
  await press(page, -2.02, -0.98);
  await press(page, 1.01, -0.96);
  await page.keyboard.press('Enter');
  await press(page, 1.05, -0.95);
  await press(page, 1.04, 1.5);
  await lab.at('editor-done').click();
  let { obstacles } = await drawn(page);
  expect(obstacles[0]!.points).toEqual([[-2, -1], [1, -1]]);
  expect(obstacles[1]!.points![0], 'joined to the end of the first').toEqual([1, -1]);
  expect(obstacles[1]!.points![1]![0], 'at a right angle to it').toBe(1);
  await page.keyboard.down('Alt');
  await press(page, -1.033, 0.517);
  await press(page, -0.411, 0.733);
  await page.keyboard.up('Alt');
  await expect(lab.at('editor-done')).toBeVisible();
  await lab.at('editor-done').click();
  ({ obstacles } = await drawn(page));
  const [x, y] = obstacles[2]!.points![0] as [number, number];
  expect(Math.hypot(x + 1.033, y - 0.517), 'where it was pressed').toBeLessThan(0.02);
  expect(obstacles).toHaveLength(3);
  expect(Math.abs(x * 20 - Math.round(x * 20)) + Math.abs(y * 20 - Math.round(y * 20)), 'on no grid').toBeGreaterThan(0.01);
});

test('a drawing that no robot can be in is refused in words, at its place', async ({ lab, page }) => {
  await openEditor(lab);
  await emptyFloor(lab);
  await lab.at('tool-box').click();
  await drag(page, [-1, -1], [1, 1]);
  await expect(lab.at('editor-fault')).toContainText('stands in obstacle 0 (a rectangle)');
  await expect(lab.at('editor-run')).toBeDisabled();
  await lab.at('editor-show-fault').click();
  await expect(lab.at('editor-chosen')).toHaveText('Start of the robot');
  await lab.at('field-x').fill('-2');
  await lab.at('field-x').press('Enter');
  await expect(lab.at('editor-fault')).toHaveCount(0);
  await expect(lab.at('editor-run')).toBeEnabled();
  // A figure out of range.
  await page.keyboard.press('Tab');
  await lab.at('tool-post').click();
  await drag(page, [2, 0], [2.5, 0]);
  await lab.at('tool-select').click();
  await press(page, 2, 0);
  await lab.at('field-radius').fill('-1');
  await lab.at('field-radius').press('Enter');
  await expect(lab.at('editor-fault')).toContainText('Obstacle 1: radius is -1');
  await lab.at('editor-undo').click();
  await expect(lab.at('editor-fault')).toHaveCount(0);
});

test('by keyboard alone a room is drawn, and the robot maps it', async ({ lab, page }) => {
  await lab.open();
  await page.keyboard.press('o');
  await expect(lab.at('editor-name')).toHaveValue(/office/i);
  await lab.at('editor-begin').focus();
  await page.keyboard.press('ArrowDown');
  await expect(lab.at('editor-name')).toHaveValue('my world');
  await page.keyboard.press('Escape');
  await page.keyboard.press('o');
  await page.keyboard.press('w');
  const go = async (key: string, times: number): Promise<void> => {
    for (let i = 0; i < times; i += 1) await page.keyboard.press(`Shift+${key}`);
  };
  await page.keyboard.press('Enter');
  await go('ArrowLeft', 2);
  await go('ArrowDown', 2);
  await page.keyboard.press('Enter');
  for (const [key, times] of [['ArrowRight', 4], ['ArrowUp', 4], ['ArrowLeft', 4], ['ArrowDown', 4]] as const) {
    await go(key, times);
    await page.keyboard.press('Enter');
  }
  const { obstacles } = await drawn(page);
  expect(obstacles).toHaveLength(1);
  expect(obstacles[0]!.closed).toBe(true);
  expect(obstacles[0]!.points).toHaveLength(4);
  await lab.at('editor-run').focus();
  await page.keyboard.press('Enter');
  await expect.poll(async () => (await lab.state()).title).toBe('my world');
  await lab.watch((s) => s.scans, 'it explores').toBeGreaterThan(5);
});

test('a drawing outlives the editor and the page, is saved, read back and shared', async ({ lab, page, browser }, testInfo) => {
  await openEditor(lab);
  await emptyFloor(lab);
  await drawRoom(lab);
  const kept = await drawn(page);
  await page.keyboard.press('Escape');
  await expect(page.locator('slam-editor')).toHaveCount(0);
  expect((await lab.state()).title, 'the run behind it is still there').toBe('office');
  await page.reload();
  await lab.at('draw-world').click();
  await expect(lab.at('editor-name')).toHaveValue('my world');
  const [download] = await Promise.all([page.waitForEvent('download'), lab.at('editor-save').click()]);
  expect(download.suggestedFilename()).toBe('my-world.json');
  const path = testInfo.outputPath('world.json');
  await download.saveAs(path);
  expect(JSON.parse(readFileSync(path, 'utf8'))).toEqual(kept);
  await lab.at('editor-begin').selectOption('arena');
  await expect(lab.at('editor-name')).toHaveValue('arena');
  await lab.at('editor-file').setInputFiles(path);
  await expect(lab.at('editor-name')).toHaveValue('my world');
  // A file that is no world leaves the drawing as it is.
  await lab.at('editor-file').setInputFiles({ name: 'bad.json', mimeType: 'application/json', buffer: Buffer.from('{ "slamlab_world": 1,\n "name": 3 }') });
  await expect(lab.at('editor-note')).toContainText('bad.json: world file, line 2');
  await expect(lab.at('editor-name')).toHaveValue('my world');
  await lab.at('editor-share').click();
  await expect.poll(() => page.url()).toContain('#world=');

  const other = await browser.newContext();
  const theirs = await other.newPage();
  await theirs.goto(page.url());
  await expect(theirs.getByTestId('editor-name')).toHaveValue('my world');
  await theirs.getByTestId('editor-run').click();
  await expect(theirs.locator('slam-editor')).toHaveCount(0);
  await theirs.goto(`${page.url().slice(0, -20)}`);
  await expect(theirs.getByTestId('editor-note')).toContainText('damaged');
  await other.close();
});

test('a long run is not ended without a question', async ({ lab, page }) => {
  await lab.open();
  await lab.speed('Infinity');
  await lab.watch((s) => s.time, 'a long run').toBeGreaterThan(65);
  await lab.at('draw-world').click();
  await expect(lab.at('editor-name')).toHaveValue(/office/i);
  await emptyFloor(lab);
  await lab.at('editor-run').click();
  await expect(lab.at('editor-ends')).toBeVisible();
  expect((await lab.state()).title).toBe('office');
  await lab.at('editor-run-surely').click();
  await expect.poll(async () => (await lab.state()).title).toBe('my world');
  expect(page.url()).not.toContain('#');
});

test('a finger draws a room on a phone', { tag: '@phone-only' }, async ({ lab, page }) => {
  await openEditor(lab);
  await emptyFloor(lab);
  await lab.at('tool-wall').tap();
  for (const [x, y] of [...ROOM, ROOM[0]]) await page.touchscreen.tap(...(await at(page, x, y)));
  const { obstacles } = await drawn(page);
  expect(obstacles[0]).toMatchObject({ shape: 'polyline', closed: true });
  expect(obstacles[0]!.points).toHaveLength(4);
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  await lab.at('editor-run').tap();
  await expect.poll(async () => (await lab.state()).title).toBe('my world');
});

test('the editor can be read by everybody', { tag: '@phone' }, async ({ lab, page }) => {
  await openEditor(lab);
  for (const scheme of ['light', 'dark'] as const) {
    await page.emulateMedia({ colorScheme: scheme, reducedMotion: 'reduce' });
    const { violations } = await new AxeBuilder({ page }).include('slam-editor').analyze();
    expect(violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.target.join(' ')).join(', ')}`), scheme).toEqual([]);
  }
});

test('a gap in the walls around the robot is told, until it is closed or has a door', async ({ lab, page }) => {
  await openEditor(lab);
  await emptyFloor(lab);
  await expect(lab.at('editor-open'), 'nothing is drawn yet').toHaveCount(0);
  const load = (obstacles: unknown[], doors: unknown[] = []): Promise<void> => lab.at('editor-file').setInputFiles({
    name: 'hall.json', mimeType: 'application/json', buffer: Buffer.from(JSON.stringify({ slamlab_world: 1, name: 'hall', start: { x: 2, y: 1.5 }, obstacles, doors })),
  });
  const walls = { shape: 'polyline', points: [[1, 0], [0, 0], [0, 3], [4, 3], [4, 0], [2, 0]] };
  await load([walls]);
  await expect(lab.at('editor-open')).toContainText('have a gap');
  await load([walls], [{ from: [1, 0], to: [2, 0], open: true }]);
  await expect(lab.at('editor-open')).toHaveCount(0);
  await load([{ ...walls, closed: true }]);
  await expect(lab.at('editor-open')).toHaveCount(0);
  await page.keyboard.press('Escape');
});

test('a way out is found through a real gap only: not through a wall that runs across, nor out of a wide one', () => {
  const world = (points: readonly (readonly [number, number])[], closed: boolean, x = 0, y = 0): World => ({ slamlab_world: 1, name: '', start: { x, y }, obstacles: [{ shape: 'polyline', points, closed }] });
  const ring = Array.from({ length: 24 }, (_, i) => [5 * Math.cos((i * Math.PI) / 12), 5 * Math.sin((i * Math.PI) / 12)] as const);
  expect(isOpenWorld(world(ring, true)), 'walls at all angles hold').toBe(false);
  expect(isOpenWorld(world(ring, false)), 'one piece of 24 lacks').toBe(true);
  expect(isOpenWorld(world(ring.map(([x, y]) => [40 * x, 40 * y]), true)), 'so do those of 400 m').toBe(false);
  expect(isOpenWorld(world(ring.map(([x, y]) => [40 * x, 40 * y]), false))).toBe(true);
  expect(isOpenWorld(world(ring, true, 7)), 'it stands outside').toBe(true);
  expect(isOpenWorld({ slamlab_world: 1, name: '', start: { x: 0, y: 0 }, obstacles: [] }), 'nothing is drawn').toBe(false);
});

test('walls that meet are one: no line parts them, and their outline goes round both', async ({ lab, page }) => {
  await openEditor(lab);
  await emptyFloor(lab);
  await lab.at('tool-box').click();
  await drag(page, [1, -0.5], [3, 0.5]);
  await drag(page, [3, -2], [4, 2]);
  await lab.at('tool-select').click();
  await press(page, -2, 2);
  await page.mouse.move(...(await at(page, -2, -2)));
  /** How dark the darkest pixel near a place is, 0 to 255. */
  const darkest = async (x: number, y: number): Promise<number> => page.evaluate(([x, y]) => {
    const board = document.querySelector('slam-editor')!.shadowRoot!.querySelector('editor-board') as unknown as Board;
    const canvas = board.shadowRoot!.querySelector('canvas')!;
    const [left, top] = board.camera.toScreen(x!, y!).map((pixel) => Math.round(pixel * devicePixelRatio) - 4);
    const { data } = canvas.getContext('2d')!.getImageData(left!, top!, 9, 9);
    return Math.min(...Array.from({ length: 81 }, (_, i) => data[4 * i + 1]!));
  }, [x, y] as const);
  const within = await darkest(2, 0.2);
  await expect.poll(() => darkest(3, 0), 'where the two meet').toBeGreaterThan(within - 20);
  expect(await darkest(3, 1), 'beside it, outside').toBeLessThan(within - 60);
  expect(await darkest(2, 0.5)).toBeLessThan(within - 60);
});
