// What a first visit weighs.
import { firstVisit, GOAL, sum } from './first_visit.ts';
import { expect, test } from './fixture.ts';

/** What was reached, and must not be lost again, bytes. */
const REACHED = 690_000;

test.use({ drawnWith: 'auto' });

test.describe('a first visit', () => {
  test.use({ firstVisit: true });

  test('stays within its weight, and loads nothing that nobody asked for', async ({ lab, page, baseURL }) => {
    const weights = await firstVisit(page, lab, baseURL!);
    const [paths, weight] = [weights.map(([path]) => path), sum(weights)];
    console.log(`a first visit: ${weight} bytes, asked for are ${GOAL}\n${weights.map(([path, bytes]) => `${bytes}\t${path}`).join('\n')}`);
    for (const needed of ['/slamlab_web_bg.wasm', '/worker.js', '/main.js']) expect(paths).toContain(needed);
    for (const later of ['panels', 'race', 'editor', 'registration', 'inspector']) expect(paths, 'nobody has opened it').not.toContain(`/${later}.js`);
    expect(paths, 'nobody has done more than watch').not.toContain('/slamlab_web_rest.wasm');
    for (const later of ['files', 'lab', 'cable']) expect(paths, 'it is loaded when it is asked for').not.toContain(`/slamlab_${later}_bg.wasm`);
    expect(weight).toBeLessThanOrEqual(Math.min(GOAL, REACHED));
  });
});

const REST = '**/slamlab_web_rest.wasm*';

test('the rest of the module comes when somebody does more than watch; where it cannot, that is refused and the run goes on', async ({ lab, page, problems }) => {
  let asked = 0;
  await page.route(REST, (route) => {
    asked += 1;
    return route.abort();
  });
  await lab.open();
  await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(3);
  expect(asked).toBe(0);
  await lab.at('mode-manual').click();
  await expect(lab.at('toast')).toContainText('The rest of the program could not be loaded: the server does not answer');
  const { time } = await lab.status();
  await lab.watch((s) => s.time, 'the run goes on').toBeGreaterThan(time + 1);
  await page.unroute(REST);
  await lab.at('mode-manual').click();
  await expect.poll(async () => (await lab.status()).mode, 'and then it is driven by hand').toBe('manual');
  expect(problems.filter((problem) => !/slamlab_web_rest|ERR_FAILED|rest of the program/.test(problem))).toEqual([]);
  problems.length = 0;
});
