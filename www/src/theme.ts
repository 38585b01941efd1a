// Dark and light: follows the system until a person chooses.

import { ifAllowed } from "./storage.js";
import type { Store } from "./store.js";

const KEY = "slamlab-theme";

export function startTheme(store: Store): void {
  const kept = ifAllowed(() => localStorage.getItem(KEY));
  if (kept === "light" || kept === "dark") store.theme = kept;
  apply(store);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => store.notify("theme"));
}

/** The next of system, light and dark that looks different from the present one. */
export function switchTheme(store: Store): void {
  store.theme = isDark(store) ? "light" : "dark";
  // If it cannot be stored, the choice lasts as long as the page.
  ifAllowed(() => localStorage.setItem(KEY, store.theme));
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
