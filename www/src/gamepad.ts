// A gamepad: its left stick drives; its right trigger and B stop. It is read once per frame while
// it is connected and the page is visible.

/** The state of a gamepad that the page shows. */
export interface GamepadState {
  /** Its maker's name for it. */
  readonly name: string;
  /** Of the stick, -1 to 1: up and left are positive. */
  readonly forward: number;
  readonly turn: number;
  /** Whether a button that stops is pressed. */
  readonly stops: boolean;
}

export interface GamepadActions {
  /** Shows the present state of the gamepad; null if it is gone. */
  show(state: GamepadState | null): void;
  drive(forward: number, turn: number): void;
  stop(): void;
}

/** Dead zone of a stick, as part of its range: worn sticks never quite return to the centre. */
const DEAD = 0.15;
/** Smaller changes are not sent. */
const STEP = 0.02;
/** Buttons that stop, numbered as in the standard layout: B (or circle), the right trigger. */
const STOPS = [1, 7] as const;

export function startGamepad(actions: GamepadActions): void {
  let sent: readonly [number, number] = [0, 0];
  let stopping = false;
  let frame = 0;

  const send = (forward: number, turn: number): void => {
    const changed = Math.abs(forward - sent[0]) > STEP || Math.abs(turn - sent[1]) > STEP;
    const rests = forward === 0 && turn === 0 && (sent[0] !== 0 || sent[1] !== 0);
    if (!changed && !rests) return;
    sent = [forward, turn];
    actions.drive(forward, turn);
  };

  let shown = "";
  const show = (state: GamepadState | null): void => {
    // To a hundredth: a stick at rest still jitters.
    const now = state ? JSON.stringify({ ...state, forward: state.forward.toFixed(2), turn: state.turn.toFixed(2) }) : "";
    if (now !== shown) actions.show(state);
    shown = now;
  };

  const read = (): void => {
    const pads = navigator.getGamepads().filter((pad) => pad?.connected === true);
    frame = pads.length > 0 ? requestAnimationFrame(read) : 0;
    // Of several gamepads, the one that is moved.
    const axis = (index: number): number => pads.map((pad) => soft(pad?.axes[index] ?? 0)).find((value) => value !== 0) ?? 0;
    const stop = pads.some((pad) => STOPS.some((button) => pad?.buttons[button]?.pressed === true));
    if (stop && !stopping) {
      sent = [0, 0];
      actions.stop();
    }
    stopping = stop;
    // Up and left are negative on a gamepad. While a stop is pressed, or another window is in use,
    // the stick is ignored.
    const [forward, turn] = [-axis(1) || 0, -axis(0) || 0];
    if (!document.hasFocus()) release();
    else if (!stop) send(forward, turn);
    if (pads.length === 0) release();
    show(pads[0] ? { name: nameOf(pads.map((pad) => pad?.id ?? "")), forward, turn, stops: stop } : null);
  };

  const wake = (): void => {
    if (frame === 0) read();
  };
  const release = (): void => {
    if (sent[0] !== 0 || sent[1] !== 0) send(0, 0);
  };

  addEventListener("gamepadconnected", wake);
  addEventListener("gamepaddisconnected", () => {
    release();
    wake();
  });
  // Frames stop when the page is hidden: the robot must not go on with the last command.
  addEventListener("blur", release);
  document.addEventListener("visibilitychange", release);
}

function soft(value: number): number {
  return Math.abs(value) < DEAD ? 0 : Math.max(-1, Math.min(1, (value - Math.sign(value) * DEAD) / (1 - DEAD)));
}

/** Its maker's name, without the numbers that browsers put before or after it. */
function nameOf(ids: readonly string[]): string {
  const names = ids.map((id) => id.replace(/\s*\((?:[^()]*\b)?Vendor:[^)]*\)/i, "").replace(/^[0-9a-f]{1,4}-[0-9a-f]{1,4}-/i, "").trim());
  return names.map((name) => name || "Gamepad").join(", ");
}
