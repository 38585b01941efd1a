// The drive controller on the bench: with it the robot goes straight; without it, motors that
// differ turn it.
import { expect, test } from './fixture.ts';

test('on the bench the controller holds what a bad motor bends', async ({ lab, page }) => {
  await lab.open();
  await lab.pause();
  await lab.show('plots');
  const bench = lab.at('bench');
  await bench.locator('summary').click();
  const headings = async (): Promise<[number, number]> => {
    const [, closed, open] = /(−?[\d.]+)° against (−?[\d.]+)°/.exec(await lab.at('bench-heading').innerText()) ?? [];
    return [Number(closed?.replace('−', '-')), Number(open?.replace('−', '-'))];
  };
  await expect(lab.at('bench-heading')).toHaveText(/against/);
  await expect(bench.locator('.uplot')).toHaveCount(2);
  await lab.at('mismatch').fill('30');
  await expect.poll(async () => Math.abs((await headings())[1]), 'without control it turns').toBeGreaterThan(20);
  expect(Math.abs((await headings())[0]), 'with control it does not').toBeLessThan(1);
  await lab.at('mismatch').fill('0');
  await lab.at('pull').fill('0');
  await expect.poll(async () => Math.abs((await headings())[1]), 'equal motors go straight without it too').toBeLessThan(1);
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
});
