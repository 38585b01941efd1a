// A robot behind a bridge, from a page without one: its address is typed, or read by a camera.
import { pageOf } from '../../www/src/bridge_page.ts';
import { Bridge } from './bridge.ts';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

const look = async (lab: Lab): Promise<void> => {
  await lab.show('run');
  await lab.at('elsewhere').locator('summary').click();
  await expect(lab.at('bridge-address')).toBeVisible();
};

test('the address of a bridge is typed, and its robot is there', { tag: '@phone' }, async ({ lab, page, problems }) => {
  const bridge = await Bridge.start(['--source', 'sim:arena,lidar']);
  await lab.open();
  await look(lab);
  await lab.at('bridge-address').fill('not an address');
  await lab.at('bridge-open').click();
  await expect(lab.at('bridge-address-fault')).toContainText('An address looks like robot.local:8080');
  await lab.at('bridge-address').fill(`127.0.0.1:${bridge.port}`);
  await expect(lab.at('bridge-address-fault')).toHaveCount(0);
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  await lab.at('bridge-address').press('Enter');
  await page.waitForURL(`http://127.0.0.1:${bridge.port}/`);
  await expect.poll(async () => page.evaluate(() => (window as unknown as { slamlab?: { source: string } }).slamlab?.source)).toBe('bridge');
  await lab.show('run');
  await expect(lab.at('elsewhere'), 'it is there already').toBeHidden();
  await bridge.stop();
  // The page reports it, and so does the browser.
  problems.splice(0, problems.length, ...problems.filter((problem) => !/WebSocket|ERR_CONNECTION/.test(problem)));
});

test('where the browser reads codes, the address is scanned, and shown before it is opened', async ({ lab, page }) => {
  await page.addInitScript(() => {
    Object.assign(window, { BarcodeDetector: class {
      async detect(): Promise<{ rawValue: string }[]> {
        return [{ rawValue: 'a pack of tea' }, { rawValue: 'http://192.168.1.7:8080/#token=abc' }];
      }
    } });
    const picture = (): MediaStream => {
      const canvas = document.createElement('canvas');
      canvas.getContext('2d')!.fillRect(0, 0, 9, 9);
      return canvas.captureStream(10);
    };
    Object.defineProperty(navigator, 'mediaDevices', { value: { getUserMedia: async () => picture() } });
  });
  await lab.open();
  await look(lab);
  await lab.at('bridge-scan').click();
  await expect(lab.at('bridge-address')).toHaveValue('http://192.168.1.7:8080/#token=abc');
  await expect(page.locator('slam-bridge-address video'), 'the camera is shut').toHaveCount(0);
  expect(new URL(page.url()).hostname, 'nobody was taken there').toBe('127.0.0.1');
});

test('an address is what people write for one', () => {
  for (const [typed, page] of [
    ['robot.local', 'http://robot.local:8080/'],
    [' 192.168.1.7:9000 ', 'http://192.168.1.7:9000/'],
    ['192.168.1.7:80', 'http://192.168.1.7/'],
    ['[fe80::1]', 'http://[fe80::1]:8080/'],
    ['https://robot.example/lab/#token=abc', 'https://robot.example/lab/#token=abc'],
    ['robot.local#token=a', 'http://robot.local:8080/#token=a'],
    ['ws://robot.local:8080/ws', 'http://robot.local:8080/'],
    ['wss://robot.local:8080/ws', 'https://robot.local:8080/'],
  ] as const) expect(pageOf(typed), typed).toBe(page);
  for (const none of ['', '   ', 'two words', 'javascript:alert(1)', 'javascript://x/%0Aalert(1)', 'file:///etc/passwd', 'http://', 'http://me:secret@robot.local', ':::']) expect(pageOf(none), none).toBeNull();
});
