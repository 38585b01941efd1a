// Every key of the page. Driving keys count only while they are held.

export interface KeyActions {
  drive(forward: number, turn: number): void;
  stop(): void;
  /** Esc closes what is open. Returns whether that was its only purpose: nothing is stopped. */
  escape(): boolean;
  /** Whether there is a robot to steer; otherwise the letters for driving are free for keys that
      act once. */
  steers(): boolean;
  /** Keys that act once, in lower case; some do the opposite with Shift. */
  once: Readonly<Record<string, (shift: boolean) => void>>;
  /** Something modal is open and owns the keys. */
  busy(): boolean;
}

const FORWARD: Readonly<Record<string, number>> = { ArrowUp: 1, KeyW: 1, ArrowDown: -1, KeyS: -1 };
const TURN: Readonly<Record<string, number>> = { ArrowLeft: 1, KeyA: 1, ArrowRight: -1, KeyD: -1 };

export function startKeyboard(actions: KeyActions): void {
  const held = new Set<string>();

  const drive = (): void => {
    let [forward, turn] = [0, 0];
    for (const code of held) {
      forward += FORWARD[code] ?? 0;
      turn += TURN[code] ?? 0;
    }
    actions.drive(Math.sign(forward), Math.sign(turn));
  };

  const release = (): void => {
    if (held.size === 0) return;
    held.clear();
    drive();
  };

  // A clicked button keeps the focus. The space bar presses it only if the focus came there by
  // keys; otherwise it stops the robot.
  let isByKeys = true;
  addEventListener("pointerdown", () => (isByKeys = false), true);
  addEventListener("keydown", (event) => {
    if (event.key === "Tab" || event.key === "Enter") isByKeys = true;
  }, true);
  let isStopping = false;

  addEventListener("keydown", (event) => {
    if (event.defaultPrevented || actions.busy()) return;
    if (event.key === "Escape") {
      if (actions.escape()) return;
      release();
      actions.stop();
      return;
    }
    const kind = focusKind(event);
    if (kind === "field" || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.code === "Space" && (kind !== "button" || !isByKeys)) {
      event.preventDefault();
      isStopping = true;
      release();
      actions.stop();
    } else if (!event.shiftKey && actions.steers() && (event.code in FORWARD || event.code in TURN)) {
      event.preventDefault();
      if (held.has(event.code)) return;
      held.add(event.code);
      drive();
    } else {
      const action = actions.once[event.key.toLowerCase()];
      if (!action || event.repeat) return;
      event.preventDefault();
      action(event.shiftKey);
    }
  });

  addEventListener("keyup", (event) => {
    // Some browsers press the button when the key is released.
    if (event.code === "Space" && isStopping) event.preventDefault();
    if (event.code === "Space") isStopping = false;
    if (held.delete(event.code)) drive();
  });
  addEventListener("blur", release);
  document.addEventListener("visibilitychange", release);
}

/** What the key would act on, looking through shadow roots. */
function focusKind(event: KeyboardEvent): "field" | "button" | "page" {
  const target = event.composedPath()[0];
  if (target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && target.type !== "checkbox")) return "field";
  const isButton = target instanceof HTMLButtonElement || target instanceof HTMLInputElement || (target instanceof HTMLElement && target.tagName === "SUMMARY");
  return isButton ? "button" : "page";
}
