// A simulated fleet, as a bridge at a router reports it: the tests' own bridge has no router.
import type { Page } from '@playwright/test';

export interface Told {
  name: string; here: boolean; heard: number; pose: [number, number, number] | null; pose_state: string | null; pose_heard: number;
  map_file: string | null; volts: number | null; page: string | null;
  safety: { armed: boolean; emergency: boolean; reason: string; driver: string } | null;
  alert: { severity: string; text: string; heard: number } | null;
}

export class SimulatedFleet {
  readonly stops: string[] = [];
  readonly #begun = Date.now();
  constructor(readonly robots: Told[], readonly moves = false) {}

  static of(count: number, moves = false): SimulatedFleet {
    return new SimulatedFleet(Array.from({ length: count }, (_, n) => robot(`robot-${String(n).padStart(3, '0')}`, n)), moves);
  }

  async serve(page: Page): Promise<void> {
    let revision = 0;
    await page.route('**/fleet.json?*', (route) => {
      revision += 1;
      const now = 1e9 + 1000 * (Date.now() - this.#begun);
      const robots = this.robots.map((told, n) => {
        const way = this.moves && told.safety?.armed ? now / 2e6 + n : n;
        const pose = told.pose && [told.pose[0] + Math.cos(way), told.pose[1] + Math.sin(way), way + Math.PI / 2];
        return { ...told, pose, heard: told.heard < 0 ? now + 1e6 * told.heard : now, alert: told.alert && { ...told.alert, heard: now } };
      });
      // A robot that only drives is reported in short form, as by a bridge.
      const isShort = this.moves && new URL(route.request().url()).searchParams.get('since') !== '0';
      const moved = robots.map(({ name, heard, pose, pose_heard }) => ({ name, heard, pose, pose_heard }));
      return route.fulfill({ json: { revision, now, left_out: 0, connected: true, robots: isShort ? [] : robots, moved: isShort ? moved : [] } });
    });
    await page.route('**/fleet/map/*', (route) => route.fulfill({
      json: { message: { Map: { revision: 1, cell: 0.1, corner: [-3, -3], width: 400, height: 400, runs: [4 * 400 + 2, 4 * 398 * 400 + 1, 4 * 400 + 2] } } },
    }));
    await page.route(/\/fleet\/stop/, (route) => {
      const name = /stop\/(.*)$/.exec(new URL(route.request().url()).pathname)?.[1];
      this.stops.push(name ?? '*');
      for (const told of this.robots) if (told.safety && (!name || told.name === name)) Object.assign(told.safety, { armed: false, reason: 'stop' });
      return route.fulfill({ status: 202, body: '1' });
    });
  }
}

export function robot(name: string, n: number): Told {
  return {
    name, here: true, heard: 0, pose: [3 * (n % 10), 3 * Math.floor(n / 10), 0], pose_state: 'localised', pose_heard: 0, map_file: 'hall.slamlab', volts: 7.4,
    page: 'http://127.0.0.1:1/', safety: { armed: true, emergency: false, reason: 'start', driver: 'anna' }, alert: null,
  };
}
