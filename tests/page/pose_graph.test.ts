// A pose graph is saved as g2o, and a foreign one is solved and drawn.
import { readFile } from 'node:fs/promises';
import type { Download } from '@playwright/test';
import { expect, test } from './fixture.ts';
import { drop } from './lab.ts';
import { record } from './recording.ts';

/** Two measured paths of 1 m and 1.2 m, with information 1 and 3, from an initial guess of 3 m: the
    least cost is at their weighted mean, 1.15 m, where χ² is 0.03. */
const TWO_WAYS = `VERTEX_SE2 0 0 0 0
VERTEX_SE2 1 3 0 0
VERTEX_XY 7 0 0
EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1
EDGE_SE2 0 1 1.2 0 0 3 0 0 3 0 3
`;

async function textOf(coming: Promise<Download>): Promise<{ name: string; text: string }> {
  const download = await coming;
  return { name: download.suggestedFilename(), text: (await readFile(await download.path())).toString() };
}

test('the pose graph of a recording is saved, and solved again it stays as it is', async ({ lab, page }) => {
  await lab.open();
  await drop(page, 'laps.log', Buffer.from(record(300).text));
  await lab.watch((s) => s.source === 'replay' && s.finished, 'the recording ends', 60_000).toBe(true);
  await lab.show('run');
  const coming = page.waitForEvent('download');
  await lab.save('g2o');
  const { name, text } = await textOf(coming);
  expect(name).toBe('laps.g2o');
  const lines = (tag: string): number => text.split('\n').filter((line) => line.startsWith(`${tag} `)).length;
  expect(lines('VERTEX_SE2')).toBeGreaterThan(2);
  expect(lines('EDGE_SE2'), 'each submap is joined to the one before').toBeGreaterThanOrEqual(lines('VERTEX_SE2') - 1);
  expect(text).toContain('FIX 0\n');

  await drop(page, name, Buffer.from(text));
  await expect(lab.at('graph-says')).toContainText(`${lines('VERTEX_SE2')} poses, ${lines('EDGE_SE2')} edges.`);
});

test('a method without a pose graph says so', async ({ lab }) => {
  await lab.open();
  await lab.show('run');
  await lab.at('save').click();
  await expect(lab.at('saving-g2o')).toBeDisabled();
  await expect(lab.at('saving-about-g2o')).toContainText('this method keeps no pose graph: choose scan matching');
});

test('a pose graph of others is solved and drawn', { tag: '@phone' }, async ({ lab, page }) => {
  await lab.open();
  const { title } = await lab.state();
  await drop(page, 'ways.g2o', Buffer.from(TWO_WAYS));
  await expect(lab.at('graph-picture'), 'it is shown at once').toBeInViewport();
  await expect(lab.at('graph-says')).toHaveText(/^ways\.g2o: 2 poses, 2 edges\. χ² 13\.72 as the file has them, 0\.03 solved in \d+ steps\.$/);
  await expect(page.getByText('Left out: 1 of VERTEX_XY.')).toBeVisible();
  const colours = await lab.at('graph-picture').evaluate((canvas: HTMLCanvasElement) => {
    const { data } = canvas.getContext('2d')!.getImageData(0, 0, canvas.width, canvas.height);
    return new Set(Array.from({ length: data.length / 4 }, (_, i) => data.slice(4 * i, 4 * i + 4).join())).size;
  });
  expect(colours, 'both are drawn').toBeGreaterThan(2);
  const coming = page.waitForEvent('download');
  await lab.at('graph-save').click();
  const { name, text } = await textOf(coming);
  expect(name).toBe('ways-solved.g2o');
  const [, x] = /^VERTEX_SE2 1 (\S+) /m.exec(text) ?? [];
  expect(Number(x)).toBeCloseTo(1.15, 6);
  expect((await lab.state()).title, 'the run goes on').toBe(title);
  await lab.at('graph-close').click();
  await expect(lab.at('graph-says')).toBeHidden();

  await drop(page, 'bad.g2o', Buffer.from(TWO_WAYS.replace('1.2', 'far')));
  await lab.says('bad.g2o: line 5: field 3 is `far`');
});
