//! What the robot touched, and whether it drove there or was walked into.

use nalgebra::Vector2;

use crate::geom::Length;

/// Below this distance per step the robot counts as standing, m: half a centimetre a second.
const STANDING: f64 = 2.5e-5;

/// How often a robot's body began to touch something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Contacts {
    /// It drove into something static.
    pub walls: u32,
    /// It drove into a mover.
    pub drove_into_mover: u32,
    /// A mover walked into it while it stood, or moved away from them.
    pub mover_walked_in: u32,
}

/// What the body touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    /// From the middle of the body to the point of contact, world frame, m.
    pub(super) to: Vector2<f64>,
    /// From the body into what it touches, world frame; of any length.
    pub(super) into: Vector2<f64>,
    /// Whether it is a mover.
    pub(super) is_mover: bool,
}

impl Contacts {
    /// The total.
    #[must_use]
    pub fn total(&self) -> u32 {
        let people = self.drove_into_mover.saturating_add(self.mover_walked_in);
        self.walls.saturating_add(people)
    }

    /// Counts a touch that begins in a step in which the body's middle moved by `way` (world frame,
    /// m) and it turned by `turn`, rad: a corner may hit somebody while the middle stands.
    pub(super) fn count(&mut self, touch: &Touch, (way, turn): (Vector2<f64>, f64)) {
        let way = way + Vector2::new(-touch.to.y, touch.to.x) * turn;
        let drove = way.dot(&touch.into) > STANDING * touch.into.length();
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
            into: Vector2::new(0.11, 0.0),
            is_mover,
        };
        let mut contacts = Contacts::default();
        contacts.count(&ahead(true), (Vector2::new(1e-3, 0.0), 0.0));
        contacts.count(&ahead(true), (Vector2::zeros(), 0.1));
        contacts.count(&ahead(true), (Vector2::new(-1e-3, 0.0), 0.0));
        contacts.count(&ahead(false), (Vector2::zeros(), 0.0));
        let expect = Contacts {
            walls: 1,
            drove_into_mover: 1,
            mover_walked_in: 2,
        };
        assert_eq!((contacts, contacts.total()), (expect, 4));
    }

    #[test]
    fn a_corner_that_turns_into_somebody_drove_into_them() {
        // The corner ahead and to the left, with somebody to the left of it.
        let corner = Touch {
            to: Vector2::new(0.25, 0.15),
            into: Vector2::new(0.0, 1.0),
            is_mover: true,
        };
        let mut contacts = Contacts::default();
        contacts.count(&corner, (Vector2::zeros(), 0.01));
        contacts.count(&corner, (Vector2::zeros(), -0.01));
        contacts.count(&corner, (Vector2::new(0.0, -0.01), 0.01));
        assert_eq!(
            (contacts.drove_into_mover, contacts.mover_walked_in),
            (1, 2)
        );
    }
}
