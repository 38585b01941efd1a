// The hands of a person in the stories: pressing Tab until a control is reached, holding a thumb
// down.
import { expect, type Locator, type Page } from '@playwright/test';

/** More tab stops than the page has with everything open. */
const MOST_STOPS = 160;

/** What has the focus, looking through shadow roots: its test id, or its name. */
export const focused = (page: Page): Promise<string> => page.evaluate(() => {
  let element = document.activeElement;
  while (element?.shadowRoot?.activeElement) element = element.shadowRoot.activeElement;
  return element?.getAttribute('data-testid') ?? element?.getAttribute('aria-label') ?? '';
});

/** Presses Tab until the control has the focus; always forwards, as somebody does who cannot see
    where it is. */
export async function tabTo(page: Page, id: string): Promise<void> {
  for (let i = 0; i < MOST_STOPS; i += 1) {
    if ((await focused(page)) === id) return;
    await page.keyboard.press('Tab');
  }
  throw new Error(`the tabulator does not reach ${id}`);
}

/** The same, and then presses a key there. */
export async function pressAt(page: Page, id: string, key = 'Enter'): Promise<void> {
  await tabTo(page, id);
  await page.keyboard.press(key);
}

/** Holds a thumb on the middle of `control`, pushes by (x, y) px until `isEnough`, and lifts. */
export async function pushUntil(control: Locator, [x, y]: readonly [number, number], isEnough: () => Promise<void>): Promise<void> {
  await expect(control).toBeVisible();
  const box = (await control.boundingBox())!;
  const [left, top] = [box.x + box.width / 2, box.y + box.height / 2];
  const touch = await control.page().context().newCDPSession(control.page());
  await touch.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: [{ x: left, y: top }] });
  await touch.send('Input.dispatchTouchEvent', { type: 'touchMove', touchPoints: [{ x: left + x, y: top + y }] });
  try {
    await isEnough();
  } finally {
    await touch.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
    await touch.detach();
  }
}

/** Nothing is wider than the screen. */
export const fits = async (page: Page): Promise<void> =>
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
