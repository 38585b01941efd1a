// Malicious addresses: no script, no hang, and each is answered in words; the present run goes on.
import { deflateRawSync } from 'node:zlib';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

const GOOD = 'run&world=office&sensor=lidar&method=line-ekf&seed=7';
const world = (text: string | Buffer): string => `world=${deflateRawSync(text).toString('base64url')}`;
const SCRIPT = '<img src=x onerror=window.isHacked=1><script>window.isHacked=1</script>';

const LINKS: readonly [what: string, link: string, says: RegExp][] = [
  ['a script for a world', `run&world=${SCRIPT}&sensor=lidar&method=line-ekf&seed=7`, /world is `.*expected one of/],
  ['one that is encoded twice', `run&world=${encodeURIComponent(encodeURIComponent('office'))}%2526&sensor=lidar&method=line-ekf&seed=7`, /world is/],
  ['a script for a field', `${GOOD}&${SCRIPT}=1`, /which is no field of one|expected/],
  ['a seed below 0', GOOD.replace('seed=7', 'seed=-7'), /`seed` is `-7`/],
  ['a seed that is no number', GOOD.replace('seed=7', 'seed=NaN'), /`seed` is `NaN`/],
  ['a sensor of nobody', GOOD.replace('sensor=lidar', 'sensor=nose'), /`sensor` is `nose`/],
  ['a method of nobody', GOOD.replace('method=line-ekf', 'method=oracle'), /`method` is `oracle`/],
  ['a setting that is none', `${GOOD}&set=no.such:1`, /no\.such/],
  ['a setting beyond its range', `${GOOD}&set=ekf.gate:1e300`, /ekf\.gate|gate/i],
  ['a setting that is no number', `${GOOD}&set=ekf.gate:NaN`, /`set` is|gate/i],
  ['a goal that is no number', `${GOOD}&do=10:goto,NaN,inf`, /`do` is/],
  ['a door that there is not', `${GOOD}&do=1:door,99999999999999999999,1`, /`do` is/],
  ['actions that go back in time', `${GOOD}&do=50:stop;10:stop`, /`do` is|order/],
  ['an end that never comes', `${GOOD}&until=99999999999999999999999&hash=0123456789abcdef`, /`until` is/],
  ['a hash that is none', `${GOOD}&until=5&hash=zzz`, /`hash` is/],
  ['a lesson of nobody', `lesson=${SCRIPT}`, /There is no lesson/],
  ['an experiment of nobody', `experiment=${SCRIPT}`, /There is no experiment/],
];

const unharmed = async ({ page }: Lab): Promise<void> => {
  expect(await page.evaluate(() => (window as { isHacked?: number }).isHacked), 'no script ran').toBeUndefined();
};

test('each is refused in words, and the run goes on', async ({ lab, page }) => {
  test.setTimeout(180_000);
  await lab.open();
  for (const [what, link, says] of LINKS) {
    await test.step(what, async () => {
      await page.evaluate((link) => (location.hash = link), link);
      await lab.says(says, what);
      await unharmed(lab);
      await page.getByRole('button', { name: 'Close the message' }).click();
      await expect(lab.at('toast')).toBeHidden();
    });
  }
  const { scans } = await lab.status();
  await lab.watch((s) => s.scans, 'it goes on').toBeGreaterThan(scans);
});

test('worlds that cannot be: damaged, endless, of others, with a script', async ({ lab, page }) => {
  test.setTimeout(180_000);
  const wrong: readonly [what: string, link: string, says: RegExp][] = [
    ['no letters of a link', 'world=%%%', /damaged/],
    ['not packed', `world=${Buffer.from('{}').toString('base64url')}`, /damaged/],
    ['little that unpacks to much', world(Buffer.alloc(8_000_000, 0x20)), /damaged/],
    ['no text', world(Buffer.from([0xff, 0xfe, 0xfd])), /damaged/],
    ['no world', world('{"a":1}'), /world file/],
    ['a name with a script, and nothing else', world(JSON.stringify({ slamlab_world: 1, name: SCRIPT })), /world file/],
    ['numbers beyond all bounds', world('{"slamlab_world":1,"name":"x","start":{"x":1e999,"y":0},"obstacles":[]}'), /world file|start/],
    ['nested without end', world('{"slamlab_world":'.concat('['.repeat(20_000))), /world file/],
  ];
  await lab.open();
  for (const [what, link, says] of wrong) {
    await test.step(what, async () => {
      await page.evaluate((link) => (location.hash = link), link);
      await expect(lab.at('editor-note'), what).toContainText(says);
      await unharmed(lab);
      await page.keyboard.press('Escape');
      await expect(page.locator('slam-editor')).toHaveCount(0);
    });
  }
  const { scans } = await lab.status();
  await lab.watch((s) => s.scans, 'the run behind goes on').toBeGreaterThan(scans);
});

test('an address of 10 MB is refused as too long, at once', async ({ lab, page }) => {
  await lab.open();
  for (const begins of [`${GOOD}&set=`, 'world=']) {
    const says = await page.evaluate(async (begins) => {
      // As long as the browser allows an address to be.
      for (const length of [10_000_000, 1_500_000]) {
        location.hash = begins + 'x'.repeat(length);
        if (location.hash.length > length) return true;
      }
      return false;
    }, begins);
    expect(says, 'the browser takes it').toBe(true);
    const told = begins === 'world=' ? lab.at('editor-note') : lab.at('toast');
    await expect(told).toContainText(/bytes long|letters, at most/);
    await page.keyboard.press('Escape');
  }
  const { time } = await lab.status();
  await lab.at('mode-explore').click();
  await lab.watch((s) => s.time, 'the run goes on').toBeGreaterThan(time);
});

test('an address that names nothing is told of when the page is opened by it', async ({ lab, page }) => {
  const wrong: readonly [link: string, says: string][] = [
    ['lesson=none', 'There is no lesson none'],
    ['experiment=none', 'There is no experiment none'],
    ['world=%%%', 'damaged'],
    ['junk', 'The address ends in #junk'],
    [`a${'x'.repeat(5_000)}`, 'The address ends in #axxx'],
  ];
  for (const [at, [link, says]] of wrong.entries()) {
    await test.step(link.slice(0, 20), async () => {
      await lab.open(`/?${at}#${link}`);
      await lab.says(says);
      expect((await lab.state()).title, 'there is a run all the same').toBe('office');
    });
  }
  // One that is changed while the page is open is answered too.
  await page.keyboard.press('Escape');
  await page.evaluate(() => (location.hash = 'rubbish'));
  await lab.says('The address ends in #rubbish');
});
