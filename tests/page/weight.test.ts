// What a first visit weighs.
import { firstVisit, GOAL, sum } from './first_visit.ts';
import { expect, test } from './fixture.ts';

/** What was reached, and must not be lost again, bytes. Once it is below the goal, that stands. */
const REACHED = 1_233_000;

test.use({ drawnWith: 'auto' });

test.describe('a first visit', () => {
  test.use({ firstVisit: true });

  test('stays within its weight, and loads nothing that nobody asked for', async ({ lab, page, baseURL }) => {
    const weights = await firstVisit(page, lab, baseURL!);
    const [paths, weight] = [weights.map(([path]) => path), sum(weights)];
    console.log(`a first visit: ${weight} bytes, asked for are ${GOAL}\n${weights.map(([path, bytes]) => `${bytes}\t${path}`).join('\n')}`);
    for (const needed of ['/slamlab_web_bg.wasm', '/worker.js', '/main.js']) expect(paths).toContain(needed);
    for (const later of ['panels', 'race', 'editor', 'registration', 'inspector']) expect(paths, 'nobody has opened it').not.toContain(`/${later}.js`);
    for (const later of ['files', 'lab', 'cable']) expect(paths, 'it is loaded when it is asked for').not.toContain(`/slamlab_${later}_bg.wasm`);
    expect(weight).toBeLessThanOrEqual(Math.max(GOAL, REACHED));
  });
});
