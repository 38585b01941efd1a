// A CARMEN log with known truth: a robot with odometry errors drives laps in a building.

interface Pose {
  x: number;
  y: number;
  heading: number;
}

export interface Recording {
  text: string;
  /** The true final pose, in the frame of its first pose. */
  end: Pose;
  /** The final pose by odometry, in the same frame. */
  wheelsEnd: Pose;
}

const BEAMS = 180;
/** The range reported by a beam without a return, m. */
const NOTHING = 81.9;
const RATE = 5;
/** Distance between two scans, m, and turn in a corner, rad. */
const STEP = 0.09;
const TURN = Math.PI / 30;

type Wall = readonly [number, number, number, number];

const box = (x1: number, y1: number, x2: number, y2: number): Wall[] => [
  [x1, y1, x2, y1], [x2, y1, x2, y2], [x2, y2, x1, y2], [x1, y2, x1, y1],
];

/** Walls, m; the start of the laps, facing along x; their four legs, each with a left turn after
    it; and the range of the sensor. */
interface Building {
  walls: readonly Wall[];
  start: readonly [number, number];
  legs: readonly number[];
  reach: number;
}

/** A room of 8 x 6 m with two boxes: whatever is seen is already known. */
const ROOM: Building = {
  walls: [...box(0, 0, 8, 6), ...box(3, 2.4, 4.4, 3.6), ...box(6.9, 0, 8, 0.7), ...box(0, 5.1, 1.6, 6), ...box(4.5, 5.6, 5.2, 6)],
  start: [1.2, 1.2], legs: [5.4, 3.6, 5.4, 3.6], reach: Infinity,
};

/** A ring of corridors, 2 m wide and longer than the sensor's range: by the end of a lap the
    estimate has drifted, and the start, seen again, shows it. */
export const RING: Building = {
  walls: [...box(0, 0, 24, 14), ...box(2, 2, 22, 12), ...box(2.6, 0, 3.4, 0.4), ...box(23.5, 3.5, 24, 4.6), ...box(19, 13.6, 20.2, 14), ...box(0, 8.8, 0.4, 9.4), ...box(22, 8, 22.4, 8.5)],
  start: [1, 1], legs: [22, 12, 22, 12], reach: 6,
};

/** The same number of scans in the same building gives the same text. */
export function record(scans: number, { walls, start: [x, y], legs, reach }: Building = ROOM): Recording {
  const random = generator(7);
  const lines = ['# message_name [message contents] ipc_timestamp ipc_hostname logger_timestamp', 'PARAM robot_front_laser_max 81.90'];
  let truth: Pose = { x, y, heading: 0 };
  let wheels: Pose = { ...truth };
  const start = { ...truth };
  const motions = laps(legs);
  for (let i = 0; i < scans; i += 1) {
    if (i > 0) {
      const [forward, turn] = motions.next().value;
      truth = move(truth, forward, turn);
      // Odometry measures each distance too long and veers to the left.
      wheels = move(wheels, forward * 1.03, turn + forward * 0.012 + 0.002 * random());
    }
    const ranges = Array.from({ length: BEAMS }, (_, k) => {
      const range = cast(walls, truth, -Math.PI / 2 + (k * Math.PI) / BEAMS) + 0.01 * random();
      return (range > reach ? NOTHING : range).toFixed(2);
    });
    const pose = `${wheels.x.toFixed(6)} ${wheels.y.toFixed(6)} ${wheels.heading.toFixed(6)}`;
    const time = (1000 + i / RATE).toFixed(6);
    lines.push(`FLASER ${BEAMS} ${ranges.join(' ')} ${pose} ${pose} ${time} robot ${(i / RATE).toFixed(6)}`);
  }
  return { text: `${lines.join('\n')}\n`, end: relative(start, truth), wheelsEnd: relative(start, wheels) };
}

/** Two buildings in one log, as of a robot that was carried from one to the other while its
    recorder was running: the second does not fit into the map of the first. */
export function carried(): string {
  const [first, second] = [record(600), record(400, RING)].map(({ text }) => text.split('\n').filter((line) => line.startsWith('FLASER')));
  const later = (line: string): string => {
    const fields = line.split(' ');
    const stamp = fields.length - 3;
    fields[stamp] = (Number(fields[stamp]) + 200).toFixed(6);
    return fields.join(' ');
  };
  return `${[...first!, ...second!.map(later)].join('\n')}\n`;
}

/** Motions along a rectangle: straight legs, quarter turns. */
function* laps(legs: readonly number[]): Generator<[number, number], never> {
  for (;;) {
    for (const leg of legs) {
      const steps = Math.round(leg / STEP);
      for (let i = 0; i < steps; i += 1) yield [leg / steps, 0];
      for (let i = 0; i < 15; i += 1) yield [0, TURN];
    }
  }
}

function move(pose: Pose, forward: number, turn: number): Pose {
  const middle = pose.heading + turn / 2;
  return { x: pose.x + forward * Math.cos(middle), y: pose.y + forward * Math.sin(middle), heading: wrap(pose.heading + turn) };
}

function relative(from: Pose, to: Pose): Pose {
  const [dx, dy] = [to.x - from.x, to.y - from.y];
  const [c, s] = [Math.cos(from.heading), Math.sin(from.heading)];
  return { x: c * dx + s * dy, y: -s * dx + c * dy, heading: wrap(to.heading - from.heading) };
}

function wrap(angle: number): number {
  return Math.atan2(Math.sin(angle), Math.cos(angle));
}

/** Distance to the nearest wall in a direction of the robot. */
function cast(walls: readonly Wall[], pose: Pose, bearing: number): number {
  const [dx, dy] = [Math.cos(pose.heading + bearing), Math.sin(pose.heading + bearing)];
  let nearest = Infinity;
  for (const [x1, y1, x2, y2] of walls) {
    const [ex, ey] = [x2 - x1, y2 - y1];
    const cross = dx * ey - dy * ex;
    if (Math.abs(cross) < 1e-12) continue;
    const [px, py] = [x1 - pose.x, y1 - pose.y];
    const t = (px * ey - py * ex) / cross;
    const along = (px * dy - py * dx) / cross;
    if (t > 0 && along >= 0 && along <= 1) nearest = Math.min(nearest, t);
  }
  return nearest;
}

/** Standard normal numbers, the same for the same seed. */
function generator(seed: number): () => number {
  let state = seed;
  const uniform = (): number => {
    state = (Math.imul(state, 1_664_525) + 1_013_904_223) >>> 0;
    return (state + 0.5) / 2 ** 32;
  };
  return () => Math.sqrt(-2 * Math.log(uniform())) * Math.cos(2 * Math.PI * uniform());
}
