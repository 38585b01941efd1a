// The worker's protocol, without the page: its answers, their order, and that it never runs ahead
// of the page.
import type { Answer, Command } from '../../www/src/protocol.ts';
import { expect, test } from './fixture.ts';
import { record } from './recording.ts';

test.beforeEach(async ({ page }) => {
  // The page without its script, so that no other worker runs.
  await page.route('**/main.js', (route) => route.fulfill({ contentType: 'text/javascript', body: '' }));
  await page.goto('/');
  await page.evaluate(() => {
    const worker = new Worker('/worker.js', { type: 'module' });
    const answers: Answer[] = [];
    worker.onmessage = (event: MessageEvent<Answer>) => answers.push(event.data);
    const send = (...commands: Command[]): void => commands.forEach((command) => worker.postMessage(command));
    /** All answers up to the first that fits, removed from the queue; `drawn` answers each
        frame. */
    const until = async (fits: (answer: Answer) => boolean, drawn: boolean): Promise<Answer[]> => {
      const begin = performance.now();
      let looked = 0;
      for (;;) {
        for (; looked < answers.length; looked += 1) {
          const answer = answers[looked]!;
          if (drawn && answer.kind === 'frame') send({ kind: 'drawn' });
          if (fits(answer)) return answers.splice(0, looked + 1);
        }
        if (performance.now() - begin > 20_000) throw new Error(`waited in vain; came: ${answers.map((a) => a.kind).join(' ')}`);
        await new Promise((resolve) => setTimeout(resolve, 5));
      }
    };
    const setup = { world: 'arena', worldJson: null, sensor: 'lidar', seed: 3, method: 'line-ekf', mode: 'explore', cycle: false, settings: {}, calibration: null, priorMap: null } as const;
    Object.assign(window, { wire: { send, until, setup, answers } });
  });
});

interface Wire {
  send(...commands: Command[]): void;
  until(fits: (answer: Answer) => boolean, drawn: boolean): Promise<Answer[]>;
  setup: Extract<Command, { kind: 'start' }>['setup'];
  answers: Answer[];
}

test('a run is started, then sent in numbered frames, one for each that is drawn', async ({ page }) => {
  const report = await page.evaluate(async () => {
    const { wire } = window as unknown as { wire: Wire };
    await wire.until((a) => a.kind === 'ready', false);
    wire.send({ kind: 'speed', factor: Infinity }, { kind: 'start', setup: wire.setup, play: true });
    const first = await wire.until((a) => a.kind === 'frame', false);
    await new Promise((resolve) => setTimeout(resolve, 300));
    const ahead = wire.answers.filter((a) => a.kind === 'frame').length;
    wire.send({ kind: 'drawn' });
    const rest = await wire.until((a) => a.kind === 'frame' && a.seq >= 5, true);
    const frames = [...first, ...rest].filter((a) => a.kind === 'frame');
    return {
      kinds: first.map((a) => a.kind).filter((kind) => kind !== 'event' && kind !== 'hash'),
      ahead,
      seqs: frames.map((f) => f.seq),
      first: frames[0]!,
      times: frames.map((f) => f.status.time),
      hash: [...first, ...rest].some((a) => a.kind === 'hash' && /^[0-9a-f]{16}$/.test(a.text)),
    };
  });
  expect(report.kinds).toEqual(['started', 'frame']);
  expect(report.ahead, 'no frame before the last one is drawn').toBe(0);
  expect(report.seqs).toEqual([1, 2, 3, 4, 5]);
  expect(report.first.truth, 'the first frame has the walls').not.toBeNull();
  expect([...report.times].sort((a, b) => a - b)).toEqual(report.times);
  expect(report.hash).toBe(true);
});

test('the same commands give the same hash, whatever the pace', async ({ page }) => {
  const hashes = await page.evaluate(async () => {
    const { wire } = window as unknown as { wire: Wire };
    const run = async (factor: number): Promise<string> => {
      wire.send({ kind: 'speed', factor }, { kind: 'start', setup: wire.setup, play: false });
      await wire.until((a) => a.kind === 'frame', true);
      for (let i = 0; i < 5; i += 1) {
        wire.send({ kind: 'step' });
        await wire.until((a) => a.kind === 'frame', true);
      }
      wire.send({ kind: 'pause' });
      let text = '';
      await wire.until((a) => {
        if (a.kind === 'hash') text = a.text;
        return a.kind === 'hash';
      }, true);
      return text;
    };
    return [await run(1), await run(Infinity)];
  });
  expect(hashes[0]).toMatch(/^[0-9a-f]{16}$/);
  expect(hashes[0]).toBe(hashes[1]);
});

test('what cannot be done fails in words and leaves the run as it is', async ({ page }) => {
  const log = record(60).text;
  const report = await page.evaluate(async (log) => {
    const { wire } = window as unknown as { wire: Wire };
    const bytes = (text: string): ArrayBuffer => new TextEncoder().encode(text).buffer as ArrayBuffer;
    wire.send({ kind: 'start', setup: wire.setup, play: false });
    const started = (await wire.until((a) => a.kind === 'started', true)).at(-1);
    wire.send({ kind: 'start', setup: { ...wire.setup, world: 'atlantis' }, play: true });
    const world = (await wire.until((a) => a.kind === 'failed', true)).at(-1);
    wire.send({ kind: 'replay', name: 'bad.log', bytes: bytes('FLASER 2 1.0\n'), topics: null, method: 'scan-matching', settings: {}, twin: false, priorMap: null, poses: null });
    const bad = (await wire.until((a) => a.kind === 'failed', true)).at(-1);
    wire.send({ kind: 'step' });
    const frame = (await wire.until((a) => a.kind === 'frame', true)).at(-1);
    wire.send({ kind: 'replay', name: 'good.log', bytes: bytes(log), topics: null, method: 'scan-matching', settings: {}, twin: false, priorMap: null, poses: null });
    const opened = (await wire.until((a) => a.kind === 'started', true)).at(-1);
    const end = (await wire.until((a) => a.kind === 'frame' && a.status.finished, true)).at(-1);
    wire.send({ kind: 'collect', what: 'map' });
    const saved = (await wire.until((a) => a.kind === 'collected', true)).at(-1);
    return { started, world, bad, frame, opened, end, files: saved?.kind === 'collected' ? saved.files.map((f) => f.name) : [] };
  }, log);
  expect(report.started).toMatchObject({ kind: 'started', run: 1, source: 'sim' });
  expect(report.world).toMatchObject({ kind: 'failed', text: expect.stringContaining('atlantis') });
  expect(report.bad).toMatchObject({ kind: 'failed', text: expect.stringMatching(/^bad\.log: line 1/) });
  expect(report.frame, 'the run of before').toMatchObject({ run: 1 });
  expect(report.opened).toMatchObject({ run: 2, source: 'replay', title: 'good.log' });
  expect(report.end).toMatchObject({ run: 2, status: { scans: 60, progress: 1 } });
  expect(report.files).toEqual(['good.pgm', 'good.yaml']);
});
