"""Reads maps for ROS with Pillow and PyYAML as map_server does, and checks that all modes say the same of the same grid.

    cargo run --release -p slamlab-core --example simulate -- --world arena --map trinary.pgm --og-map OGmap.txt
    cargo run --release -p slamlab-core --example simulate -- --world arena --map scale.png --map-mode scale
    cargo run --release -p slamlab-core --example simulate -- --world arena --map raw.pgm --map-mode raw
    python3 tests/interop/map_server.py OGmap.txt trinary.yaml scale.yaml raw.yaml

Runs are the same to the bit, so that the four are files of one map. Needs `pillow` and `PyYAML` (PyPI). Apart from the main tests:
without Python or a package it says so and ends with 77, which test harnesses take for "skipped". Ends with 0 only if all holds.
"""

import sys
from pathlib import Path

SKIPPED = 77

try:
    import yaml
    from PIL import Image
except ImportError as missing:
    print(f"skipped: {missing}; pip install pillow PyYAML")
    sys.exit(SKIPPED)


def main(og_map, *maps):
    truth = read_og_map(og_map)
    for path in maps:
        mode, cells = read_map(path)
        counts = {"free": 0, "occupied": 0, "unknown": 0}
        for place, p in truth.items():
            cell = cells.get(place, -1)
            expect(fits(mode, p, cell), f"{path}: {cell} at {place} where the probability is {p}")
            counts["unknown" if cell < 0 else "occupied" if cell > 65 else "free"] += 1
        beyond = [place for place, cell in cells.items() if cell >= 0 and place not in truth]
        expect(not beyond, f"{path}: {len(beyond)} cells know more than OGmap.txt")
        expect(min(counts.values()) > 0, f"{path}: {counts}")
        print(f"{path}: {mode}, {counts}")


def fits(mode, p, cell):
    """Whether a cell of map_server is what a probability of four digits becomes."""
    if mode != "trinary":
        return cell == -1 if abs(p - 0.5) < 5e-5 else abs(cell - 100 * p) < 0.51
    if abs(p - 0.65) < 1e-4 or abs(p - 0.35) < 1e-4:
        return True
    return cell == (100 if p > 0.65 else 0 if p < 0.35 else -1)


def read_map(path):
    """Percentages by column and row of the map's cells, as `loadMapFromFile` of nav2_map_server has it."""
    with open(path, encoding="utf-8") as file:
        info = yaml.safe_load(file)
    image = Image.open(Path(path).parent / info["image"])
    resolution, (x, y, yaw) = info["resolution"], info["origin"]
    expect(yaw == 0 and info["negate"] == 0, f"{path}: turned or negated")
    col0, row0 = round(x / resolution), round(y / resolution)
    expect(image.mode in ("L", "LA"), f"{path}: pixels are {image.mode}")
    pixels = image.load()
    cells = {}
    for row in range(image.height):
        for col in range(image.width):
            pixel = pixels[col, image.height - 1 - row]
            grey, alpha = pixel if image.mode == "LA" else (pixel, 255)
            cells[col0 + col, row0 + row] = occupancy(info, grey, alpha)
    return info["mode"], cells


def occupancy(info, grey, alpha):
    if info["mode"] == "raw":
        return grey if grey <= 100 else -1
    p = 1 - grey / 255
    free, occupied = info["free_thresh"], info["occupied_thresh"]
    if info["mode"] == "scale" and alpha < 255:
        return -1
    if p > occupied:
        return 100
    if p < free:
        return 0
    return -1 if info["mode"] == "trinary" else round((p - free) / (occupied - free) * 100)


def read_og_map(path):
    with open(path, encoding="utf-8") as file:
        width, height, resolution, x, y = map(float, file.readline().split())
        rows = [list(map(float, line.split())) for line in file]
    expect(len(rows) == height and all(len(row) == width for row in rows), f"{path}: rows and header differ")
    col0, row0 = round(x / resolution), round(y / resolution)
    return {(col0 + col, row0 + row): p for row, line in enumerate(rows) for col, p in enumerate(line)}


def expect(holds, what):
    if not holds:
        print(f"FAILED: {what}")
        sys.exit(1)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
