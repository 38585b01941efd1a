//! DXF of release 12, which every drawing program reads: walls as lines, lengths as text, each on a
//! layer of its own.
//!
//! A file consists of pairs of lines: a group code and its value.

use std::fmt::{Display, Write as _};

use super::{FloorPlanError, Label, bounds};
use crate::map::Wall;

/// Text height of the lengths, m.
const TEXT: f64 = 0.16;
const WALLS: &str = "WALLS";
const LENGTHS: &str = "LENGTHS";

/// The walls; one drawing unit is a metre.
///
/// # Errors    [`FloorPlanError`].
pub fn dxf(walls: &[Wall]) -> Result<String, FloorPlanError> {
    let (low, high) = bounds(walls)?;
    let mut file = Pairs::default();
    file.section("HEADER");
    file.put(9, "$ACADVER").put(1, "AC1009");
    file.put(9, "$EXTMIN").point(0, low.x, low.y);
    file.put(9, "$EXTMAX").point(0, high.x, high.y);
    file.put(0, "ENDSEC");
    file.section("TABLES");
    file.put(0, "TABLE").put(2, "LAYER").put(70, 2);
    for (name, colour) in [(WALLS, 7), (LENGTHS, 8)] {
        file.put(0, "LAYER").put(2, name).put(70, 0);
        file.put(62, colour).put(6, "CONTINUOUS");
    }
    file.put(0, "ENDTAB").put(0, "ENDSEC");
    file.section("ENTITIES");
    for wall in walls {
        let (a, b) = (wall.segment.a, wall.segment.b);
        file.put(0, "LINE").put(8, WALLS);
        file.point(0, a.x, a.y).point(1, b.x, b.y);
    }
    for label in walls.iter().filter_map(|wall| Label::of(wall, TEXT)) {
        file.put(0, "TEXT").put(8, LENGTHS);
        file.point(0, label.at.x, label.at.y).put(40, TEXT);
        file.put(1, label.text);
        file.put(50, format!("{:.3}", label.direction.to_degrees()));
        // Centred on the second point.
        file.put(72, 1).point(1, label.at.x, label.at.y).put(73, 2);
    }
    file.put(0, "ENDSEC").put(0, "EOF");
    Ok(file.text)
}

#[derive(Default)]
struct Pairs {
    text: String,
}

impl Pairs {
    fn put(&mut self, code: u32, value: impl Display) -> &mut Self {
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "{code}\n{value}");
        self
    }

    fn section(&mut self, name: &str) -> &mut Self {
        self.put(0, "SECTION").put(2, name)
    }

    /// The first or the second point of an entity.
    fn point(&mut self, which: u32, x: f64, y: f64) -> &mut Self {
        self.put(10 + which, format!("{x:.4}"))
            .put(20 + which, format!("{y:.4}"))
            .put(30 + which, "0.0")
    }
}
