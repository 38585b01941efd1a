// Recordings of other robots: ROS 1 bags and ROS 2 MCAP files, as written by other programs
// (tests/interop/ros_files.py), dropped under meaningless names.

import { readFileSync } from 'node:fs';
import { expect, test } from './fixture.ts';
import { drop } from './lab.ts';

const file = (name: string): Buffer => readFileSync(new URL(`../../core/src/format/ros/files/${name}`, import.meta.url));

test('bags of ROS 1 and recordings of ROS 2 open and are mapped, whatever they are called', async ({ lab, page }) => {
  await lab.open();
  for (const [name, odometry] of [['plain.bag', '/odom'], ['bz2.bag', 'tf:odom:base_link'], ['lz4.bag', '/odom'], ['zstd.mcap', '/odom'], ['lz4.mcap', 'tf:odom:base_link']] as const) {
    await test.step(name, async () => {
      const title = `drive of ${name.replace('.', ' ')}`;
      await drop(page, title, file(name));
      await expect.poll(async () => (await lab.state()).title, 'it is opened').toBe(title);
      await lab.watch((s) => s.finished, 'it is mapped').toBe(true);
      const { status, source } = await lab.state();
      expect(source).toBe('replay');
      expect(status?.scans).toBe(25);
      expect(status?.knownArea, 'the room is seen').toBeGreaterThan(10);
      await lab.show('log');
      for (const words of ['25 scans of /scan', `odometry of ${odometry}`, 'hangs upside down']) await expect(lab.at('log')).toContainText(words);
    });
  }
});

test('of two lidars one is chosen in a dialog, and the choice holds when the log is mapped again', async ({ lab, page }) => {
  await lab.open();
  await drop(page, 'two.mcap', file('two.mcap'));
  const topics = lab.at('topics');
  await expect(topics).toBeVisible();
  await expect(topics).toContainText('25 scans of 90 beams in frame `rear`');
  await topics.getByRole('button', { name: 'Close' }).click();
  await expect(topics).toBeHidden();
  expect((await lab.state()).source, 'nothing was opened').toBe('sim');
  await drop(page, 'two.mcap', file('two.mcap'));
  await topics.getByText('/rear/scan').click();
  await lab.at('topics-open').click();
  await expect(topics).toBeHidden();
  await expect.poll(async () => (await lab.state()).title).toBe('two.mcap');
  await lab.watch((s) => s.finished, 'it is mapped').toBe(true);
  await lab.show('log');
  await expect(lab.at('log')).toContainText('25 scans of /rear/scan');
  await lab.show('run');
  await lab.at('method').selectOption('odometry');
  await lab.watch((s) => s.finished, 'it is mapped again').toBe(true);
  await expect(topics, 'nothing is asked again').toBeHidden();
  await lab.show('log');
  await expect(lab.at('log')).toContainText('25 scans of /rear/scan');
});

test('files that are none are called by what they are, and a cut file keeps what stands before', async ({ lab, page }) => {
  await lab.open();
  const cases: readonly [name: string, bytes: Buffer, says: RegExp][] = [
    ['drive.bag', Buffer.from('SQLite format 3\0'), /drive\.bag: this is a database \(SQLite\).*ros2 bag convert/],
    ['drive.mcap', Buffer.from('<!DOCTYPE html><title>404</title>'), /drive\.mcap: this is an HTML page/],
    ['scan', Buffer.from('\x7fELF\x02\x01\x01\0\0\0\0', 'latin1'), /scan: this is a program \(ELF\)/],
    ['log.clf', Buffer.from('PK\x03\x04\x14\0\0\0', 'latin1'), /log\.clf: this is a ZIP archive/],
    ['old.bag', Buffer.from('#ROSBAG V1.2\n\0\0\0\0'), /old\.bag: .*version 1\.2.*rosbag fix/],
    ['cloud.mcap', Buffer.concat([file('zstd.mcap').subarray(0, 60)]), /cloud\.mcap: the file holds no scan/],
  ];
  for (const [name, bytes, says] of cases) {
    await drop(page, name, bytes);
    await expect(lab.at('toast')).toHaveText(says);
    await page.getByRole('button', { name: 'Close the message' }).click();
  }
  expect((await lab.state()).source).toBe('sim');
  const whole = file('zstd.mcap');
  await drop(page, 'cut.mcap', whole.subarray(0, Math.round(0.6 * whole.length)));
  await expect.poll(async () => (await lab.state()).title).toBe('cut.mcap');
  await lab.watch((s) => s.finished, 'it is mapped').toBe(true);
  await lab.show('log');
  await expect(lab.at('log')).toContainText('cut off');
});
