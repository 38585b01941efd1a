// The page does one piece of long work for each picture: several would take longer than the time
// between two pictures.

/** The time of the picture that has its piece of long work already. */
let taken = NaN;

/** Asks for the picture at `now`, the time that its callbacks are given; a piece that `isWaiting`
    since the last picture gets it in any case. Returns whether the work may be done. */
export function takePicture(now: number, isWaiting: boolean): boolean {
  if (now === taken && !isWaiting) return false;
  taken = now;
  return true;
}
