//! Floor plans drawn as SVG.
//!
//! 1. `line`, `polyline`, `polygon`, `rect`, `circle`, `ellipse` and `path` are walls where they
//!    have a visible stroke or filling; white ones count as paper. Walls are the lines themselves,
//!    without the width of the pen; curves become straight pieces to within 5 mm. Groups,
//!    `transform`, copies by `use`, classes and whatever hides an element are respected; text and
//!    definitions are not walls. `image`, copies of missing parts, and style sheet rules that are
//!    not read ([`super::svg_style`]) are skipped and reported.
//! 2. The scale is, in this order: the caller's; `data-metres-per-unit` of `<svg>`; what `width`
//!    and `viewBox` give, if `width` is in mm, cm, in, pt or pc; else a centimetre per unit.
//! 3. y points down in a drawing and up in a world.
//! 4. The robot starts in the middle of the element with the id `start`, if there is one; its goal
//!    is the middle of the element with the id `goal`.
//!
//! Source: W3C, Scalable Vector Graphics 1.1, chapters 5, 6, 7, 8 and 9.

use kurbo::{Affine, PathEl};
use nalgebra::Point2;
use roxmltree::{Document, Node, ParsingOptions};
use svgtypes::{Length, LengthUnit, ViewBox};

use super::error::wrong;
use super::room::Room;
use super::svg_copies::Copies;
use super::svg_shape::{Pen, path_of, transform_of};
use super::svg_style::Styles;
use super::{BuildingError, CLEARANCE, Imported, SvgError, checked, fenced};
use crate::geom::{Pose2, bounds};
use crate::map::cells_on_ray;
use crate::sim::{Shape, World};

/// Longer files are refused.
const LONGEST: usize = 1 << 25;
/// More elements than this are refused.
const MOST_NODES: u32 = 1_000_000;
/// More straight walls than this are refused.
const MOST_WALLS: usize = 200_000;
/// Scale of a drawing that does not state one, m per unit.
const DEFAULT_UNIT: f64 = 0.01;
/// How far straight pieces may deviate from a curve, m.
const FLATNESS: f64 = 0.005;
/// Points farther from the origin of the drawing are refused, m.
const FARTHEST: f64 = 1e5;
/// Distance from the walls to the fence, m.
const MARGIN: f64 = 1.0;
/// Cells along the longer side of the raster that is searched for room.
const RASTER: f64 = 800.0;

/// The building that a drawing shows.
///
/// # Units    `metres_per_unit`: scale; `None` takes the scale that the drawing states.
///
/// # Errors    [`BuildingError`]; errors of the drawing name the line.
pub fn of_svg(
    bytes: &[u8],
    metres_per_unit: Option<f64>,
    name: &str,
) -> Result<Imported, BuildingError> {
    if bytes.len() > LONGEST {
        let (bytes, most) = (bytes.len(), LONGEST);
        return Err(SvgError::TooLong { bytes, most }.into());
    }
    let text = String::from_utf8_lossy(bytes);
    let options = ParsingOptions {
        nodes_limit: MOST_NODES,
        ..ParsingOptions::default()
    };
    let document =
        Document::parse_with_options(&text, options).map_err(|error| SvgError::Syntax {
            line: error.pos().row as usize,
            what: error.to_string(),
        })?;
    let root = document.root_element();
    let name_of_root = root.tag_name().name();
    if name_of_root != "svg" {
        let what = format!("<{name_of_root}> begins the file, expected <svg>");
        return Err(SvgError::Syntax { line: 1, what }.into());
    }
    let mut plan = Plan {
        scale: scale_of(&root, metres_per_unit)?,
        ..Plan::default()
    };
    let mut styles = Styles::of(&document)?;
    plan.read(root, &mut styles, &mut Copies::of(&document))?;
    (0..styles.skipped).for_each(|_| plan.skip("style"));
    plan.into_world(name)
}

fn scale_of(root: &Node, given: Option<f64>) -> Result<f64, SvgError> {
    let fits = |scale: f64| scale.is_finite() && scale > 0.0;
    if let Some(scale) = given {
        let scale_given = Some(scale).filter(|&s| fits(s));
        return scale_given.ok_or(SvgError::NoScale(scale));
    }
    let unit = "data-metres-per-unit";
    if let Some(text) = root.attribute(unit) {
        let scale = text.parse().ok().filter(|&s| fits(s));
        return scale.ok_or_else(|| wrong(root, unit, text, "a number above 0"));
    }
    let width = root.attribute("width").and_then(|w| w.parse().ok());
    let view = root.attribute("viewBox").and_then(|v| v.parse().ok());
    let (Some::<Length>(width), Some::<ViewBox>(view)) = (width, view) else {
        return Ok(DEFAULT_UNIT);
    };
    let metres = match width.unit {
        LengthUnit::Mm => 0.001,
        LengthUnit::Cm => 0.01,
        LengthUnit::In => 0.0254,
        LengthUnit::Pt => 0.0254 / 72.0,
        LengthUnit::Pc => 0.0254 / 6.0,
        _ => return Ok(DEFAULT_UNIT),
    };
    let scale = width.number * metres / view.w;
    Ok(if fits(scale) { scale } else { DEFAULT_UNIT })
}

/// Corners in order, and whether the last is joined to the first.
type Line = (Vec<Point2<f64>>, bool);

/// What was read so far, in the world's frame, m.
#[derive(Default)]
struct Plan {
    scale: f64,
    walls: Vec<Line>,
    count: usize,
    start: Option<Point2<f64>>,
    goal: Option<Point2<f64>>,
    skipped: Vec<(String, usize)>,
}

impl Plan {
    /// Reads an element and all its descendants, with an explicit stack because drawings may be
    /// nested deeply.
    fn read<'a>(
        &mut self,
        root: Node<'a, 'a>,
        styles: &mut Styles<'a>,
        copies: &mut Copies<'a>,
    ) -> Result<(), SvgError> {
        let world_from_page = Affine::new([self.scale, 0.0, 0.0, -self.scale, 0.0, 0.0]);
        let mut todo = vec![(root, world_from_page, Pen::default(), None)];
        let mut read = 0;
        while let Some((node, outer, pen, copy)) = todo.pop() {
            // Text, comments and hidden elements take time too, once for each copy.
            read += 1;
            if read > MOST_NODES {
                let most = MOST_NODES as usize;
                return Err(SvgError::TooManyCopies { most });
            }
            if !node.is_element() {
                continue;
            }
            let pen = pen.of(&styles.style(&node));
            if pen.is_gone {
                continue;
            }
            let inner = outer * transform_of(&node)?;
            match node.tag_name().name() {
                // A symbol is drawn only where it is copied.
                "symbol" if copy.is_none() => {}
                "svg" | "g" | "a" | "switch" | "symbol" => {
                    // Reversed, so they are popped in the order of the file.
                    let children = node.children().rev();
                    todo.extend(children.map(|child| (child, inner, pen, copy)));
                }
                "use" => match copies.copy(&node, copy)? {
                    Some((part, place, number)) => {
                        todo.push((part, inner * place, pen, Some(number)));
                    }
                    None => self.skip("use"),
                },
                "image" | "foreignObject" => self.skip(node.tag_name().name()),
                _ => {
                    if let Some(path) = path_of(&node, FLATNESS / self.scale)? {
                        self.take(&node, (inner * path).iter(), &pen, copy.is_some())?;
                    }
                }
            }
        }
        Ok(())
    }

    fn skip(&mut self, name: &str) {
        match self.skipped.iter_mut().find(|(known, _)| known == name) {
            Some((_, count)) => *count += 1,
            None => self.skipped.push((name.to_owned(), 1)),
        }
    }

    fn take(
        &mut self,
        node: &Node,
        path: impl Iterator<Item = PathEl> + Clone,
        pen: &Pen,
        is_copy: bool,
    ) -> Result<(), SvgError> {
        self.check_extent(path.clone())?;
        let mut lines: Vec<Line> = vec![];
        kurbo::flatten(path, FLATNESS, |piece| match piece {
            PathEl::MoveTo(p) => lines.push((vec![Point2::new(p.x, p.y)], false)),
            PathEl::LineTo(p) => {
                if let Some((points, _)) = lines.last_mut() {
                    points.push(Point2::new(p.x, p.y));
                }
            }
            PathEl::ClosePath => {
                if let Some((points, closed)) = lines.last_mut() {
                    *closed = true;
                    // The next piece begins where this one began.
                    if let Some(&first) = points.first() {
                        lines.push((vec![first], false));
                    }
                }
            }
            // Flattening leaves no curves.
            PathEl::QuadTo(..) | PathEl::CurveTo(..) => {}
        });
        if let Some((low, high)) = bounds_of(&lines) {
            let middle = nalgebra::center(&low, &high);
            match node.attribute("id") {
                // Copies of start and goal do not count.
                Some("start" | "goal") if is_copy => {}
                Some("start") => self.start = Some(middle),
                Some("goal") => self.goal = Some(middle),
                _ if pen.is_visible(node.tag_name().name() != "line") => self.add(lines)?,
                _ => {}
            }
        }
        Ok(())
    }

    /// Larger curves give more straight pieces, so sizes are checked before any are made.
    fn check_extent(&self, path: impl Iterator<Item = PathEl>) -> Result<(), SvgError> {
        let controls = path.flat_map(|piece| match piece {
            PathEl::MoveTo(p) | PathEl::LineTo(p) => vec![p],
            PathEl::QuadTo(p, q) => vec![p, q],
            PathEl::CurveTo(p, q, r) => vec![p, q, r],
            PathEl::ClosePath => vec![],
        });
        // A NaN coordinate is refused as well.
        let farthest = |far: f64, at: f64| match at.is_nan() {
            true => f64::INFINITY,
            false => far.max(at.abs()),
        };
        let (x, y) = controls.fold((0.0, 0.0), |(x, y), p| (farthest(x, p.x), farthest(y, p.y)));
        if x <= FARTHEST && y <= FARTHEST {
            return Ok(());
        }
        Err(self.wrong_scale(x, y))
    }

    fn wrong_scale(&self, width: f64, height: f64) -> SvgError {
        SvgError::Scale {
            width,
            height,
            metres_per_unit: self.scale,
        }
    }

    fn add(&mut self, lines: Vec<Line>) -> Result<(), SvgError> {
        for (mut points, closed) in lines {
            points.dedup();
            if closed && points.len() > 1 && points.first() == points.last() {
                points.pop();
            }
            let closed = closed && points.len() > 2;
            if points.len() < 2 {
                continue;
            }
            self.count += points.len();
            if self.count > MOST_WALLS {
                return Err(SvgError::TooMany { most: MOST_WALLS });
            }
            self.walls.push((points, closed));
        }
        Ok(())
    }

    fn into_world(self, name: &str) -> Result<Imported, BuildingError> {
        let (low, high) = bounds_of(&self.walls).ok_or(BuildingError::NoWalls)?;
        let size = high - low;
        // Also true where a size is NaN.
        if !(size.max() >= 1.0 && size.max() <= 2000.0) {
            return Err(self.wrong_scale(size.x, size.y).into());
        }
        let mut world = World::new(name, Pose2::identity());
        world.goal = self.goal;
        let radius = world.robot.model().radius() + CLEARANCE;
        let start = match self.start {
            Some(start) => start,
            None => roomiest(&self.walls, low, high, radius)?,
        };
        world.start = Pose2::new(start.x, start.y, 0.0);
        for (points, closed) in self.walls {
            world = world.with(Shape::Polyline { points, closed });
        }
        let by = nalgebra::Vector2::new(MARGIN, MARGIN);
        let (low, high) = (low - by, high + by);
        let (right, left) = (Point2::new(high.x, low.y), Point2::new(low.x, high.y));
        let corners = [low, right, high, left];
        let words = |(name, count): (String, usize)| {
            let why = match name.as_str() {
                "style" => " (rules for elements within others, or for some media only)",
                "use" => " (copies of what is not in the file, or has a view box of its own)",
                _ => "",
            };
            format!("{count} × <{name}>{why}")
        };
        Ok(Imported {
            world: checked(fenced(world, corners))?,
            skipped: self.skipped.into_iter().map(words).collect(),
        })
    }
}

/// The place farthest from all walls: inside the building, if it encloses any space.
fn roomiest(
    walls: &[Line],
    low: Point2<f64>,
    high: Point2<f64>,
    needed: f64,
) -> Result<Point2<f64>, BuildingError> {
    let resolution = ((high - low).max() / RASTER).max(0.02);
    let pad = nalgebra::Vector2::new(2.0, 2.0) * resolution;
    let low = low - pad;
    let side = |length: f64| (length / resolution).ceil() as usize + 3;
    let (width, height) = (side(high.x - low.x), side(high.y - low.y));
    let mut stands = vec![false; width * height];
    let in_cells = |p: Point2<f64>| Point2::from((p - low) / resolution);
    for (points, closed) in walls {
        let next = points.iter().skip(1).chain(closed.then(|| &points[0]));
        for (a, b) in points.iter().zip(next) {
            cells_on_ray(in_cells(*a), in_cells(*b), |cell| {
                if let Some(cell) = stands.get_mut(cell.row as usize * width + cell.col as usize) {
                    *cell = true;
                }
            });
        }
    }
    let room = Room::new(width, resolution, stands).without_outside(needed);
    Ok(low + room.roomiest(needed)?.coords)
}

fn bounds_of(lines: &[Line]) -> Option<(Point2<f64>, Point2<f64>)> {
    bounds(lines.iter().flat_map(|(points, _)| points).copied())
}
