//! Whom and what the robot touched, and who came.

use nalgebra::Vector2;

/// Slower than this, per step, the robot stands: half a centimetre a second.
const STANDING: f64 = 2.5e-5;

/// How often a robot's body began to touch something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Contacts {
    /// It drove into something that stands still.
    pub walls: u32,
    /// It drove into somebody who walks about.
    pub drove_into_mover: u32,
    /// Somebody walked into it while it stood, or moved away from them.
    pub mover_walked_in: u32,
}

/// What the body touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    /// From the middle of the body to the touched place, world frame, m.
    pub(super) to: Vector2<f64>,
    /// Whether it is a mover.
    pub(super) is_mover: bool,
}

impl Contacts {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> u32 {
        let people = self.drove_into_mover.saturating_add(self.mover_walked_in);
        self.walls.saturating_add(people)
    }

    /// Counts a touch that begins in a step in which the body moved by `way` (world frame, m).
    pub(super) fn count(&mut self, touch: &Touch, way: Vector2<f64>) {
        let drove = way.dot(&touch.to) > STANDING * touch.to.norm();
        let counter = match (touch.is_mover, drove) {
            (false, _) => &mut self.walls,
            (true, true) => &mut self.drove_into_mover,
            (true, false) => &mut self.mover_walked_in,
        };
        *counter = counter.saturating_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_came_is_told_by_the_way_of_the_robot() {
        let ahead = |is_mover| Touch {
            to: Vector2::new(0.11, 0.0),
            is_mover,
        };
        let mut contacts = Contacts::default();
        contacts.count(&ahead(true), Vector2::new(1e-3, 0.0));
        contacts.count(&ahead(true), Vector2::zeros());
        contacts.count(&ahead(true), Vector2::new(-1e-3, 0.0));
        contacts.count(&ahead(false), Vector2::zeros());
        let expect = Contacts {
            walls: 1,
            drove_into_mover: 1,
            mover_walked_in: 2,
        };
        assert_eq!((contacts, contacts.total()), (expect, 4));
    }
}
