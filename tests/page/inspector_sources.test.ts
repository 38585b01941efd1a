// The inspector with a robot that is not simulated in the page: clicks show numbers of a recording,
// and of a robot behind a bridge.
import type { Lab } from './lab.ts';
import { drop } from './lab.ts';
import { record } from './recording.ts';
import { behind, expect } from './robot_behind.ts';

const test = behind(() => ['--source', 'sim:arena,lidar']);

/** Where one of the beams of the last scan hit. */
const hitOf = (lab: Lab): Promise<[number, number]> =>
  lab.page.evaluate(() => {
    const { hit } = (window as unknown as { slamlab: { hit(beam: number): [number, number] } }).slamlab;
    const hits = Array.from({ length: 400 }, (_, beam) => hit(beam)).filter(([x]) => Number.isFinite(x));
    return hits[hits.length >> 1] ?? [NaN, NaN];
  });

/** Robot, cell and beam have numbers; nothing is called true if no truth is known. */
async function isInspected(lab: Lab): Promise<void> {
  await lab.at('inspect').click();
  const { x, y } = await lab.status();
  await lab.inspectAt('robot', x, y);
  const hit = await hitOf(lab);
  await lab.inspectAt('cell', (x + hit[0]) / 2, (y + hit[1]) / 2);
  await expect(lab.at('cell-p')).toHaveText(/^[\d.]+ ?%$/);
  await expect(lab.at('cell-fate')).toHaveText('Free');
  await lab.inspectAt('beam', ...hit);
  await expect(lab.at('beam-range')).toHaveText(/^[\d.]+ c?m/);
  await expect(lab.at('inspector')).not.toContainText(/truth|true/i);
}

test('in a recording', async ({ lab, page }) => {
  await lab.open();
  await drop(page, 'laps.log', Buffer.from(record(420).text));
  await lab.watch((s) => s.finished, 'the recording ends').toBe(true);
  await isInspected(lab);
});

test('behind a bridge', async ({ lab, bridge }) => {
  await lab.open(bridge.url);
  await lab.watch((s) => s.scans, 'scans come by themselves').toBeGreaterThan(20);
  await isInspected(lab);
});
