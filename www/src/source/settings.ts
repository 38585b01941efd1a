// The table of settings as plain objects; the module's own are freed.

import { preset_list, setting_list, type PresetInfo, type SettingInfo } from "../../pkg/slamlab_web.js";
import type { SettingValues } from "../protocol/module.js";
import type { Preset, Setting } from "../protocol/setup.js";

export function settingsOf(source: string, method: string, sensor: string, settings: SettingValues): Setting[] {
  return setting_list(source, method, sensor, Object.keys(settings), Float64Array.from(Object.values(settings))).map(settingOf);
}

export function presets(): Preset[] {
  return preset_list().map(presetOf);
}

function settingOf(info: SettingInfo): Setting {
  const { key, group, name, unit, scale, low, high, kind, choices, at_once: atOnce, is_basic: isBasic, meaning, default: usual, needs, needed, idle } = info;
  info.free();
  return { key, group, name, unit, scale, low, high, kind: kind as Setting["kind"], choices, atOnce, isBasic, meaning, default: usual, needs, needed: [...needed], idle };
}

function presetOf(info: PresetInfo): Preset {
  const { group, name, meaning, keys, values } = info;
  info.free();
  return { group, name, meaning, values: Object.fromEntries(keys.map((key, i) => [key, values[i] ?? NaN])) };
}
