// Web Serial: a robot and a lidar at ports of this very computer, without a bridge. The browser's ports are fakes whose bytes go to the
// simulated devices on pseudo-terminals, byte for byte; the page drives, maps, and stops.
import { execFile } from 'node:child_process';
import { constants, type FileHandle, open } from 'node:fs/promises';
import { promisify } from 'node:util';
import type { Page } from '@playwright/test';
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';
import { WiredRobot, withRobot } from './wired.ts';

/** Takes the wheel, as soon as the robot's link is up. */
async function arm(lab: Lab): Promise<void> {
  const state = lab.at('bridge-state');
  await expect(async () => {
    if (!(await state.textContent())?.includes('You drive')) await lab.at('wheel').click();
    await expect(state).toContainText('You drive', { timeout: 3_000 });
  }).toPass({ timeout: 60_000 });
}

/** The browser asks for ports in the order in which these are plugged. */
async function fakeSerial(page: Page, paths: readonly string[]): Promise<() => Promise<void>> {
  const handles: FileHandle[] = [];
  let ends = false;
  await page.exposeFunction('serialOpen', async (port: number, rate: number) => {
    // At any other rate than its own a device hears and says noise.
    await promisify(execFile)('stty', ['-F', paths[port]!, String(rate), 'raw', '-echo']);
    handles[port] = await open(paths[port]!, constants.O_RDWR | constants.O_NOCTTY | constants.O_NONBLOCK);
    void pump(port, handles[port]!);
  });
  await page.exposeFunction('serialWrite', async (port: number, bytes: number[]) => {
    await handles[port]?.write(Uint8Array.from(bytes));
  });
  await page.exposeFunction('serialClose', async (port: number) => {
    const handle = handles[port];
    delete handles[port];
    await handle?.close();
  });
  const pump = async (port: number, handle: FileHandle): Promise<void> => {
    const buffer = Buffer.alloc(4096);
    while (!ends && handles[port] === handle) {
      let count = 0;
      try {
        count = (await handle.read(buffer, 0, buffer.length, null)).bytesRead;
      } catch (error) {
        // Nothing is there yet; or the terminal was closed.
        if ((error as NodeJS.ErrnoException).code !== 'EAGAIN') return;
      }
      if (count === 0) {
        await new Promise((done) => setTimeout(done, 5));
        continue;
      }
      const came = [port, [...buffer.subarray(0, count)]] as const;
      await page.evaluate(([port, bytes]) => (window as unknown as { serialCame(port: number, bytes: number[]): void }).serialCame(port as number, bytes as number[]), came).catch(() => undefined);
    }
  };
  await page.addInitScript(() => {
    const outside = window as unknown as { serialOpen(port: number, rate: number): Promise<void>; serialWrite(port: number, bytes: number[]): Promise<void>; serialClose(port: number): Promise<void>; serialCame(port: number, bytes: number[]): void };
    const sinks: (ReadableStreamDefaultController<Uint8Array> | undefined)[] = [];
    outside.serialCame = (port, bytes) => sinks[port]?.enqueue(Uint8Array.from(bytes));
    class FakePort {
      readable: ReadableStream<Uint8Array> | null = null;
      writable: WritableStream<Uint8Array> | null = null;
      constructor(readonly number: number) {}
      async open({ baudRate }: { baudRate: number }): Promise<void> {
        const { number } = this;
        this.readable = new ReadableStream({ start: (controller) => { sinks[number] = controller; } });
        this.writable = new WritableStream({ write: (bytes) => outside.serialWrite(number, [...bytes]) });
        await outside.serialOpen(number, baudRate);
      }
      async close(): Promise<void> {
        sinks[this.number] = undefined;
        [this.readable, this.writable] = [null, null];
        await outside.serialClose(this.number);
      }
      async setSignals(): Promise<void> {}
    }
    let asked = 0;
    Object.defineProperty(navigator, 'serial', { value: { requestPort: async () => new FakePort(asked++) } });
  });
  return async () => {
    ends = true;
    await Promise.allSettled(handles.map((handle) => handle?.close()));
  };
}

test('a robot and a lidar at the ports of this computer are driven and mapped without a bridge', async ({ lab, page, hasTouch }) => {
  test.skip(hasTouch, 'phones have no Web Serial');
  test.setTimeout(240_000);
  const robot = await WiredRobot.start('wired_robot', 'arena');
  const unplug = await fakeSerial(page, [robot.ports.rp6!, robot.ports.rplidar!]);
  await withRobot(robot, async () => {
    await lab.open();
    await lab.show('run');
    await lab.at('cable').locator('summary').click();
    await lab.at('plug-rp6').click();
    await expect.poll(async () => (await lab.state()).source, { message: 'the robot is shown', timeout: 60_000 }).toBe('bridge');
    await lab.at('plug-rplidar').click();
    await lab.watch((s) => s.scans, 'the lidar sees', 60_000).toBeGreaterThan(3);
    expect((await robot.facts()).moves, 'disarmed at first').toBe(false);

    await arm(lab);
    await lab.at('mode-explore').click();
    await lab.watch((s) => s.distance, 'it drives', 60_000).toBeGreaterThan(0.4);
    const truth = await robot.facts();
    const { x, y } = await lab.status();
    expect(Math.hypot(x - truth.pose[0], y - truth.pose[1]), 'it knows where it is').toBeLessThan(0.3);
    await lab.watch((s) => s.knownArea, 'it maps', 60_000).toBeGreaterThan(3);

    await lab.at('stop').click();
    await expect.poll(async () => (await robot.facts()).moves, { message: 'it stops', timeout: 30_000 }).toBe(false);

    // Out of sight it stops too.
    await arm(lab);
    await lab.at('mode-explore').click();
    await expect.poll(async () => (await robot.facts()).moves, { message: 'it drives again', timeout: 60_000 }).toBe(true);
    await page.evaluate(() => {
      Object.defineProperty(document, 'hidden', { value: true, configurable: true });
      document.dispatchEvent(new Event('visibilitychange'));
    });
    await expect.poll(async () => (await robot.facts()).moves, { message: 'it stops when the page is out of sight', timeout: 30_000 }).toBe(false);
    await page.evaluate(() => Object.defineProperty(document, 'hidden', { value: false, configurable: true }));

    await lab.at('unplug').click();
    await expect.poll(async () => (await lab.state()).source, 'the simulation is back').toBe('sim');
    await unplug();
  });
});

test('a browser without Web Serial says so', async ({ lab, page }) => {
  await page.addInitScript(() => Object.defineProperty(navigator, 'serial', { value: undefined }));
  await lab.open();
  await lab.show('run');
  await lab.at('cable').locator('summary').click();
  await expect(lab.at('no-web-serial')).toContainText('Chrome, Edge and Opera');
});
