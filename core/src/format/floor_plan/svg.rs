//! SVG 1.1 at a scale of 1:100, with the length beside each wall.

use std::fmt::Write as _;

use nalgebra::Point2;

use super::{FloorPlanError, Label, bounds};
use crate::map::Wall;

/// Margin around the walls, m.
const MARGIN: f64 = 0.5;
/// Text height of the lengths, m.
const TEXT: f64 = 0.16;

/// A drawing of the walls. One unit of it is a metre; printed, a metre is a centimetre. `start`,
/// map frame, m, is where the robot began. It is marked, so a robot that is put into the drawing as
/// a building ([`crate::format::building::of_svg`]) begins there.
///
/// # Errors    [`FloorPlanError`].
pub fn svg(walls: &[Wall], start: Option<Point2<f64>>) -> Result<String, FloorPlanError> {
    let (low, high) = bounds(walls)?;
    let (width, height) = (high.x - low.x + 2.0 * MARGIN, high.y - low.y + 2.0 * MARGIN);
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.2}mm\" height=\"{:.2}mm\" viewBox=\"{:.3} {:.3} {width:.3} {height:.3}\" data-metres-per-unit=\"1\">\n\
         <title>Floor plan, 1:100, lengths in metres</title>\n\
         <g stroke=\"#14232b\" stroke-width=\"0.04\" stroke-linecap=\"round\">\n",
        10.0 * width,
        10.0 * height,
        low.x - MARGIN,
        -high.y - MARGIN,
    );
    // Writing to a string does not fail.
    for wall in walls {
        let (x1, y1) = (wall.segment.a.x, -wall.segment.a.y);
        let (x2, y2) = (wall.segment.b.x, -wall.segment.b.y);
        let (id, length) = (wall.id, wall.segment.length());
        let _ = writeln!(
            text,
            "<line id=\"wall-{id}\" x1=\"{x1:.4}\" y1=\"{y1:.4}\" x2=\"{x2:.4}\" y2=\"{y2:.4}\"><title>{length:.3} m</title></line>"
        );
    }
    text.push_str("</g>\n");
    if let Some(Point2 { coords: at }) = start {
        let _ = writeln!(
            text,
            "<circle id=\"start\" cx=\"{:.4}\" cy=\"{:.4}\" r=\"0.06\" fill=\"#c14f00\"><title>Here the robot began</title></circle>",
            at.x, -at.y,
        );
    }
    let _ = writeln!(
        text,
        "<g fill=\"#56636a\" font-family=\"sans-serif\" font-size=\"{TEXT}\" text-anchor=\"middle\">"
    );
    for label in walls.iter().filter_map(|wall| Label::of(wall, TEXT)) {
        let (x, y) = (label.at.x, -label.at.y);
        let turned = -label.direction.to_degrees();
        // Half of the text height below the middle.
        let _ = writeln!(
            text,
            "<text x=\"{x:.3}\" y=\"{y:.3}\" dy=\"0.35em\" transform=\"rotate({turned:.2} {x:.3} {y:.3})\">{}</text>",
            label.text
        );
    }
    text.push_str("</g>\n</svg>\n");
    Ok(text)
}
