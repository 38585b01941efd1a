// The robot obeys: a click on the map, keys, a phone's joystick, and above all Stop.
import { expect, test } from './fixture.ts';
import type { Lab } from './lab.ts';

test('a click on the map sends the robot there', { tag: '@phone' }, async ({ lab, hasTouch }) => {
  await lab.open();
  await lab.enter('arena', '10');
  await lab.at('mode-goto').click();
  await expect(lab.at('caption')).toContainText('Click the map where');
  // Behind the first box of the arena, in the frame of the robot's start.
  const goal = { x: 1.6, y: 1.2 };
  await lab.pointAt(goal.x, goal.y, hasTouch);
  await lab.watch((s) => s.mode, 'it has an errand').toBe('goto');
  await expect(lab.at('caption')).not.toContainText('Click the map where');
  await lab.watch((s) => s.reason, 'it arrives').toContain('goal reached');
  await expect(lab.at('caption')).toContainText('Goal reached');
  const status = await lab.status();
  expect(Math.hypot(status.truthX - goal.x, status.truthY - goal.y), 'the true pose is at the goal').toBeLessThan(0.2);
  expect(status.contacts).toBe(0);
  // The run came to rest there. A command means that the robot should move: the run goes on.
  await lab.pointAt(0, 0, hasTouch);
  await lab.watch((s) => Math.hypot(s.truthX, s.truthY), 'it drives back').toBeLessThan(0.3);
});

test('while it explores, a click asks before the robot goes there', { tag: '@phone' }, async ({ lab, hasTouch }) => {
  await lab.open();
  await lab.enter('arena', '1');
  await lab.watch((s) => s.distance, 'it explores').toBeGreaterThan(0.1);
  const place = [1.6, 1.2] as const;
  await lab.pointAt(...place, hasTouch);
  await lab.says('Send the robot there?');
  const { time } = await lab.status();
  await lab.watch((s) => s.time, 'it goes on').toBeGreaterThan(time + 1);
  expect((await lab.status()).mode, 'nothing happens unanswered').toBe('explore');
  await lab.at('toast-way').click();
  await lab.watch((s) => s.mode, 'it is sent').toBe('goto');
  const { goalX, goalY } = await lab.status();
  expect(Math.hypot(goalX - place[0], goalY - place[1]), 'to that place').toBeLessThan(0.1);
  await expect(lab.at('toast')).toHaveCount(0);
  // A robot that is not exploring is sent elsewhere by a click, without a question.
  await lab.pointAt(0, 0, hasTouch);
  await lab.watch((s) => s.goalX, 'at once').toBeLessThan(0.5);
  await lab.at('stop').click();
  await lab.watch((s) => s.mode, 'it is stopped').toBe('manual');
  await lab.pointAt(...place, hasTouch);
  await lab.watch((s) => s.mode, 'and sent again').toBe('goto');
});

test('the robot drives while a key is held', async ({ lab, page }) => {
  await lab.open();
  await lab.enter('arena', '1');
  await lab.at('mode-manual').click();
  await lab.watch((s) => s.mode, 'the hand takes over').toBe('manual');
  await lab.standsStill();
  for (const key of ['ArrowUp', 'w']) {
    const { distance } = await lab.status();
    await page.keyboard.down(key);
    await lab.watch((s) => s.distance, `${key} drives`).toBeGreaterThan(distance + 0.15);
    await page.keyboard.up(key);
    await lab.standsStill();
  }
  for (const [key, sign] of [['ArrowLeft', 1], ['d', -1]] as const) {
    const { truthHeading } = await lab.status();
    await page.keyboard.down(key);
    await lab.watch((s) => sign * turnBetween(s.truthHeading, truthHeading), `${key} turns`).toBeGreaterThan(0.3);
    await page.keyboard.up(key);
    await lab.standsStill();
  }
});

test('the stick drives under the thumb', { tag: '@phone-only' }, async ({ lab, page }) => {
  await lab.open();
  await lab.enter('arena', '1');
  await lab.at('mode-manual').tap();
  await lab.standsStill();
  const { distance } = await lab.status();
  const box = await lab.at('stick').boundingBox();
  if (!box) throw new Error('the stick is not shown');
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const touch = await page.context().newCDPSession(page);
  await touch.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: [{ x, y }] });
  await touch.send('Input.dispatchTouchEvent', { type: 'touchMove', touchPoints: [{ x, y: y - 60 }] });
  await lab.watch((s) => s.distance, 'it drives').toBeGreaterThan(distance + 0.15);
  await touch.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
  await lab.standsStill();
});

test('a gamepad drives, and stops when it is let go or its stop button is pressed', async ({ lab, page }) => {
  // Our machines have no gamepad: the browser gets a simulated one of the standard layout.
  await page.addInitScript(() => {
    const pad = { connected: true, id: 'Pilot Pad (STANDARD GAMEPAD Vendor: 045e Product: 028e)', axes: [0, 0, 0, 0], buttons: Array.from({ length: 16 }, () => ({ pressed: false })) };
    Object.assign(window, { pad });
    Object.defineProperty(navigator, 'getGamepads', { value: () => [null, pad] });
  });
  const move = (axes: number[], stop = false): Promise<void> =>
    page.evaluate(([axes, stop]) => {
      const { pad } = window as unknown as { pad: { axes: number[]; buttons: { pressed: boolean }[] } };
      pad.axes = axes;
      pad.buttons[1]!.pressed = stop;
    }, [axes, stop] as const);
  await lab.open();
  await lab.enter('arena', '1');
  await lab.at('mode-manual').click();
  await lab.standsStill();
  await expect(lab.at('gamepad')).toBeHidden();
  await page.evaluate(() => window.dispatchEvent(new Event('gamepadconnected')));
  await expect(lab.at('gamepad'), 'the page says what it does').toHaveText(/Pilot Pad\s+left stick drives, B or right trigger stops/);
  const dot = lab.at('gamepad-stick').locator('.dot');
  await expect(dot, 'its stick rests').toHaveAttribute('cy', '12');
  const { distance } = await lab.status();
  await move([0.05, -1]);
  await expect(dot, 'up').toHaveAttribute('cy', '5');
  await lab.watch((s) => s.distance, 'up drives ahead').toBeGreaterThan(distance + 0.15);
  await move([0.05, 0.1]);
  await lab.standsStill();
  const { truthHeading } = await lab.status();
  await move([-1, 0]);
  await lab.watch((s) => turnBetween(s.truthHeading, truthHeading), 'left turns to the left').toBeGreaterThan(0.3);
  await move([-1, 0], true);
  await lab.standsStill();

  await move([0, -1]);
  await expect(dot).toHaveAttribute('cy', '5');
  await page.evaluate(() => {
    (window as unknown as { pad: { connected: boolean } }).pad.connected = false;
    window.dispatchEvent(new Event('gamepaddisconnected'));
  });
  await expect(lab.at('gamepad'), 'it is gone').toBeHidden();
  await expect(lab.at('toast')).toHaveText(/Pilot Pad is gone/);
  await lab.standsStill();
});

test('full speed at a wall ends before the wall', async ({ lab, page }) => {
  await lab.open();
  await lab.enter('arena', '10');
  await lab.at('mode-manual').click();
  await lab.standsStill();
  for (const key of ['ArrowUp', 'ArrowDown']) {
    await page.keyboard.down(key);
    await lab.standsStill();
    await page.keyboard.up(key);
  }
  const status = await lab.status();
  expect(status.distance, 'it did drive').toBeGreaterThan(0.5);
  expect(status.contacts).toBe(0);
});

test('the button stops the robot', { tag: '@phone' }, async ({ lab }) => {
  await exploring(lab);
  await lab.at('stop').click();
  await stopped(lab);
});

for (const key of ['Escape', 'Space']) {
  test(`${key} stops the robot`, async ({ lab, page }) => {
    await exploring(lab);
    await page.keyboard.press(key);
    await stopped(lab);
  });
}

test('the space bar stops the robot also after a button was clicked, and presses it for who came there by keys', async ({ lab, page }) => {
  await exploring(lab);
  await lab.at('tab-log').click();
  await page.keyboard.press('Space');
  await stopped(lab);
  await lab.at('tab-plots').focus();
  await page.keyboard.press('Tab');
  await page.keyboard.press('Space');
  await expect(lab.at('tab-filter')).toHaveAttribute('aria-pressed', 'true');
  expect((await lab.status()).mode, 'the robot is not stopped by that').toBe('explore');
});

async function exploring(lab: Lab): Promise<void> {
  await lab.open();
  await lab.watch((s) => s.distance, 'it drives').toBeGreaterThan(0.1);
}

async function stopped(lab: Lab): Promise<void> {
  await lab.standsStill();
  const status = await lab.status();
  expect(status.mode, 'it has forgotten its errand').toBe('manual');
  await lab.at('mode-explore').click();
  await lab.watch((s) => s.distance, 'it can be sent again').toBeGreaterThan(status.distance + 0.1);
}

function turnBetween(a: number, b: number): number {
  return Math.atan2(Math.sin(a - b), Math.cos(a - b));
}
