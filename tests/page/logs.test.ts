// Logs of other recorders, recognised by their first line: a rover with an RPLIDAR, four rangers,
// and an RPLIDAR alone.
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

/** A rover drives 2 m along a room of 8 x 4 m; its counters wrap at 16 bits. */
function rover(): string {
  const lines = Array.from({ length: 41 }, (_, i) => {
    const x = 0.05 * i;
    const ranges = Array.from({ length: 360 }, (_, degree) => {
      const [sin, cos] = [Math.sin(degree * Math.PI / 180), Math.cos(degree * Math.PI / 180)];
      const range = Math.min((cos > 0 ? 5 - x : 3 + x) / Math.max(Math.abs(cos), 1e-9), 2 / Math.max(Math.abs(sin), 1e-9));
      return range < 6 ? Math.round(1000 * range) : 0;
    });
    // 333.3 counts per turn of wheels of 58.2 mm: 91 in 5 cm.
    const count = (65_400 + 91 * i) % 65_536;
    return [count, count, (182 * i) % 65_536, ...ranges].join(' ');
  });
  return `${lines.join('\n')}\n`;
}

/** Four rangers are driven 5 m along a corridor. */
function rangers(): string {
  const rows = Array.from({ length: 101 }, (_, i) => `${(0.1 * i).toFixed(2)},${(0.05 * i).toFixed(2)},0,0,0.83,${(6 - 0.05 * i).toFixed(2)},0.83,nan,2.4`);
  return `t_s,x_m,y_m,yaw_rad,range0,range1,range2,range3,range4\n${rows.join('\n')}\n`;
}

/** The rover's lidar alone: no odometry, no time. */
function revolutions(): string {
  const lines = rover().trim().split('\n').map((line) => line.split(' ').slice(3)
    .map((d, t) => `${t === 0 ? 'S' : '_'}_t:${t.toFixed(2)}_d:${d.padStart(5, '0')}.00_q:${d === '0' ? 0 : 29}|`).join(''));
  return `# a comment\n${lines.join('-END-\n')}-END-\n`;
}

async function open(lab: Lab, name: string, text: string): Promise<void> {
  await lab.open();
  await lab.show('run');
  await lab.at('file').setInputFiles({ name, mimeType: 'text/plain', buffer: Buffer.from(text) });
}

for (const { name, text, says, x } of [
  { name: 'rover.log', text: rover, says: '41 scans of 360 directions in 7 s, with counts of wheels', x: 2 },
  { name: 'revolutions.txt', text: revolutions, says: '41 revolutions of a lidar without wheels, 7 s at the rate that is set', x: 2 },
  { name: 'rangers.csv', text: rangers, says: '101 readings of four rangers in 10 s', x: 5 },
]) {
  test(`${name} is mapped`, async ({ lab, page }) => {
    await open(lab, name, text());
    await expect.poll(async () => (await lab.state()).source).toBe('replay');
    await lab.watch((s) => s.finished, 'it is mapped').toBe(true);
    expect((await lab.status()).x).toBeCloseTo(x, 1);
    await lab.show('log');
    await expect(page.locator('#log-panel')).toContainText(`Opened ${name}: ${says}`);
  });
}

test('a log that is damaged is refused in words, with line and field', async ({ lab }) => {
  const lines = rover().split('\n');
  lines[6] = lines[6]!.replace(/\d+ /, 'left ');
  await open(lab, 'damaged.log', lines.join('\n'));
  await lab.says('line 7: left is `left`, expected a counter of 16 bits');
  await open(lab, 'damaged.txt', revolutions().replace('q:29', 'q:64'));
  await lab.says('line 2: q of sample 1 is `64`, expected a whole number, 0 to 63');
});
