"""Reads the three files of a floor plan with the tools of others, and checks that all hold the same walls.

    cargo run --release -p slamlab-core --example simulate -- --world office --plan office
    python3 tests/interop/floor_plan.py office

Needs `ezdxf` and `shapely` (PyPI). Apart from the main tests: without Python or a package it says so and ends with 77, which test
harnesses take for "skipped". Ends with 0 only if all that was checked holds.
"""

import json
import sys
import xml.etree.ElementTree as ElementTree

SKIPPED = 77
SVG = "{http://www.w3.org/2000/svg}"

try:
    import ezdxf
    from shapely.geometry import LineString, shape
except ImportError as missing:
    print(f"skipped: {missing}; pip install ezdxf shapely")
    sys.exit(SKIPPED)


def main(stem):
    from_geojson = read_geojson(f"{stem}.geojson")
    from_dxf = read_dxf(f"{stem}.dxf")
    from_svg = read_svg(f"{stem}.svg")
    for name, walls in [("DXF", from_dxf), ("SVG", from_svg)]:
        expect(len(walls) == len(from_geojson), f"{name}: {len(walls)} walls, GeoJSON has {len(from_geojson)}")
        for here, there in zip(walls, from_geojson):
            apart = here.hausdorff_distance(there)
            expect(apart < 1e-4, f"{name}: {here} is {apart} m off {there}")
    total = sum(wall.length for wall in from_geojson)
    print(f"{len(from_geojson)} walls, {total:.2f} m together: the same in GeoJSON, DXF and SVG")


def read_geojson(path):
    with open(path, encoding="utf-8") as file:
        collection = json.load(file)
    expect(collection["type"] == "FeatureCollection", "a collection of features")
    walls = []
    for feature in collection["features"]:
        wall = shape(feature["geometry"])
        expect(wall.is_valid and isinstance(wall, LineString), f"{wall} is a valid line")
        length = feature["properties"]["length_m"]
        expect(abs(wall.length - length) < 1e-9, f"length {length} of a line of {wall.length} m")
        walls.append(wall)
    return walls


def read_dxf(path):
    drawing = ezdxf.readfile(path)
    auditor = drawing.audit()
    expect(not auditor.errors, f"errors: {auditor.errors}")
    space = drawing.modelspace()
    walls = [LineString([(end.x, end.y) for end in (line.dxf.start, line.dxf.end)]) for line in space.query("LINE[layer=='WALLS']")]
    texts = space.query("TEXT[layer=='LENGTHS']")
    expect(len(texts) > 0, "lengths are written")
    # Written to the centimetre, of walls whose ends are rounded too.
    for text in texts:
        off = min(abs(float(text.dxf.text) - wall.length) for wall in walls)
        expect(off < 0.0051, f"{text.dxf.text} m is the length of no wall, by {off:.4f} m")
    return walls


def read_svg(path):
    root = ElementTree.parse(path).getroot()
    expect(root.tag == f"{SVG}svg", f"the root is {root.tag}")
    x0, y0, width, height = map(float, root.get("viewBox").split())
    walls = []
    for line in root.iter(f"{SVG}line"):
        (xa, ya), (xb, yb) = [(float(line.get(f"x{i}")), float(line.get(f"y{i}"))) for i in (1, 2)]
        for x, y in [(xa, ya), (xb, yb)]:
            expect(x0 < x < x0 + width and y0 < y < y0 + height, f"({x}, {y}) lies outside of the picture")
        walls.append(LineString([(xa, -ya), (xb, -yb)]))
    return walls


def expect(holds, what):
    if not holds:
        print(f"does not hold: {what}")
        sys.exit(1)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        print(__doc__)
        sys.exit(2)
    main(sys.argv[1])
