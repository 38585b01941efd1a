// The log of a run: each decision can be read and gone to, found by kind and words, and saved.
import { readFile } from 'node:fs/promises';
import { type LogEntry, linesOf, listed, MOST_ENTRIES, withEntry } from '../../www/src/log.ts';
import { expect, test } from './fixture.ts';

test('a line that stands for many opens to each of them, with its time and place, and leads there', { tag: '@phone' }, async ({ lab, page }) => {
  await lab.open();
  await lab.enter('arena');
  await lab.watch((s) => s.finished, 'it explores to its end', 90_000).toBe(true);
  await lab.show('log');
  const fold = lab.at('log-fold').first();
  await expect(fold).toHaveText(/^×\d+/);
  const count = Number(/\d+/.exec((await fold.textContent())!)![0]);
  expect(count).toBeGreaterThan(2);
  await fold.click();
  const legs = lab.at('log').locator('li li');
  await expect(legs).toHaveCount(count - 1);
  const texts = await legs.allInnerTexts();
  for (const text of texts) expect(text).toMatch(/\d:\d\d\s+Heads for a frontier at \(-?[\d.]+, -?[\d.]+\) m/);
  expect(new Set(texts).size, 'each is told').toBeGreaterThan(2);
  const leg = legs.first();
  const told = /(\d+):(\d\d)/.exec(await leg.innerText())!;
  await leg.getByRole('button').click();
  await expect.poll(async () => (await lab.state()).seeking).toBeNull();
  await lab.watch((s) => Math.floor(s.time), 'at its moment').toBe(60 * Number(told[1]) + Number(told[2]));
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
});

test('the log is filtered by kind and words, and what is listed is saved with its times', async ({ lab, page }) => {
  await lab.open();
  await lab.enter('arena');
  await lab.watch((s) => s.finished, 'it explores to its end', 90_000).toBe(true);
  await lab.show('log');
  const lines = lab.at('log').locator('li');
  await lab.at('log-kind').selectOption('good');
  await expect(lines).toHaveCount(1);
  await expect(lines).toContainText(/explored/i);
  await lab.at('log-kind').selectOption('all');
  await lab.at('log-search').fill('FRONTIER heads');
  await expect(lines).toHaveCount(1);
  const [file] = await Promise.all([page.waitForEvent('download'), lab.at('csv-log').click()]);
  expect(file.suggestedFilename()).toBe('log.csv');
  const [head, ...rows] = (await readFile(await file.path(), 'utf8')).trim().split('\r\n');
  expect(head).toBe('Time (s),Level,Text');
  expect(rows.length, 'all that the line stands for').toBeGreaterThan(2);
  for (const row of rows) expect(row).toMatch(/^[\d.]+,info,"Heads for a frontier at \(/);
  const times = rows.map((row) => Number(row.split(',')[0]));
  expect(times).toEqual(times.toSorted((a, b) => a - b));
  await lab.at('log-search').fill('no such words');
  await expect(lab.at('log')).toHaveText('Nothing of that kind.');
});

test('a log that is full keeps what stands alone, and drops the oldest leg', () => {
  const leg = (time: number): LogEntry => ({ time, level: 'info', text: `leg ${time}`, topic: 'task 1' });
  let log: readonly LogEntry[] = [{ time: 0, level: 'warn', text: 'Touched something' }];
  for (let time = 1; time < MOST_ENTRIES + 10; time += 1) log = withEntry(log, leg(time));
  expect(log).toHaveLength(MOST_ENTRIES);
  expect(log[0]).toMatchObject({ level: 'warn' });
  expect(log[1]).toEqual(leg(11));
  expect(linesOf(log).map(({ earlier }) => earlier.length)).toEqual([MOST_ENTRIES - 2, 0]);
  expect(listed(log, 'all', 'leg 1999', (text) => text)).toEqual([leg(1999)]);
  // If no entry can be spared, the oldest is dropped.
  let alone: readonly LogEntry[] = [];
  for (let time = 0; time <= MOST_ENTRIES; time += 1) alone = withEntry(alone, { time, level: 'info', text: '' });
  expect(alone[0]!.time).toBe(1);
});
