// A map of the promised size in place of a run: a stand-in for the page's worker reports that a run
// has begun and sends one frame. All drawing is done by the page's own code.
import type { Page } from '@playwright/test';
import { BEAM_STRIDE, LANDMARK_STRIDE, LINE_STRIDE } from '../../www/pkg/layout.ts';

export const LARGE = { cells: 4000, points: 100_000, features: 1000 } as const;

/** The worker's code; it runs there, so it knows nothing of this file but its arguments. */
function worker({ cells, points, features, beamStride, lineStride, landmarkStride }: Readonly<Record<'cells' | 'points' | 'features' | 'beamStride' | 'lineStride' | 'landmarkStride', number>>): void {
  const resolution = 0.05;
  const blockCells = 64;
  const side = Math.ceil(cells / blockCells);
  const half = (cells * resolution) / 2;
  // A pseudo-random number, the same each time.
  let state = 1;
  const chance = (): number => (state = (state * 48_271) % 2_147_483_647) / 2_147_483_647;
  const place = (): number => (2 * chance() - 1) * half;
  const index = new Int32Array(2 * side * side);
  const grid = new Uint8Array(side * side * blockCells * blockCells);
  for (let block = 0; block < side * side; block += 1) {
    index.set([block % side - Math.floor(side / 2), Math.floor(block / side) - Math.floor(side / 2)], 2 * block);
    // Free, with walls every three metres, and noise.
    for (let cell = 0; cell < blockCells * blockCells; cell += 1) grid[block * blockCells * blockCells + cell] = cell % blockCells === 3 ? 240 : 20 + Math.floor(40 * chance());
  }
  const lines = new Float64Array(features * lineStride);
  const landmarks = new Float32Array(features * landmarkStride);
  for (let i = 0; i < features; i += 1) {
    const [x, y] = [place(), place()];
    lines.set([Math.PI / 2, y, 1e-6, 0, 1e-4, x, y, x + 4, y, i % 3, 1, i], i * lineStride);
    landmarks.set([i, 1, x, y, 1e-3, 0, 1e-3, 0.1, 20, 1], i * landmarkStride);
  }
  const nan = NaN;
  const status = {
    source: 'replay', time: 100, progress: 1, scans: 1000, x: 0, y: 0, heading: 0, covXx: 1e-4, covXy: 0, covYy: 1e-4, covHeading: 1e-5, truthX: nan, truthY: nan, truthHeading: nan,
    odometryX: 0, odometryY: 0, odometryHeading: 0, distance: 1000, contacts: nan, goalX: nan, goalY: nan, nees: nan, neesLow: nan, neesHigh: nan, nis: nan, nisLow: nan, nisHigh: nan,
    diagnosis: 'collecting', loopClosures: 0, submap: 0, priorMapOverlap: nan, priorMapMisfit: false, localisation: null, placed: true, effectiveParticles: nan, mapParticles: 0, mapFull: false,
    innovation: null, scanResidual: nan, featuresSeen: nan, featuresMatched: nan, featuresNew: nan, mode: 'manual', task: null, finished: false, halfLength: 0.2, halfWidth: 0.15, isRectangle: false,
    beamHalfAngle: 0, realTimeFactor: nan, remaining: nan, reason: '', activity: '', positionError: nan, headingError: nan, odometryError: nan, explored: nan, knownArea: 4e4, features,
  };
  const absent = ['found', 'cycle', 'doors', 'truth', 'materials', 'priorMap', 'hypotheses', 'particles', 'tracks', 'takenOut', 'movers', 'path', 'rawPath', 'tree', 'frontiers', 'edits', 'submaps', 'twin', 'samples', 'inspection', 'rooms', 'points', 'wheels', 'field', 'refinding', 'trail'];
  const frame = {
    kind: 'frame', run: 1, seq: 1, clock: { wall: performance.timeOrigin + performance.now(), time: 100, rate: 0 }, status, gridReset: false, inCycle: false, trailReset: false, twinReset: false,
    ...Object.fromEntries(absent.map((name) => [name, null])),
    grid: { resolution, blockCells, index, cells: grid }, lines, landmarks, scan: Float32Array.from({ length: 2 * points }, place), beams: new Float32Array(beamStride * points).fill(1),
  };
  postMessage({ kind: 'ready', worlds: [], sensors: [], methods: [{ name: 'line-ekf', title: 'Line EKF-SLAM', meaning: '' }], devices: [], presets: [], lessons: [], dataSheet: '' });
  // The page asks for a run, and gets this one.
  let isSent = false;
  onmessage = ({ data }: MessageEvent<{ kind: string }>) => {
    if (data.kind !== 'start' || isSent) return;
    isSent = true;
    postMessage({ kind: 'started', run: 1, source: 'replay', title: 'large', method: 'line-ekf', setup: null, playing: false, isAgain: false });
    postMessage(frame);
  };
}

/** Gives the page this map in place of a run. */
export async function putLargeScene(page: Page): Promise<void> {
  const given = { ...LARGE, beamStride: BEAM_STRIDE, lineStride: LINE_STRIDE, landmarkStride: LANDMARK_STRIDE };
  await page.route('**/worker.js', async (route) => {
    // With the server's headers, or the page may not load it.
    const response = await route.fetch();
    const { 'content-encoding': _packed, 'content-length': _length, ...headers } = response.headers();
    await route.fulfill({ status: 200, headers, body: `(${worker})(${JSON.stringify(given)});` });
  });
}
