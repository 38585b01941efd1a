"""Reads a trajectory with evo, and checks that it is what the CARMEN log of the same run can be held against.

    cargo run --release -p slamlab-core --example simulate -- --world arena --tum arena.tum --carmen arena.clf
    python3 tests/interop/trajectory.py arena.tum arena.clf

A pose for each scan, quaternions of length 1, rising times; and the wheels' way from scan to scan, read from the log by itself, not far
from the estimated one. Needs `evo` (PyPI). Apart from the main tests: without Python or the package it says so and ends with 77, which test harnesses take for
"skipped". Ends with 0 only if all holds.
"""

import sys

SKIPPED = 77

try:
    import numpy
    from evo.core import metrics, sync
    from evo.core.trajectory import PoseTrajectory3D
    from evo.tools import file_interface
except ImportError as missing:
    print(f"skipped: {missing}; pip install evo")
    sys.exit(SKIPPED)

# Of the wheels' way from one scan to the next, RMS, m: over a whole drive they drift as far as they like.
MOST_OFF = 0.02


def main(tum, carmen):
    estimate = file_interface.read_tum_trajectory_file(tum)
    valid, why = estimate.check()
    expect(valid, f"evo finds {why}")
    wheels = read_carmen(carmen)
    expect(estimate.num_poses == wheels.num_poses, f"{estimate.num_poses} poses, {wheels.num_poses} scans")
    wheels, estimate = sync.associate_trajectories(wheels, estimate, max_diff=1e-4)
    expect(estimate.num_poses == wheels.num_poses > 10, "every scan has its pose")
    steps = metrics.RPE(metrics.PoseRelation.translation_part, delta=1, delta_unit=metrics.Unit.frames)
    steps.process_data((wheels, estimate))
    rmse = steps.get_statistic(metrics.StatisticsType.rmse)
    expect(rmse < MOST_OFF, f"from scan to scan the wheels are {rmse} m off")
    print(f"{estimate.num_poses} poses, {estimate.path_length:.1f} m; from scan to scan the wheels are off by {1000 * rmse:.1f} mm (RMS)")


def read_carmen(path):
    """Poses by odometry: of each ROBOTLASER1, the second pose behind ranges and remissions."""
    times, places, quaternions = [], [], []
    with open(path, encoding="ascii") as file:
        for line in file:
            words = line.split()
            if not words or words[0] != "ROBOTLASER1":
                continue
            beams = int(words[8])
            remissions = int(words[9 + beams])
            at = 10 + beams + remissions
            x, y, heading = map(float, words[at + 3:at + 6])
            times.append(float(words[at + 11]))
            places.append([x, y, 0])
            quaternions.append([numpy.cos(heading / 2), 0, 0, numpy.sin(heading / 2)])
    return PoseTrajectory3D(numpy.array(places), numpy.array(quaternions), numpy.array(times))


def expect(holds, what):
    if not holds:
        print(f"FAILED: {what}")
        sys.exit(1)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
