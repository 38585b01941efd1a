// What the page says of the map of a recording. Torn maps are the core's own tests.
import { expect, test } from './fixture.ts';
import { record } from './recording.ts';

test('a map is judged when its recording ends, and again when somebody asks', async ({ lab }) => {
  await lab.open();
  await lab.show('run');
  await lab.at('file').setInputFiles({ name: 'laps.log', mimeType: 'text/plain', buffer: Buffer.from(record(300).text) });
  await expect.poll(async () => (await lab.state()).source).toBe('replay');
  await lab.watch((s) => s.finished, 'it is mapped').toBe(true);
  await lab.show('status');
  const says = /both agree\.\s+\d+ % of what was seen again agrees/;
  await expect(lab.at('quality')).toHaveText(says);
  await lab.at('judge').click();
  await expect(lab.at('quality')).toHaveText(says);
  await expect(lab.at('tears')).toHaveCount(0);
});

test('methods that keep no submaps have no such figure', async ({ lab }) => {
  await lab.open();
  await lab.show('status');
  await expect(lab.at('judge')).toHaveCount(0);
});
