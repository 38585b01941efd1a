// What draws the map: WebGL2 and Canvas 2D give the same picture, a graphics card may come and go,
// the view turns, and layers lie in the order that a person chose.
//
// Here the processor emulates WebGL2, so it has to be chosen by hand.
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

/** Everything that can be shown of a run in the office. */
const EVERYTHING = ['rooms', 'points', 'landmarks', 'found', 'tree', 'rawPath', 'wheels'];
/** Edges are smoothed differently: this part of the drawn pixels may differ. */
const MOST_OFF = 0.02;

async function stands(lab: Lab): Promise<void> {
  await lab.open();
  await lab.watch((s) => s.distance, 'it drives').toBeGreaterThan(1.5);
  await lab.pause();
  await lab.stillCamera();
}

/** Waits for this back end, and for its picture. */
async function drawnWith(lab: Lab, name: string): Promise<void> {
  await expect.poll(async () => (await lab.state()).drawnWith).toBe(name);
  await lab.page.waitForTimeout(500);
}

/** Nothing of the page covers the map's background where nothing is drawn: the most frequent colour
    on the screen in a corner of the map is the map's. */
async function showsGround(lab: Lab): Promise<void> {
  const box = (await lab.at('map').boundingBox())!;
  const shot = await lab.page.screenshot({ clip: { x: box.x + box.width - 300, y: box.y + 20, width: 200, height: 120 } });
  const [seen, ground] = await lab.page.evaluate(async (url) => {
    const image = new Image();
    image.src = url;
    await image.decode();
    const context = Object.assign(document.createElement('canvas'), { width: image.width, height: image.height }).getContext('2d')!;
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    const counts = new Map<string, number>();
    for (let i = 0; i < data.length; i += 4) {
      const colour = `rgb(${data[i]}, ${data[i + 1]}, ${data[i + 2]})`;
      counts.set(colour, (counts.get(colour) ?? 0) + 1);
    }
    return [[...counts].sort((a, b) => b[1] - a[1])[0]![0], getComputedStyle(document.querySelector('slam-map')!).backgroundColor];
  }, `data:image/png;base64,${shot.toString('base64')}`);
  expect(seen, 'the ground of the map is seen').toBe(ground);
}

test.describe('with WebGL2', () => {
  test.use({ drawnWith: 'webgl2' });

  test('it is the picture of Canvas 2D, upright and turned', async ({ lab, page }) => {
    test.setTimeout(120_000);
    await stands(lab);
    await lab.show('layers');
    for (const layer of EVERYTHING) await lab.at(`layer-${layer}`).check();
    for (const turned of [false, true]) {
      if (turned) for (const key of ['q', 'q']) await page.keyboard.press(key);
      await lab.stillCamera();
      await lab.at('drawing').selectOption('webgl2');
      await drawnWith(lab, 'webgl2');
      await expect(lab.at('drawn-with')).toHaveText('WebGL2.');
      const byCard = await lab.picture();
      await lab.at('drawing').selectOption('canvas');
      await drawnWith(lab, 'canvas');
      const byCanvas = await lab.picture();
      const { part, drawn } = await lab.differing(byCard, byCanvas);
      expect(drawn, 'there is something to see').toBeGreaterThan(20_000);
      expect(part, `pixels that differ clearly, turned: ${turned}`).toBeLessThan(MOST_OFF);
    }
    // Proves that a layer that draws nothing would be noticed.
    const all = await lab.picture();
    await lab.at('layer-landmarks').uncheck();
    await lab.at('layer-walls').uncheck();
    await page.waitForTimeout(300);
    expect((await lab.differing(all, await lab.picture())).part).toBeGreaterThan(0.2 * MOST_OFF);
  });

  test('a graphics card that is taken away is replaced by Canvas 2D until it is given back', async ({ lab, page }) => {
    test.setTimeout(90_000);
    await stands(lab);
    await drawnWith(lab, 'webgl2');
    const before = await lab.picture();
    const card = await page.evaluateHandle(() => {
      const canvas = document.querySelector('slam-map')!.shadowRoot!.querySelector<HTMLCanvasElement>('#gl')!;
      return canvas.getContext('webgl2')!.getExtension('WEBGL_lose_context')!;
    });
    await card.evaluate((card) => card.loseContext());
    await drawnWith(lab, 'canvas');
    await showsGround(lab);
    const without = await lab.differing(before, await lab.picture());
    expect(without.drawn).toBeGreaterThan(20_000);
    expect(without.part, 'the picture is still there').toBeLessThan(MOST_OFF);
    await lab.show('layers');
    await expect(lab.at('drawn-with')).toContainText('taken away');
    await lab.show('log');
    await expect(lab.at('log')).toContainText('the graphics card was taken away');

    await card.evaluate((card) => card.restoreContext());
    await drawnWith(lab, 'webgl2');
    await showsGround(lab);
    expect((await lab.differing(before, await lab.picture())).part, 'it comes back').toBeLessThan(0.005);
    // The run goes on.
    await lab.at('play').click();
    const { x } = await lab.status();
    await lab.watch((s) => Math.abs(s.x - x), 'the robot drives on').toBeGreaterThan(0.3);
    await lab.pause();
    expect((await lab.differing(before, await lab.picture())).part).toBeGreaterThan(0.005);
  });
});

test.describe('by itself', () => {
  test.use({ drawnWith: 'auto' });

  test('the page draws with Canvas 2D where the graphics card is emulated, and says so', async ({ lab, page }) => {
    await lab.open();
    await lab.show('layers');
    const card = await page.evaluate(() => {
      const gl = document.createElement('canvas').getContext('webgl2');
      const info = gl?.getExtension('WEBGL_debug_renderer_info');
      return info ? String(gl!.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
    });
    test.skip(!/swiftshader|llvmpipe/i.test(card), `this machine has a graphics card: ${card}`);
    await expect(lab.at('drawn-with')).toContainText('emulated');
    expect((await lab.state()).drawnWith).toBe('canvas');
    await showsGround(lab);
  });
});

test.describe('without WebGL2', () => {
  test.use({ drawnWith: 'webgl2' });

  test('the map is drawn with Canvas 2D, and the legend says why', async ({ lab, page }) => {
    await page.addInitScript(() => {
      const given = HTMLCanvasElement.prototype.getContext as (kind: string, ...more: unknown[]) => unknown;
      HTMLCanvasElement.prototype.getContext = function (this: HTMLCanvasElement, kind: string, ...more: unknown[]) {
        return kind === 'webgl2' ? null : given.call(this, kind, ...more);
      } as typeof HTMLCanvasElement.prototype.getContext;
    });
    await stands(lab);
    await lab.show('layers');
    await expect(lab.at('drawn-with')).toContainText('this browser gives no WebGL2');
    const missing = await lab.picture();
    await lab.at('drawing').selectOption('canvas');
    await expect(lab.at('drawn-with')).toContainText('chosen');
    const { part, drawn } = await lab.differing(missing, await lab.picture());
    expect(drawn).toBeGreaterThan(20_000);
    expect(part, 'nothing is missing').toBeLessThan(0.002);
  });
});

for (const turned of [false, true]) {
  test(`what was redrawn part by part is the picture that is drawn at once${turned ? ', turned' : ''}`, async ({ lab, page }) => {
    await stands(lab);
    // Browsers place the dashes of a turned line, of which they draw a part, a little differently.
    for (const key of turned ? ['q', 'x'] : []) await page.keyboard.press(key);
    // From here on the view stands, and only what changes is drawn.
    await page.keyboard.press('+');
    await lab.stillCamera();
    await lab.at('play').click();
    const { distance } = await lab.status();
    await lab.watch((s) => s.distance, 'it drives on').toBeGreaterThan(distance + 1);
    await lab.pause();
    await page.waitForTimeout(500);
    const byParts = await lab.picture();
    await page.keyboard.press('x');
    await page.waitForTimeout(300);
    expect((await lab.differing(byParts, await lab.picture())).part, 'everything is redrawn').toBeGreaterThan(0.002);
    await page.keyboard.press('x');
    await page.waitForTimeout(300);
    const { part, drawn } = await lab.differing(byParts, await lab.picture());
    expect(drawn).toBeGreaterThan(20_000);
    expect(part).toBeLessThan(0.005);
  });
}

test('a map that is turned by half is the map upside down, and a click hits what is seen there', async ({ lab, page }) => {
  test.setTimeout(90_000);
  await stands(lab);
  const box = (await lab.at('map').boundingBox())!;
  // The view stays as it is from here on.
  await page.keyboard.press('+');
  await lab.stillCamera();
  const middle = await page.evaluate(() => {
    const { slamlab } = window as unknown as { slamlab: { camera: { x: number; y: number }; toScreen(x: number, y: number): [number, number] } };
    return slamlab.toScreen(slamlab.camera.x, slamlab.camera.y);
  });
  const layers = ['scan', 'walls', 'lines', 'truth', 'trails', 'robot', 'frontiers', 'path'];
  await lab.show('layers');
  for (const name of layers) await lab.at(`layer-${name}`).uncheck();
  await page.waitForTimeout(300);
  const upright = await lab.picture();
  await page.locator('body').press('q');
  await expect(lab.at('upright')).toBeVisible();
  for (let press = 1; press < 12; press += 1) await page.keyboard.press('q');
  await expect.poll(async () => Math.abs((await lab.state()).camera.angle)).toBeCloseTo(Math.PI, 6);
  await page.waitForTimeout(300);
  const { part, drawn } = await lab.differing(upright, await lab.picture(), middle);
  expect(drawn).toBeGreaterThan(20_000);
  expect(part, 'cells, whose edges may lie a pixel off').toBeLessThan(0.06);
  expect((await lab.differing(upright, await lab.picture())).part, 'it was turned at all').toBeGreaterThan(0.15);

  // A quarter turn: what was to the right of the middle is now above it.
  for (let press = 0; press < 6; press += 1) await page.keyboard.press('Shift+q');
  await expect.poll(async () => (await lab.state()).camera.angle).toBeCloseTo(Math.PI / 2, 6);
  const { x, y, scale } = (await lab.state()).camera;
  const [dx, dy] = [40, 25];
  await lab.at('mode-goto').click();
  await page.mouse.click(box.x + middle[0] - dy, box.y + middle[1] - dx);
  await lab.at('play').click();
  await lab.watch((s) => s.goalX, 'the goal').toBeCloseTo(x + dx / scale, 1);
  expect((await lab.status()).goalY).toBeCloseTo(y + dy / scale, 1);

  await lab.at('upright').click();
  expect((await lab.state()).camera.angle).toBe(0);
  await expect(lab.at('upright')).toBeHidden();
});

test('a drag with Shift turns the view, and two fingers do', { tag: '@phone' }, async ({ lab, page, hasTouch }) => {
  await stands(lab);
  const box = (await lab.at('map').boundingBox())!;
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 3];
  if (hasTouch) {
    const session = await page.context().newCDPSession(page);
    const fingers = (angle: number): { x: number; y: number }[] => [0, Math.PI].map((side) => ({ x: x + 70 * Math.cos(angle + side), y: y + 70 * Math.sin(angle + side) }));
    const touch = (type: 'touchStart' | 'touchMove' | 'touchEnd', touchPoints: { x: number; y: number }[]) => session.send('Input.dispatchTouchEvent', { type, touchPoints });
    // A pinch with a tiny turn does not turn the map.
    await touch('touchStart', fingers(0));
    await touch('touchMove', fingers(0.04));
    await touch('touchEnd', []);
    expect((await lab.state()).camera.angle).toBe(0);
    await touch('touchStart', fingers(0));
    for (let step = 1; step <= 20; step += 1) await touch('touchMove', fingers(-0.05 * step));
    await touch('touchEnd', []);
    // A radian, minus the turn needed to begin.
    expect((await lab.state()).camera.angle).toBeGreaterThan(0.7);
    expect((await lab.state()).camera.angle).toBeLessThan(1.01);
    return;
  }
  await page.mouse.move(box.x + box.width / 2 + 150, box.y + box.height / 2);
  await page.keyboard.down('Shift');
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2 - 150, { steps: 10 });
  await page.mouse.up();
  await page.keyboard.up('Shift');
  expect((await lab.state()).camera.angle).toBeGreaterThan(1.4);
  expect((await lab.state()).camera.angle).toBeLessThan(1.7);
});

test('layers lie in the order that was chosen, also after a reload, until it is taken back', async ({ lab, page }) => {
  await stands(lab);
  await lab.show('layers');
  await lab.at('layer-order').click();
  const names = (): Promise<string[]> => page.locator('slam-legend li.order span').allInnerTexts();
  const before = await names();
  expect(before.at(-1), 'the ground').toBe('Occupancy grid');
  expect(before[0]).toBe('Robot');
  const usual = await lab.picture();
  // The cells over everything else hide what was drawn on the known part.
  while (await lab.at('lift-grid').isEnabled()) await lab.at('lift-grid').click();
  expect((await names())[0]).toBe('Occupancy grid');
  await page.waitForTimeout(500);
  const lifted = await lab.picture();
  expect((await lab.differing(usual, lifted)).part, 'it is seen').toBeGreaterThan(0.01);
  await page.reload();
  await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(0);
  await lab.show('layers');
  await lab.at('layer-order').click();
  expect(await names()).toEqual(['Occupancy grid', ...before.slice(0, -1)]);
  await lab.at('order-reset').click();
  expect(await names()).toEqual(before);
  await expect(lab.at('order-reset')).toBeHidden();
});

test('a layer is drawn to its place in the order', { tag: '@phone' }, async ({ lab, page, isMobile }) => {
  await lab.open();
  await lab.show('layers');
  await lab.at('layer-order').click();
  const names = (): Promise<string[]> => page.locator('slam-legend li.order span').allInnerTexts();
  const before = await names();
  const signs = page.locator('slam-legend li.order > svg');
  // The button is below the list.
  await signs.first().scrollIntoViewIfNeeded();
  const [from, to] = [(await signs.first().boundingBox())!, (await signs.nth(2).boundingBox())!];
  const [x, y, end] = [from.x + from.width / 2, from.y + from.height / 2, to.y + to.height / 2 + 4];
  if (isMobile) {
    const touch = await page.context().newCDPSession(page);
    await touch.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: [{ x, y }] });
    for (const at of [(y + end) / 2, end]) await touch.send('Input.dispatchTouchEvent', { type: 'touchMove', touchPoints: [{ x, y: at }] });
    await touch.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
  } else {
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x, end, { steps: 5 });
    await page.mouse.up();
  }
  await expect.poll(names, 'the uppermost lies third').toEqual([before[1], before[2], before[0], ...before.slice(3)]);
  await lab.at('order-reset').click();
  expect(await names()).toEqual(before);
});

test('the map stays turned as somebody turned it, also after a reload', async ({ lab, page }) => {
  await lab.open();
  await page.locator('body').press('q');
  await page.locator('body').press('q');
  const { angle } = (await lab.state()).camera;
  expect(angle).toBeGreaterThan(0.2);
  await page.reload();
  await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(0);
  expect((await lab.state()).camera.angle).toBeCloseTo(angle, 9);
  await lab.at('upright').click();
  await page.reload();
  await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(0);
  expect((await lab.state()).camera.angle).toBe(0);
});
