// The registration lab: two clouds that are dragged, every method on them, a map of starts, and
// files read, drawn and refused.
import { AxeBuilder } from '@axe-core/playwright';
import type { Page } from '@playwright/test';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

const METHODS = ['point-to-point', 'point-to-line', 'surface-to-surface', 'ndt', 'cpd', 'gmm', 'correlation'];
const VERDICTS = /^(converged|degenerate|too-few-points|not-converged|local-minimum|ambiguous)$/;

async function openLab(lab: Lab): Promise<void> {
  await lab.open();
  await lab.pause();
  await lab.at('registration').click();
  await expect(lab.at('lab-verdict-correlation')).toHaveAttribute('data-verdict', VERDICTS, { timeout: 30_000 });
}

/** x, y and turn of the start, as shown. */
async function start(lab: Lab): Promise<number[]> {
  const text = (await lab.at('lab-start').innerText()).replaceAll('−', '-');
  return [...text.matchAll(/-?\d+\.\d+/g)].map(Number);
}

async function settled(lab: Lab): Promise<void> {
  for (const method of METHODS) await expect(lab.at(`lab-verdict-${method}`)).toHaveAttribute('data-verdict', VERDICTS);
}

/** The middle of the large picture, page pixels. */
async function middle(lab: Lab): Promise<[number, number]> {
  await lab.at('lab-clouds').scrollIntoViewIfNeeded();
  const box = (await lab.at('lab-clouds').boundingBox())!;
  return [box.x + box.width / 2, box.y + box.height / 2];
}

async function give(page: Page, role: string, name: string, text: string): Promise<void> {
  await page.getByTestId(`lab-file-${role}`).setInputFiles({ name, mimeType: 'text/csv', buffer: Buffer.from(text) });
}

/** An L of points, moved and turned. */
function corner(dx: number, dy: number, turn: number): string {
  const points = Array.from({ length: 120 }, (_, i) => (i < 60 ? [1 + 0.05 * i, 2] : [1, 2 - 0.05 * (i - 60)]));
  const [c, s] = [Math.cos(turn), Math.sin(turn)];
  return `x,y\n${points.map(([x = 0, y = 0]) => `${c * x - s * y + dx},${s * x + c * y + dy}`).join('\n')}\n`;
}

test('the lab is loaded when it is opened, runs every method and advises one', { tag: '@phone' }, async ({ lab, page }) => {
  const asked: string[] = [];
  page.on('request', (request) => asked.push(new URL(request.url()).pathname));
  await lab.open();
  expect(asked.filter((path) => path.includes('registration')), 'the first visit does without it').toEqual([]);
  await lab.at('registration').click();
  await settled(lab);
  expect(asked.filter((path) => path.endsWith('registration.js')).length).toBe(1);
  await expect(lab.at('lab-verdict-correlation')).toHaveAttribute('data-verdict', 'converged');
  await expect(lab.at('lab-advice')).toContainText('measured pairs');
  expect(METHODS).toContain(await lab.at('lab-advice').getAttribute('data-method'));
  for (const method of METHODS) {
    await expect(lab.at(`lab-method-${method}`).locator('math')).toBeVisible();
    await expect(lab.at(`lab-method-${method}`).locator('cite')).toHaveText(/\d{4}/);
  }
  expect(await page.evaluate(() => {
    const root = document.querySelector('slam-registration')!;
    return root.scrollWidth - root.clientWidth;
  }), 'nothing sticks out sideways').toBeLessThanOrEqual(0);
  await page.keyboard.press('Escape');
  await expect(page.locator('slam-registration')).toHaveCount(0);
});

test('the moving cloud is dragged, turned by wheel, handle and keys, and taken back', async ({ lab, page }) => {
  await openLab(lab);
  expect(await start(lab)).toEqual([0, 0, 0]);
  const [x, y] = await middle(lab);
  await page.mouse.move(x - 150, y - 60);
  await page.mouse.down();
  await page.mouse.move(x - 110, y - 80, { steps: 5 });
  await page.mouse.up();
  const [dragged, up, turned] = await start(lab);
  expect(dragged).toBeGreaterThan(0.1);
  expect(up).toBeGreaterThan(0.05);
  expect(turned).toBe(0);
  await page.mouse.wheel(0, -300);
  await expect.poll(async () => Math.abs((await start(lab))[2]!), 'the wheel turns').toBeGreaterThan(1);
  await lab.at('lab-clouds').focus();
  await page.keyboard.press('Home');
  expect(await start(lab)).toEqual([0, 0, 0]);
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('Shift+ArrowUp');
  expect((await start(lab)).slice(0, 2)).toEqual([0.05, 0.25]);
  await page.keyboard.press('q');
  expect((await start(lab))[2]).toBeCloseTo(2, 1);
  expect((await lab.state()).playing, 'the robot does not hear these keys').toBe(false);
  await settled(lab);
  // From the right pose the best methods stay there.
  await lab.at('lab-truth').click();
  await expect(lab.at('lab-verdict-point-to-line')).toHaveAttribute('data-verdict', 'converged');
});

test('iterations are shown one by one, and played to the end', async ({ lab }) => {
  await openLab(lab);
  const slider = lab.at('lab-slider');
  await expect(lab.at('lab-at-cpd')).toHaveText(/^end, after \d+$/);
  await slider.fill('0');
  await expect(lab.at('lab-at-point-to-line')).toHaveText(/^1 \/ \d+ · kernel 50\.0 cm · \d+ pairs$/);
  await expect(lab.at('lab-at-ndt')).toHaveText(/^1 \/ \d+ · cell 2\.00 m · \d+ pairs$/);
  await expect(lab.at('lab-at-cpd')).toHaveText(/^1 \/ \d+ · σ \d/);
  await lab.at('lab-step').click();
  await expect(lab.at('lab-at-point-to-line')).toHaveText(/^2 \/ \d+ · kernel 25\.0 cm/);
  await slider.fill(String(Number(await slider.getAttribute('max')) - 3));
  await lab.at('lab-play').click();
  await expect(lab.at('lab-at-cpd')).toHaveText(/^end/);
  await expect(lab.at('lab-play')).toHaveAttribute('aria-label', 'Play the iterations');
});

test('a corridor is called degenerate, and every method says along what', async ({ lab }) => {
  await openLab(lab);
  await lab.at('lab-pair-corridor').click();
  await expect(lab.at('lab-verdict-correlation')).toHaveAttribute('data-verdict', 'degenerate');
  await expect(lab.at('lab-verdict-correlation')).toHaveText(/nothing tells how far along \d+°/);
});

test('a map of starts is filled to the end, and can be cancelled', { tag: '@phone' }, async ({ lab }) => {
  await openLab(lab);
  await lab.at('basin-cells').selectOption('15');
  await lab.at('basin-fill').click();
  await expect(lab.at('basin-progress')).toHaveAttribute('data-state', 'done', { timeout: 60_000 });
  expect(await lab.at('basin-progress').evaluate((bar) => (bar as HTMLProgressElement).value)).toBe(1);
  await expect(lab.at('basin-words')).toHaveText(/found from [1-9]\d* % of 225 starts/);
  // A slow method on many cells leaves time to cancel it.
  await lab.at('basin-method').selectOption('gmm');
  await lab.at('basin-cells').selectOption('41');
  await lab.at('basin-fill').click();
  await expect.poll(() => lab.at('basin-progress').evaluate((bar) => (bar as HTMLProgressElement).value)).toBeGreaterThan(0);
  await lab.at('basin-cancel').click();
  await expect(lab.at('basin-progress')).toHaveAttribute('data-state', 'cancelled');
  await expect(lab.at('basin-words')).toHaveText(/^Cancelled after \d+ of 1681 starts/);
  await expect(lab.at('basin-fill')).toBeEnabled();
  // The other methods still answer.
  await lab.at('lab-reset').click();
  await settled(lab);
});

test('files are read, and a bad one is refused in words while the clouds stay', async ({ lab, page }) => {
  await openLab(lab);
  await lab.at('lab-pair-files').click();
  await give(page, 'fixed', 'a.csv', corner(0, 0, 0));
  await give(page, 'moving', 'b.csv', corner(0.2, -0.1, 0.1));
  await expect(lab.at('lab-verdict-point-to-line')).toHaveAttribute('data-verdict', 'converged');
  await give(page, 'moving', 'broken.csv', '1,2\n3,x\n');
  await expect(lab.at('lab-error')).toHaveText('broken.csv: list of points, line 2: y is `x`, expected a finite number');
  await expect(page.getByText('moving, 120 points')).toBeVisible();
  await give(page, 'moving', 'empty.csv', '# nothing\n');
  await expect(lab.at('lab-error')).toHaveText('empty.csv: list of points: no line has a point, expected x and y in each');
  await expect(lab.at('lab-verdict-point-to-line')).toHaveAttribute('data-verdict', 'converged');
  await give(page, 'moving', 'b.csv', corner(0.1, 0.1, -0.1));
  await expect(lab.at('lab-error')).toHaveCount(0);
});

test('clouds are drawn by hand and laid on each other', async ({ lab, page }) => {
  await openLab(lab);
  await lab.at('lab-pair-drawn').click();
  const [x, y] = await middle(lab);
  await page.mouse.move(x - 160, y - 60);
  await page.mouse.down();
  for (const [dx, dy] of [[120, -60], [120, 70], [-40, 70]] as const) await page.mouse.move(x + dx, y + dy, { steps: 12 });
  await page.mouse.up();
  await expect(page.getByText(/^fixed, [1-9]\d+ points$/)).toBeVisible();
  await lab.at('lab-copy').click();
  await settled(lab);
  await expect(lab.at('lab-verdict-cpd')).toHaveAttribute('data-verdict', 'converged');
});

test('two scans of the run behind the page are laid on each other', async ({ lab }) => {
  await lab.open();
  await lab.at('registration').click();
  await settled(lab);
  await expect(async () => {
    await lab.at('lab-pair-run').click();
    await expect(lab.at('lab-keyframe-fixed')).toBeVisible({ timeout: 1000 });
  }).toPass({ timeout: 40_000 });
  await settled(lab);
  await expect(lab.at('lab-pair-run')).toHaveAttribute('aria-pressed', 'true');
});

test('a finger drags the cloud on a phone, and the page stays in its width', { tag: '@phone-only' }, async ({ lab, page }) => {
  await openLab(lab);
  const [x, y] = await middle(lab);
  const session = await page.context().newCDPSession(page);
  const touch = (type: string, points: { x: number; y: number }[]) => session.send('Input.dispatchTouchEvent', { type: type as 'touchStart', touchPoints: points });
  await touch('touchStart', [{ x: x - 60, y: y - 60 }]);
  for (let i = 1; i <= 5; i += 1) await touch('touchMove', [{ x: x - 60 + 8 * i, y: y - 60 }]);
  await touch('touchEnd', []);
  expect((await start(lab))[0]).toBeGreaterThan(0.1);
  expect(await page.evaluate(() => document.querySelector('slam-registration')!.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  for (const id of ['lab-close', 'lab-pair-office']) expect((await lab.at(id).boundingBox())!.height, id).toBeGreaterThanOrEqual(44);
});

test('the lab can be read by everybody', { tag: '@phone' }, async ({ lab, page }) => {
  await openLab(lab);
  for (const scheme of ['light', 'dark'] as const) {
    await page.emulateMedia({ colorScheme: scheme, reducedMotion: 'reduce' });
    const { violations } = await new AxeBuilder({ page }).include('slam-registration').analyze();
    expect(violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.target.join(' ')).join(', ')}`), scheme).toEqual([]);
  }
});
