// The page of many robots: urgent ones come first, and each is found, shown and stopped.
import { AxeBuilder } from '@axe-core/playwright';
import { expect, test } from './fixture.ts';
import { robot, SimulatedFleet } from './fleet.ts';

test('what needs somebody comes first, and each is found by name @phone', async ({ page }) => {
  const fleet = SimulatedFleet.of(12);
  Object.assign(fleet.robots[3]!, { alert: { severity: 'warning', text: 'The left motor is hot.', heard: 0 } });
  Object.assign(fleet.robots[5]!, { here: false });
  Object.assign(fleet.robots[7]!.safety!, { emergency: true, armed: false, reason: 'emergency-stop' });
  Object.assign(fleet.robots[9]!, { heard: -5 });
  Object.assign(fleet.robots[11]!, { pose_state: 'lost' });
  // A bridge that has just started: the link came up, and nobody was driving.
  Object.assign(fleet.robots[1]!.safety!, { armed: false, reason: 'link', driver: '' });
  Object.assign(fleet.robots[2]!.safety!, { armed: false, reason: 'link', driver: 'anna' });
  await fleet.serve(page);
  await page.goto('fleet.html');
  const rows = page.locator('li');
  await expect(rows).toHaveCount(12);
  const names = await rows.evaluateAll((all) => all.slice(0, 7).map((one) => one.getAttribute('data-name')));
  expect(names).toEqual(['robot-007', 'robot-005', 'robot-009', 'robot-002', 'robot-003', 'robot-011', 'robot-000']);
  await expect(page.locator('[data-name="robot-001"]')).toHaveAttribute('data-state', 'standing');
  await expect(page.locator('header')).toContainText('11 of 12 robots here');
  await expect(page.locator('header')).toContainText('6 need attention');
  await page.getByRole('textbox', { name: 'Search by name' }).fill('-003');
  await expect(rows).toHaveCount(1);
  await rows.getByRole('button', { name: /robot-003/ }).first().click();
  await expect(rows).toContainText('The left motor is hot.');
  await expect(rows.getByRole('link', { name: 'Open its page' })).toHaveAttribute('href', 'http://127.0.0.1:1/');
});

test('one is stopped, and all are, by hand and by key @phone', async ({ page }) => {
  const fleet = SimulatedFleet.of(3);
  await fleet.serve(page);
  await page.goto('fleet.html');
  await page.getByRole('button', { name: 'Stop robot-001' }).click();
  await expect(page.locator('[data-name="robot-001"]')).toHaveAttribute('data-state', 'standing');
  await expect(page.locator('[data-name="robot-000"]')).toHaveAttribute('data-state', 'driving');
  await page.getByRole('button', { name: 'Stop all' }).click();
  await expect(page.locator('[data-state="driving"]')).toHaveCount(0);
  await page.keyboard.press('Shift+S');
  await expect.poll(() => fleet.stops).toEqual(['robot-001', '*', '*']);
  await page.getByRole('textbox').focus();
  await page.keyboard.press('Shift+S');
  await expect(page.getByRole('textbox')).toHaveValue('S');
  expect(fleet.stops, 'a typed S stops nobody').toHaveLength(3);
});

test('a stop that does not get through is said, and so is a bridge without a router', async ({ page, problems }) => {
  await SimulatedFleet.of(2).serve(page);
  await page.goto('fleet.html');
  await page.route(/\/fleet\/stop/, (route) => route.fulfill({ status: 503, body: 'There is no way to the router at the moment.' }));
  await page.getByRole('button', { name: 'Stop all' }).click();
  await expect(page.getByRole('status')).toContainText('Stop was NOT sent: There is no way to the router');
  await page.unroute('**/fleet.json?*');
  await expect(page.getByRole('alert')).toContainText('This bridge is at no router');
  problems.length = 0; // the 503 and 404 above
});

test('the page may do no more than it has to: neither modules of machine code nor workers', async ({ page, problems }) => {
  await SimulatedFleet.of(2).serve(page);
  await page.goto('fleet.html');
  await expect(page.locator('li')).toHaveCount(2);
  expect(problems, 'what it does is allowed').toEqual([]);
  const refused = await page.evaluate(async () => {
    const why = (error: Error): string => error.name;
    const compiled = await WebAssembly.compile(new Uint8Array([0, 0x61, 0x73, 0x6d, 1, 0, 0, 0])).then(() => 'compiled', why);
    const worker = await new Promise((tell) => {
      addEventListener('securitypolicyviolation', ({ effectiveDirective }) => effectiveDirective === 'worker-src' && tell(effectiveDirective));
      try {
        new Worker('worker.js').onmessage = () => tell('it runs');
      } catch {
        // The event reports it.
      }
    });
    return [compiled, worker];
  });
  expect(refused).toEqual(['CompileError', 'worker-src']);
  // The browser notes what it refused.
  await expect.poll(() => problems.length).toBeGreaterThan(0);
  problems.length = 0;
});

test('robots are drawn together only where their maps have one name', async ({ page }) => {
  const fleet = SimulatedFleet.of(3);
  fleet.robots.push({ ...robot('alone', 3), map_file: '' }, { ...robot('unplaced', 4), pose_state: 'unplaced' });
  await fleet.serve(page);
  await page.goto('fleet.html');
  await expect(page.locator('option')).toHaveText(['hall.slamlab: 3 robots', 'alone alone', 'unplaced alone']);
  await page.locator('[data-name="alone"] button').first().click();
  await expect(page.locator('select')).toHaveValue('robot:alone');
  await expect(page.locator('.frame')).toContainText('drawn alone');
});

for (const [colorScheme, width] of [['light', 360], ['dark', 1280]] as const) {
  test(`nothing of it keeps anybody out, ${colorScheme} and ${width} wide`, async ({ page }) => {
    await SimulatedFleet.of(30).serve(page);
    await page.emulateMedia({ colorScheme });
    await page.setViewportSize({ width, height: 740 });
    await page.goto('fleet.html');
    await page.locator('[data-name="robot-002"] button').first().click();
    const { violations } = await new AxeBuilder({ page }).analyze();
    expect(violations.map(({ id, nodes }) => `${id}: ${nodes[0]?.html}`)).toEqual([]);
    expect(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'nothing sticks out').toBe(true);
  });
}
