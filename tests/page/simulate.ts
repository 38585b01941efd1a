// Runs of the simulation on the command line, for comparison with those of the page.
import { execFileSync } from 'node:child_process';
import { fileURLToPath } from 'node:url';

export interface Figures {
  state_hash: string;
  sim_seconds: number;
}

/** The same run on the command line. */
export function simulate(world: string, sensor: string, seed: number): Figures {
  const program = process.env.SLAMLAB_SIMULATE ?? fileURLToPath(new URL('../../target/debug/examples/simulate', import.meta.url));
  const options = ['--world', world, '--sensor', sensor, '--seed', String(seed), '--mode', 'explore', '--json'];
  return JSON.parse(execFileSync(program, options, { encoding: 'utf8' })) as Figures;
}
