// What a first visit loads: all that is sent before the robot of the tour drives, as the bridge
// sends it, packed by brotli at its best.
import { existsSync, statSync } from 'node:fs';
import type { Page } from '@playwright/test';
import type { Lab } from './lab.ts';

/** What issue and specification ask for, bytes. */
export const GOAL = 900_000;

const sent = (path: string): number => {
  const file = new URL(`../../www/dist/${path === '/' ? 'index.html' : path.slice(1)}`, import.meta.url);
  const packed = new URL(`${file.href}.br`);
  return statSync(existsSync(packed) ? packed : file).size;
};

/** Makes a first visit; what was loaded, with its bytes, the heaviest first. */
export async function firstVisit(page: Page, lab: Lab, baseURL: string): Promise<(readonly [path: string, bytes: number])[]> {
  const paths = new Set<string>();
  page.on('response', (response) => {
    const url = new URL(response.url());
    if (url.origin === new URL(baseURL).origin && url.pathname !== '/bridge.json') paths.add(url.pathname);
  });
  await page.goto('/');
  await lab.watch((s) => s.distance, 'the robot drives').toBeGreaterThan(0.2);
  await page.waitForLoadState('networkidle');
  return [...paths].map((path) => [path, sent(path)] as const).sort((a, b) => b[1] - a[1]);
}

export function sum(weights: readonly (readonly [string, number])[]): number {
  return weights.reduce((all, [, bytes]) => all + bytes, 0);
}
