// An engineer with a log of their own, at a desk with a mouse: opens it, looks back in time, asks
// what another setting would have done, and takes figures and map to other programs.
import { filesIn } from './archive.ts';
import { expect, test } from './fixture.ts';
import { drop } from './lab.ts';
import { record } from './recording.ts';

test('an engineer opens a log, looks back, asks again and takes the result away', async ({ lab, page }) => {
  test.setTimeout(240_000);
  const { text, end } = record(240);
  await lab.open();
  await drop(page, 'workshop.log', Buffer.from(text));
  await expect.poll(async () => (await lab.state()).title, 'it is opened').toBe('workshop.log');
  await lab.watch((s) => s.finished, 'it is mapped', 120_000).toBe(true);
  const whole = await lab.status();
  expect(whole.scans).toBeGreaterThan(200);
  expect(Math.hypot(whole.x - end.x, whole.y - end.y), 'it ends where the robot did').toBeLessThan(0.3);

  // Back, by the time line.
  const line = lab.at('timeline');
  const box = (await line.boundingBox())!;
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
  await expect.poll(async () => (await lab.state()).seeking, { message: 'it arrives', timeout: 60_000 }).toBeNull();
  const half = await lab.status();
  expect(half.scans).toBeGreaterThan(whole.scans * 0.35);
  expect(half.scans).toBeLessThan(whole.scans * 0.65);

  // What would another method have made of it?
  await lab.show('run');
  await lab.at('method').selectOption('scan-matching');
  await expect.poll(async () => (await lab.state()).method).toBe('scan-matching');
  await lab.watch((s) => s.finished, 'it is mapped again', 120_000).toBe(true);
  const again = await lab.status();
  expect(Math.hypot(again.x - end.x, again.y - end.y), 'it ends there, too').toBeLessThan(0.2);

  // Taken away: the trajectory for tools that compare such, the map for those that drive in it.
  const coming = page.waitForEvent('download');
  await lab.save('map', 'tum');
  const files = [...await filesIn(await coming)];
  const named = (end: string): Buffer | undefined => files.find(([name]) => name.endsWith(end))?.[1];
  expect(['.pgm', '.yaml', '.tum'].filter((end) => !named(end)), 'they come').toEqual([]);
  const rows = named('.tum')!.toString().split('\n').filter((row) => row !== '' && !row.startsWith('#')).map((row) => row.split(' ').map(Number));
  expect(rows.length, 'a pose for each scan, or nearly').toBeGreaterThan(100);
  expect(rows.every((row) => row.length === 8 && row.every(Number.isFinite))).toBe(true);
  const last = rows.at(-1)!;
  expect(Math.hypot(last[1]! - again.x, last[2]! - again.y), 'the way ends where the robot is shown').toBeLessThan(0.15);
});
