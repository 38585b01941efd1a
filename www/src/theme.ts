// Dark and light: follows the system until a person chooses.

import type { Store, Theme } from "./store.js";

const KEY = "slamlab-theme";

export function startTheme(store: Store): void {
  const kept = read();
  if (kept) store.theme = kept;
  apply(store);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => store.notify("theme"));
}

/** The next of system, light and dark that looks different from the present one. */
export function switchTheme(store: Store): void {
  store.theme = isDark(store) ? "light" : "dark";
  try {
    localStorage.setItem(KEY, store.theme);
  } catch {
    // Storage may be forbidden; the choice then lasts as long as the page.
  }
  apply(store);
  store.notify("theme");
}

export function isDark(store: Store): boolean {
  return store.theme === "system" ? matchMedia("(prefers-color-scheme: dark)").matches : store.theme === "dark";
}

function apply(store: Store): void {
  if (store.theme === "system") delete document.documentElement.dataset["theme"];
  else document.documentElement.dataset["theme"] = store.theme;
}

function read(): Theme | null {
  try {
    const kept = localStorage.getItem(KEY);
    return kept === "light" || kept === "dark" ? kept : null;
  } catch {
    return null;
  }
}
