// Poses of another file: with a recording they are its odometry or its truth, alone a path beside
// the run.
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';
import { readFileSync } from 'node:fs';

const SCANS = 40;

/** A robot drives 2 m along a room of 8 x 4 m, a scan a second; its odometry is a tenth too
    long. */
function log(): string {
  const lines = Array.from({ length: SCANS }, (_, i) => {
    const x = 0.05 * i;
    const ranges = Array.from({ length: 180 }, (_, beam) => {
      const [sin, cos] = [Math.sin((beam - 90) * Math.PI / 180), Math.cos((beam - 90) * Math.PI / 180)];
      return Math.min(cos > 1e-9 ? (5 - x) / cos : Infinity, Math.abs(sin) > 1e-9 ? 2 / Math.abs(sin) : Infinity).toFixed(3);
    });
    return `FLASER 180 ${ranges.join(' ')} ${1.1 * x} 0 0 ${1.1 * x} 0 0 ${100 + i}.5 host ${100 + i}.5`;
  });
  return `${lines.join('\n')}\n`;
}

/** Its true poses, between the scans, in a frame of their own. */
function poses(from = 0, to = SCANS + 1): string {
  const rows = Array.from({ length: to - from }, (_, k) => {
    const i = from + k;
    const along = 0.05 * (i - 0.7);
    return `90;${(7).toFixed(1)};${(3 + along).toFixed(6)};${(99.8 + i).toFixed(3)}`;
  });
  return `yaw_deg;x;y;time\n${rows.join('\n')}\n`;
}

const file = (name: string, text: string) => ({ name, mimeType: 'text/plain', buffer: Buffer.from(text) });

async function give(lab: Lab, ...files: ReturnType<typeof file>[]): Promise<void> {
  await lab.open();
  await lab.show('run');
  await lab.at('file').setInputFiles(files);
}

const mapped = (lab: Lab) => lab.watch((s) => s.source === 'replay' && s.finished, 'it is mapped').toBe(true);

test('poses that are odometry take its place', async ({ lab, page }) => {
  await give(lab, file('drive.log', log()), file('poses.csv', poses()));
  await expect(lab.at('poses')).toContainText('poses.csv tells where a robot was, on the clock of drive.log');
  await lab.at('poses-odometry').click();
  await mapped(lab);
  const status = await lab.status();
  expect(status.odometryX).toBeCloseTo(0.05 * (SCANS - 1), 2);
  await lab.show('log');
  await expect(page.locator('#log-panel')).toContainText('how the robot moved is told by the poses of another file');

  // They are kept with the recording: on the next visit they are the same.
  await expect.poll(() => page.evaluate(() => localStorage.getItem('slamlab-last-run') ?? ''), { timeout: 30_000 }).toContain('drive.log');
  await page.reload();
  await lab.at('go-on').click();
  await mapped(lab);
  expect((await lab.status()).odometryX).toBeCloseTo(0.05 * (SCANS - 1), 2);
});

test('poses that are true give error curves, which are saved', async ({ lab, page }) => {
  await give(lab, file('drive.log', log()), file('poses.csv', poses(0, 31)));
  await lab.at('poses-truth').click();
  await mapped(lab);
  await lab.show('log');
  await expect(page.locator('#log-panel')).toContainText('Against the poses that are true: off by 0.0');
  await expect(page.locator('#log-panel')).toContainText('10 of 40 scans lie before or behind the poses');
  await lab.show('plots');
  const saved = page.waitForEvent('download');
  await page.locator('slam-plots').getByTestId('csv').click();
  const [header = '', ...rows] = readFileSync(await (await saved).path(), 'utf8').trimEnd().split('\r\n');
  const column = header.split(',').findIndex((cell) => cell.startsWith('Position error (m)'));
  expect(column).toBeGreaterThan(0);
  const errors = rows.map((row) => row.split(',')[column]).filter((cell) => cell !== '').map(Number);
  // The scans for which there are poses, and a map with errors of a centimetre or two.
  expect(errors).toHaveLength(30);
  expect(Math.max(...errors)).toBeLessThan(0.03);
});

test('poses alone are a path beside the run, by time where they are of its recording', async ({ lab }) => {
  await give(lab, file('poses.csv', poses()));
  await expect(lab.at('toast')).toContainText('a path of 41 poses in 40 s is drawn beside the way of the run');
  await expect(lab.at('fit-1')).toContainText('no times in common');
  await lab.at('file').setInputFiles([file('drive.log', log())]);
  await mapped(lab);
  await lab.at('file').setInputFiles([file('again.csv', poses())]);
  await lab.at('poses-path').click();
  await expect(lab.at('fit-2')).toContainText('both come closest');
  // The same poses may also be the truth of a recording that is shown already.
  await lab.at('file').setInputFiles([file('again.csv', poses())]);
  await lab.at('poses-truth').click();
  await lab.watch((s) => s.finished && Number.isFinite(s.truthX), 'it is mapped again, with a truth').toBe(true);
});

for (const { name, text, says } of [
  { name: 'other clock', text: poses().replaceAll(/;(\d+\.\d+)$/gm, (_, t: string) => `;${Number(t) + 1e6}`), says: 'none of the 40 scans lies where the poses tell' },
  { name: 'NaN', text: `${poses()}90;NaN;0;500\n`, says: 'line 43: field 2 (x) is `NaN`' },
  { name: 'backwards', text: `${poses()}90;0;0;1\n`, says: 'line 43: the time is `1`' },
  { name: 'columns', text: `${poses()}90;0;0\n`, says: 'line 43: the number of fields is `3`, expected 4' },
  { name: 'no rows', text: 'time,x,y,theta\n', says: 'no pose in 1 lines' },
]) {
  test(`hostile poses: ${name}`, async ({ lab }) => {
    await give(lab, file('drive.log', log()), file('poses.csv', text));
    await lab.at('poses-truth').click();
    await lab.says(says);
  });
}
