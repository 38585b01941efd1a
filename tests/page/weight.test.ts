// The weight of a first visit.
import { firstVisit, GOAL, sum, type Weights } from './first_visit.ts';
import { expect, test } from './fixture.ts';

/** The weight reached, which must not grow again, bytes: before the robot drives, and after a look
    around. */
const REACHED = { watched: 748_000, lookedAround: 830_000 };

test.use({ drawnWith: 'auto' });

const told = (weights: Weights): string => `${sum(weights)} bytes, asked for are ${GOAL}\n${weights.map(([path, bytes]) => `${bytes}\t${path}`).join('\n')}`;

test.describe('a first visit', () => {
  test.use({ firstVisit: true });

  test('stays within its weight, also where somebody looks around, and loads nothing that nobody asked for', async ({ lab, page, baseURL }) => {
    test.slow();
    const { watched, lookedAround } = await firstVisit(page, lab, baseURL!);
    console.log(`a first visit: ${told(watched)}\nafter a look around: ${told(lookedAround)}`);
    const [atFirst, atLast] = [watched, lookedAround].map((weights) => weights.map(([path]) => path));
    for (const needed of ['/slamlab_web_bg.wasm', '/worker.js', '/main.js']) expect(atFirst).toContain(needed);
    for (const later of ['panels', 'race', 'editor', 'registration', 'inspector']) expect(atFirst, 'nobody has opened it').not.toContain(`/${later}.js`);
    expect(atLast, 'nobody has done what a first visit does not').not.toContain('/slamlab_web_rest.wasm');
    for (const later of ['files', 'lab', 'cable']) expect(atLast, 'it is loaded when it is asked for').not.toContain(`/slamlab_${later}_bg.wasm`);
    expect(sum(watched)).toBeLessThanOrEqual(REACHED.watched);
    expect(sum(lookedAround)).toBeLessThanOrEqual(REACHED.lookedAround);
  });
});

const REST = '**/slamlab_web_rest.wasm*';

test('the rest of the module comes when somebody does more than look around; where it cannot, that is refused and the run goes on', async ({ lab, page, problems }) => {
  let asked = 0;
  await page.route(REST, (route) => {
    asked += 1;
    return route.abort();
  });
  await lab.open();
  await lab.watch((s) => s.scans, 'the robot scans').toBeGreaterThan(3);
  expect(asked).toBe(0);
  await lab.at('save').click();
  await expect(lab.at('saving-about-map')).toContainText('Not now: The rest of the program could not be loaded: the server does not answer');
  await lab.at('saving-close').click();
  const { time } = await lab.status();
  await lab.watch((s) => s.time, 'the run goes on').toBeGreaterThan(time + 1);
  await page.unroute(REST);
  await lab.savedMap();
  expect(problems.filter((problem) => !/slamlab_web_rest|ERR_FAILED|rest of the program/.test(problem))).toEqual([]);
  problems.length = 0;
});
