//! Why a file does not make a building.

use roxmltree::Node;

use crate::format::FieldError;
use crate::sim::WorldError;

/// Why a file cannot be made into a world.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildingError {
    /// The map is too large to drive in.
    #[error("the map has {cells} cells, expected at most {most} for a building")]
    TooLarge {
        /// Its number of cells.
        cells: usize,
        /// The most that are accepted.
        most: usize,
    },
    /// There is no wall.
    #[error("there is no wall in it; expected at least one")]
    NoWalls,
    /// No place has enough room for the robot.
    #[error(
        "nowhere is room for the robot: the widest place is {widest:.2} m from the nearest wall, it needs {needed:.2} m"
    )]
    NoRoom {
        /// Distance from the wall at the widest place, m.
        widest: f64,
        /// What the robot needs, m.
        needed: f64,
    },
    /// The drawing.
    #[error(transparent)]
    Svg(#[from] SvgError),
    /// The world is invalid.
    #[error(transparent)]
    World(#[from] WorldError),
}

/// Why a drawing cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SvgError {
    /// The file is too long.
    #[error("the drawing has {bytes} bytes, expected at most {most}")]
    TooLong {
        /// Its length.
        bytes: usize,
        /// The longest that is accepted.
        most: usize,
    },
    /// Not valid XML, or not SVG.
    #[error("line {line}: {what}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// An attribute that cannot be read.
    #[error(transparent)]
    Attribute(#[from] FieldError),
    /// A scale that gives no plausible building.
    #[error(
        "the drawing is {width:.2} m x {height:.2} m at {metres_per_unit} m a unit, expected 1 to 2000 m a side; say the scale as the \
         attribute data-metres-per-unit of <svg>"
    )]
    Scale {
        /// Width, m.
        width: f64,
        /// Height, m.
        height: f64,
        /// The scale that was used.
        metres_per_unit: f64,
    },
    /// A scale that is not a positive finite number.
    #[error("a scale of {0} m a unit, expected a finite number above 0")]
    NoScale(f64),
    /// Copies within copies that multiply beyond bounds.
    #[error("more than {most} elements, copies counted")]
    TooManyCopies {
        /// The most elements that are read.
        most: usize,
    },
    /// More straight pieces than a world may have.
    #[error("more than {most} straight walls")]
    TooMany {
        /// The most that are accepted.
        most: usize,
    },
}

/// The error for an invalid attribute.
pub(super) fn wrong(node: &Node, attribute: &str, found: &str, expected: &str) -> SvgError {
    let field = format!("{attribute} of <{}>", node.tag_name().name());
    FieldError::new(line_of(node), field, found, expected).into()
}

/// The line on which an element begins.
pub(super) fn line_of(node: &Node) -> usize {
    node.document().text_pos_at(node.range().start).row as usize
}
