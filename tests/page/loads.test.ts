// The page loads completely, under its security policy, and fits the screen. The tests beside this
// file cover its functions.
import { expect, test } from './fixture.ts';

test('the page loads without an error and names itself', { tag: '@phone' }, async ({ page, problems }) => {
  await page.goto('/');
  await expect(page).toHaveTitle(/slamlab/i);
  await expect(page.locator('body')).toBeVisible();
  await page.waitForLoadState('networkidle');
  expect(problems).toEqual([]);
});

test('the page is cross-origin isolated and may not run inline scripts', async ({ page, problems }) => {
  const answer = await page.goto('/');
  const policy = answer?.headers()['content-security-policy'] ?? '';
  expect(policy).toContain("default-src 'none'");
  expect(policy).not.toContain("'unsafe-inline'");
  expect(await page.evaluate(() => globalThis.crossOriginIsolated)).toBe(true);
  const ran = await page.evaluate(() => {
    const script = document.createElement('script');
    script.textContent = 'globalThis.inlineRan = true';
    document.head.append(script);
    return 'inlineRan' in globalThis;
  });
  expect(ran).toBe(false);
  problems.length = 0; // the refusal is reported on the console, as it should be
});

test('nothing sticks out sideways', { tag: '@phone' }, async ({ page }) => {
  await page.goto('/');
  await page.waitForLoadState('networkidle');
  const excess = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  expect(excess).toBeLessThanOrEqual(0);
});

test('every kind of file that is opened is named, to see and to hear', async ({ lab, page }) => {
  await lab.open();
  const hint = page.locator('slam-setup details.muted');
  for (const ending of ['.bag', '.mcap', '.clf', '.log', '.csv', '.txt', '.gz', '.slamlab', '.g2o', '.json', '.svg', '.smap', 'OGmap.txt', '.yaml', '.pgm', '.png']) {
    await expect(hint).toContainText(ending);
    expect(await lab.at('file').getAttribute('aria-label')).toContain(ending);
  }
});

test('the module arrives compressed and typed', async ({ page }) => {
  const module = page.waitForResponse((response) => response.url().endsWith('.wasm'));
  await page.goto('/');
  const headers = await (await module).allHeaders();
  expect(headers['content-type']).toBe('application/wasm');
  expect(headers['content-encoding']).toMatch(/^(br|gzip)$/);
});

test('play and Stop are in reach on a phone held sideways', { tag: '@phone-only' }, async ({ lab, page }) => {
  await page.setViewportSize({ width: 844, height: 390 });
  await lab.open();
  await lab.at('mode-manual').tap();
  for (const id of ['play', 'stop', 'stick']) await expect(lab.at(id), id).toBeInViewport({ ratio: 1 });
  const stick = (await lab.at('stick').boundingBox())!;
  for (const name of ['Zoom in', 'Zoom out', 'Show everything', 'Follow the robot']) {
    const tool = (await page.getByRole('button', { name, exact: true }).boundingBox())!;
    expect(tool.x >= stick.x + stick.width || tool.y + tool.height <= stick.y, `${name} is free of the stick`).toBe(true);
  }
});
