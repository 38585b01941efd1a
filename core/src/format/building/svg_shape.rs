//! One element of a drawing: its outline, its place, and how it is drawn.

use kurbo::{Affine, BezPath, Circle, Ellipse, Rect, Shape as _};
use roxmltree::Node;
use svgtypes::{Length, LengthUnit, PointsParser, TransformListParser, TransformListToken};

use super::SvgError;
use super::error::{line_of, wrong};
use super::svg_style::Style;
use crate::geom::sin_cos;

/// Largest radius, in multiples of the allowed deviation: 100 km at half a centimetre.
const FINEST: f64 = 2e7;

/// How lines and areas are drawn. An element inherits from its group what it does not state.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pen {
    has_stroke: bool,
    is_unfilled: bool,
    /// Neither the element nor its children are drawn.
    pub(super) is_gone: bool,
    /// The element is not drawn, but its children may be.
    is_hidden: bool,
}

impl Pen {
    /// The pen of an element with this style within a group that has this pen.
    pub(super) fn of(mut self, style: &Style) -> Self {
        if let Some(stroke) = style.get("stroke") {
            self.has_stroke = is_ink(stroke);
        }
        if let Some(fill) = style.get("fill") {
            self.is_unfilled = !is_ink(fill);
        }
        self.is_gone |= style.get("display") == Some("none");
        match style.get("visibility") {
            Some("hidden" | "collapse") => self.is_hidden = true,
            Some("visible") => self.is_hidden = false,
            _ => {}
        }
        self
    }

    /// Whether a shape drawn with this pen is visible; a line has no area to fill.
    pub(super) fn is_visible(self, has_area: bool) -> bool {
        !self.is_hidden && (self.has_stroke || (has_area && !self.is_unfilled))
    }
}

/// White is paper.
fn is_ink(colour: &str) -> bool {
    !matches!(
        colour.to_ascii_lowercase().replace(' ', "").as_str(),
        "none" | "transparent" | "white" | "#fff" | "#ffffff" | "rgb(255,255,255)"
    )
}

/// The transform of an element within its group.
///
/// # Errors    [`SvgError::Attribute`].
pub(super) fn transform_of(node: &Node) -> Result<Affine, SvgError> {
    let Some(text) = node.attribute("transform") else {
        return Ok(Affine::IDENTITY);
    };
    let mut whole = Affine::IDENTITY;
    for token in TransformListParser::from(text) {
        let token = token.map_err(|_| wrong(node, "transform", text, "a list of transforms"))?;
        whole *= affine(token);
    }
    Ok(whole)
}

fn affine(token: TransformListToken) -> Affine {
    use TransformListToken as T;
    let turned = |degrees: f64| {
        let (sin, cos) = sin_cos(degrees.to_radians());
        Affine::new([cos, sin, -sin, cos, 0.0, 0.0])
    };
    let slope = |degrees: f64| {
        let (sin, cos) = sin_cos(degrees.to_radians());
        sin / cos
    };
    match token {
        T::Matrix { a, b, c, d, e, f } => Affine::new([a, b, c, d, e, f]),
        T::Translate { tx, ty } => Affine::translate((tx, ty)),
        T::Scale { sx, sy } => Affine::scale_non_uniform(sx, sy),
        T::Rotate { angle } => turned(angle),
        T::SkewX { angle } => Affine::new([1.0, 0.0, slope(angle), 1.0, 0.0, 0.0]),
        T::SkewY { angle } => Affine::new([1.0, slope(angle), 0.0, 1.0, 0.0, 0.0]),
    }
}

/// The outline of a shape in its own units; `None` for other elements and for shapes without size.
///
/// # Errors    [`SvgError::Attribute`] and [`SvgError::Syntax`] of what cannot be read.
pub(super) fn path_of(node: &Node, flatness: f64) -> Result<Option<BezPath>, SvgError> {
    let number = |name| length(node, name);
    Ok(match node.tag_name().name() {
        "line" => {
            let mut path = BezPath::new();
            path.move_to((number("x1")?, number("y1")?));
            path.line_to((number("x2")?, number("y2")?));
            Some(path)
        }
        "polyline" => points(node)?,
        "polygon" => points(node)?.map(|mut path| {
            path.close_path();
            path
        }),
        "rect" => {
            let (x, y) = (number("x")?, number("y")?);
            let (w, h) = (number("width")?, number("height")?);
            (w > 0.0 && h > 0.0).then(|| Rect::new(x, y, x + w, y + h).to_path(flatness))
        }
        "circle" => {
            let (centre, r) = ((number("cx")?, number("cy")?), radius(node, "r", flatness)?);
            (r > 0.0).then(|| Circle::new(centre, r).to_path(flatness))
        }
        "ellipse" => {
            let centre = (number("cx")?, number("cy")?);
            let (rx, ry) = (radius(node, "rx", flatness)?, radius(node, "ry", flatness)?);
            let ellipse = || Ellipse::new(centre, (rx, ry), 0.0).to_path(flatness);
            (rx > 0.0 && ry > 0.0).then(ellipse)
        }
        "path" => {
            let text = node.attribute("d").unwrap_or("");
            let path = BezPath::from_svg(text).map_err(|error| SvgError::Syntax {
                line: line_of(node),
                what: format!("the attribute d of <path> cannot be read: {error}"),
            })?;
            Some(path).filter(|path| !path.elements().is_empty())
        }
        _ => None,
    })
}

fn points(node: &Node) -> Result<Option<BezPath>, SvgError> {
    let text = node.attribute("points").unwrap_or("");
    let mut path = BezPath::new();
    for (x, y) in PointsParser::from(text) {
        match path.elements().is_empty() {
            true => path.move_to((x, y)),
            false => path.line_to((x, y)),
        }
    }
    let words = text.split([',', ' ', '\t', '\n', '\r']);
    let numbers = words.filter(|word| !word.is_empty());
    // The parser stops at the first word that is not a number. Numbers written without spaces make
    // fewer words than numbers.
    if numbers.count() > 2 * path.elements().len() {
        return Err(wrong(node, "points", text, "pairs of numbers"));
    }
    Ok(Some(path).filter(|path| path.elements().len() > 1))
}

/// A radius that gives a bounded number of curves.
fn radius(node: &Node, name: &'static str, flatness: f64) -> Result<f64, SvgError> {
    let radius = length(node, name)?;
    if radius / flatness > FINEST {
        let found = node.attribute(name).unwrap_or("");
        return Err(wrong(node, name, found, "a radius within a building"));
    }
    Ok(radius)
}

/// A length in the units of the drawing, 0 if absent.
pub(super) fn length(node: &Node, name: &'static str) -> Result<f64, SvgError> {
    let Some(text) = node.attribute(name) else {
        return Ok(0.0);
    };
    let expected = "a finite length in units of the drawing, px, in, cm, mm, pt or pc";
    let wrong = || wrong(node, name, text, expected);
    let Length { number, unit } = text.trim().parse().map_err(|_| wrong())?;
    // CSS has 96 px to the inch.
    let factor = match unit {
        LengthUnit::None | LengthUnit::Px => 1.0,
        LengthUnit::In => 96.0,
        LengthUnit::Cm => 96.0 / 2.54,
        LengthUnit::Mm => 96.0 / 25.4,
        LengthUnit::Pt => 96.0 / 72.0,
        LengthUnit::Pc => 16.0,
        LengthUnit::Em | LengthUnit::Ex | LengthUnit::Percent => return Err(wrong()),
    };
    Some(number * factor)
        .filter(|n| n.is_finite())
        .ok_or_else(wrong)
}
