// A worker that fails: it is reported, another one takes over, and the run is offered.
import { expect, test } from './fixture.ts';

test('a worker that breaks is said to have, another one goes on, and what was under way is offered', { tag: '@phone' }, async ({ lab, page, problems }) => {
  test.setTimeout(120_000);
  await lab.open();
  await lab.enter('doors', '10');
  await lab.watch((s) => s.time, 'it is worth to be kept').toBeGreaterThan(25);
  await expect.poll(() => page.evaluate(() => JSON.parse(localStorage.getItem('slamlab-last-run') ?? '{}').title), { timeout: 10_000 }).toBe('doors');
  const broken = page.workers()[0]!;
  await broken.evaluate(() => void setTimeout(() => {
    throw new Error('out of memory');
  }));
  await expect(lab.at('toast')).toContainText('broke off by a fault of the program: Uncaught Error: out of memory. It was started anew.');
  await expect(lab.at('last-run')).toContainText('Doors');
  await lab.watch((s) => s.scans, 'another run is under way').toBeGreaterThan(0);
  expect((await lab.state()).setup.world).toBe('doors');
  expect(page.workers()).not.toContain(broken);
  await lab.at('go-on').click();
  await lab.watch((s) => s.time, 'it comes to where it was').toBeGreaterThan(20);

  // A worker that fails again at once would go on failing.
  const breakOff = async (): Promise<string | null> => {
    await page.workers()[0]?.evaluate(() => self.postMessage({ kind: 'failed', about: 'internal', text: 'panicked at core', isBroken: true }));
    return lab.at('toast').textContent();
  };
  await expect.poll(breakOff, { intervals: [1000], timeout: 20_000 }).toContain('The simulation stopped: panicked at core. Reload the page.');
  expect(problems.filter((problem) => !problem.includes('out of memory'))).toEqual([]);
  problems.length = 0;
});
