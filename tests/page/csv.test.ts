// Everything that shows figures can save them: each plot and each table as CSV.
import { readFileSync, readdirSync } from 'node:fs';
import type { Page } from '@playwright/test';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

const SOURCES = new URL('../../www/src/', import.meta.url);

test('each part that draws curves or tables of figures has a way to save them', () => {
  const files = readdirSync(SOURCES, { recursive: true }).map(String).filter((name) => name.endsWith('.ts') && !/^words[/\\]/.test(name));
  const shows = files.filter((name) => /extends Slam(?:Plotted|Charts)\b|<table\b|extends LabBasin|class LabBasin|receiver operating/.test(readFileSync(new URL(name.replaceAll('\\', '/'), SOURCES), 'utf8')));
  expect(shows.length).toBeGreaterThan(8);
  // Charts provide saving for all components made of them.
  const saves = (text: string): boolean => /<slam-csv\b|data-testid="(?:race-)?csv"|extends SlamCharts\b/.test(text);
  const without = shows.filter((name) => name !== 'ui/plotted.ts' && name !== 'ui/charts.ts' && !saves(readFileSync(new URL(name.replaceAll('\\', '/'), SOURCES), 'utf8')));
  expect(without).toEqual([]);
});

async function saved(lab: Lab, page: Page, name: string): Promise<string[][]> {
  const button = lab.at(`csv-${name}`);
  await button.scrollIntoViewIfNeeded();
  const download = page.waitForEvent('download');
  await button.click();
  const file = await download;
  expect(file.suggestedFilename()).toBe(`${name}.csv`);
  return readFileSync(await file.path(), 'utf8').trimEnd().split('\r\n').map((line) => line.split(','));
}

test('the bench is saved with all its digits', async ({ lab, page }) => {
  await lab.open();
  await lab.pause();
  await lab.show('plots');
  await lab.at('bench').locator('summary').click();
  await expect(lab.at('bench-heading')).toHaveText(/against/);
  const [header = [], ...rows] = await saved(lab, page, 'bench');
  expect(header.join(',')).toBe('Time (s),"Speed, wished (m/s)","Speed, left, with controller (m/s)","Speed, right, with controller (m/s)","Speed, left, without (m/s)","Speed, right, without (m/s)","Heading, with controller (°)","Heading, without (°)"');
  expect(rows.length).toBeGreaterThan(100);
  expect(Number(rows.at(-1)?.[0])).toBeCloseTo(5, 1);
});

test('calibration and σ are saved with all their digits', async ({ lab, page }) => {
  await lab.open();
  await lab.pause();
  await lab.show('settings');
  await lab.at('calibration').locator('summary').click();
  const pairs = await saved(lab, page, 'calibration-pairs');
  expect(pairs.length).toBeGreaterThan(6);
  expect((await saved(lab, page, 'calibration-curve')).length).toBeGreaterThan(pairs.length);
  await lab.at('sigma').locator('summary').click();
  await lab.at('estimate-sigma').click();
  const bins = await saved(lab, page, 'sigma-measured');
  expect(bins[0]).toEqual(['Range (m)', 'σ (m)']);
  expect(bins.length).toBeGreaterThan(3);
  const numbers = bins.slice(1).map((cells) => cells.map(Number));
  // A lidar has errors of millimetres to centimetres; readings on edges may have larger ones.
  expect(numbers.every(([range = NaN, sigma = NaN]) => range > 0 && sigma >= 0), JSON.stringify(numbers)).toBe(true);
  expect(numbers.filter(([, sigma = NaN]) => sigma > 1e-4 && sigma < 0.1).length).toBeGreaterThan(numbers.length / 2);
  expect((await saved(lab, page, 'sigma-curve')).length).toBeGreaterThan(10);
});

test('the planners are saved, with their lengths over time', async ({ lab, page }) => {
  await lab.open();
  await lab.pause();
  await lab.show('paths');
  await lab.at('contest-seconds').selectOption('0.2');
  // In the next room to the north-east of the start of `office`.
  await lab.pointAt(4.4, 2.6, false);
  await expect(lab.at('contest-table')).toBeVisible();
  await expect(lab.at('contest-again')).toBeVisible({ timeout: 30_000 });
  const planners = await saved(lab, page, 'planners');
  const lengths = planners.slice(1).map(([, length]) => Number(length)).filter((length) => length > 0);
  expect(lengths.length).toBeGreaterThan(3);
  expect((await saved(lab, page, 'planners-over-time')).length).toBeGreaterThan(lengths.length);
});
