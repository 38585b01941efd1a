// The page of the fleet with nothing simulated: a router, three bridges and a driver, each in a
// process of its own, and the page of one bridge, which sees and stops them all.
//
// `cargo xtask report fleet` builds the programs and runs it. A bridge with Zenoh takes minutes to
// compile, so `cargo xtask test` does not include it.
import { mkdtemp, readFile, rm } from 'node:fs/promises';
import { writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Page } from '@playwright/test';
import { Bridge } from './bridge.ts';
import { expect, test as base } from './fixture.ts';
import { Driver, killAll, Router } from './router.ts';

const NAMES = ['anna', 'berta', 'clara'] as const;
/** How often a robot is driven and stopped. */
const ROUNDS = 6;
/** At most, from the press until the driver is told, ms. */
const TOLD = 200;
/** At most, from the press until the page shows it, ms: it asks five times a second, and draws. */
const SHOWN = 1000;

const test = base.extend<{ folder: string; robots: { bridge: Bridge; token: string }[]; router: Router }>({
  folder: async ({}, use) => {
    const folder = await mkdtemp(join(tmpdir(), 'slamlab-fleet-'));
    await use(folder);
    await killAll();
    await Bridge.stopAll();
    await rm(folder, { recursive: true });
  },
  router: async ({ folder }, use) => {
    expect(folder).not.toBe('');
    await use(await Router.start());
  },
  robots: async ({ folder, router }, use) => {
    const robots = [];
    for (const name of NAMES) {
      const file = join(folder, name);
      const bridge = await Bridge.start([
        '--source', 'sim:arena,lidar', '--zenoh', router.endpoint, '--zenoh-name', name, '--token-file', file, '--map',
      ]);
      robots.push({ bridge, token: (await readFile(file, 'utf8')).trim() });
    }
    await use(robots);
  },
});

const row = (page: Page, name: string) => page.locator(`[data-name="${name}"]`);

test('three robots are seen by name, stopped from another’s page, and missed when they go', async ({ page, robots, router, problems }) => {
  test.setTimeout(240_000);
  const [anna, berta, clara] = robots as [typeof robots[0], typeof robots[0], typeof robots[0]];
  await page.goto(`${berta.bridge.url}fleet.html`);
  for (const name of NAMES) await expect(row(page, name)).toHaveAttribute('data-state', 'standing');
  await expect(page.locator('header')).toContainText('3 of 3 robots here');
  await row(page, 'anna').getByRole('button').first().click();
  await expect(row(page, 'anna').getByRole('link', { name: 'Open its page' })).toHaveAttribute('href', anna.bridge.url);
  // It maps, so it is drawn.
  await expect(page.locator('option', { hasText: 'anna' })).toBeAttached();

  const told: number[] = [];
  const shown: number[] = [];
  for (let round = 0; round < ROUNDS; round += 1) {
    // Alternately one alone, and all.
    const alone = round % 2 === 0;
    const [name, { token }] = alone ? ['anna', anna] as const : ['clara', clara] as const;
    const driver = await Driver.drives(router, name, token);
    await expect(row(page, name)).toHaveAttribute('data-state', 'driving');
    await expect(row(page, alone ? 'clara' : 'anna')).toHaveAttribute('data-state', 'standing');
    // Measured from where the press arrives, to exclude the work of Playwright before it.
    const button = page.getByRole('button', { name: alone ? 'Stop anna' : 'Stop all' });
    const pressed = button.evaluate((element) => new Promise<number>((done) => element.addEventListener('click', () => done(Date.now()), { once: true, capture: true })));
    const standing = page.evaluate((name) => new Promise<number>((done) => {
      const list = document.querySelector('slam-fleet')!.shadowRoot!;
      const look = () => (list.querySelector(`[data-name="${name}"]`)?.getAttribute('data-state') === 'standing' ? done(Date.now()) : requestAnimationFrame(look));
      look();
    }), name);
    await button.click();
    const { reason, told_at_ms } = await driver.stopped();
    expect(reason).toBe('stop');
    told.push(told_at_ms - await pressed);
    shown.push(await standing - await pressed);
    await expect(page.getByRole('status')).toContainText(alone ? 'Stop was sent to anna' : 'Stop was sent to all robots');
  }

  // A process that dies takes its robot off the router, and the page says so.
  const died = Date.now();
  await clara.bridge.stop('SIGKILL');
  await expect(row(page, 'clara')).toHaveAttribute('data-state', 'away');
  const away = Date.now() - died;
  await expect(page.locator('header')).toContainText('2 of 3 robots here');
  await expect(page.getByRole('button', { name: 'Stop clara' })).toBeDisabled();

  // The router dies: nothing can be stopped from here, and a press says so.
  const cut = Date.now();
  await router.kill();
  await expect(page.getByRole('alert')).toContainText('lost the router');
  const lost = Date.now() - cut;
  expect(problems, 'nothing went wrong until here').toEqual([]);
  await page.getByRole('button', { name: 'Stop all' }).click();
  await expect(page.getByRole('status')).toContainText('Stop was NOT sent');
  // The refusal above, noted by the browser.
  for (const problem of problems.splice(0)) expect(problem).toContain('503');

  // It comes back, with the robots that are still alive.
  const back = Date.now();
  await Router.start(router.endpoint);
  await expect(page.locator('header')).toContainText('2 of 3 robots here', { timeout: 30_000 });
  await expect(page.getByRole('alert')).toHaveCount(0);
  const returned = Date.now() - back;
  await expect(row(page, 'anna')).toHaveAttribute('data-state', 'standing');
  await expect(row(page, 'clara')).toHaveAttribute('data-state', 'away');

  expect(problems, 'nothing went wrong until here').toEqual([]);
  // If a page still asks while its bridge ends, the browser reports it.
  await page.close();
  problems.length = 0;

  const holds = Math.max(...told) <= TOLD && Math.max(...shown) <= SHOWN;
  const figures = {
    rounds: ROUNDS, from_press_to_driver_told_ms: told, from_press_to_shown_ms: shown,
    from_killed_bridge_to_away_ms: away, from_killed_router_to_said_ms: lost, from_router_to_robots_back_ms: returned,
    limits: { told_ms: TOLD, shown_ms: SHOWN },
  };
  if (process.env.SLAMLAB_FIGURES) writeFileSync(process.env.SLAMLAB_FIGURES, JSON.stringify({ report: 'fleet-router', holds, figures }, null, 2));
  expect(holds, JSON.stringify(figures)).toBe(true);
});
