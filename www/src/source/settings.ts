// The table of settings as plain objects; the module's own are freed.

import { preset_list, setting_list, type PresetInfo, type SettingInfo } from "../../pkg/slamlab_web.js";
import type { SettingValues } from "../protocol/module.js";
import type { Preset, Setting } from "../protocol/setup.js";

export function settingsOf(sensor: string, settings: SettingValues): Setting[] {
  return setting_list(sensor, Object.keys(settings), Float64Array.from(Object.values(settings))).map(settingOf);
}

export function presets(): Preset[] {
  return preset_list().map(presetOf);
}

function settingOf(info: SettingInfo): Setting {
  const { key, group, name, unit, low, high, kind, choices, at_once: atOnce, meaning, default: usual } = info;
  info.free();
  return { key, group, name, unit, low, high, kind: kind as Setting["kind"], choices, atOnce, meaning, default: usual };
}

function presetOf(info: PresetInfo): Preset {
  const { group, name, meaning, keys, values } = info;
  info.free();
  return { group, name, meaning, values: Object.fromEntries(keys.map((key, i) => [key, values[i] ?? NaN])) };
}
