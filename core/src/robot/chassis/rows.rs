//! The rows of the constraint matrices, one wheel at a time.

use nalgebra::{DMatrix, RowVector3, Vector3};

use super::{ChassisError, Constraint, Wheel, WheelKind, WheelMotion};
use crate::geom::sin_cos;

/// Wheel and constraint of each row of the stacked matrix: all rolling rows (J1), then all sliding rows (C1).
pub(super) fn owners(wheels: &[Wheel]) -> Vec<(usize, Constraint)> {
    let numbers_with = |constraint: Constraint| {
        let numbered = wheels.iter().enumerate();
        numbered
            .filter(move |(_, wheel)| constraint == Constraint::Rolling || !wheel.slides())
            .map(move |(number, _)| (number, constraint))
    };
    // A free caster's rolling says nothing that could be measured without its steering: it has no row at all.
    numbers_with(Constraint::Rolling)
        .filter(|&(number, _)| !matches!(wheels[number].kind, WheelKind::Caster { .. }))
        .chain(numbers_with(Constraint::Sliding))
        .collect()
}

/// The stacked matrix, a row for each owner.
pub(super) fn stack(wheels: &[Wheel], owners: &[(usize, Constraint)]) -> DMatrix<f64> {
    let mut stacked = DMatrix::zeros(owners.len(), 3);
    for (row, &(wheel, constraint)) in owners.iter().enumerate() {
        let wheel = &wheels[wheel];
        stacked.set_row(
            row,
            &match constraint {
                Constraint::Rolling => wheel.rolling(),
                Constraint::Sliding => wheel.sliding(),
            },
        );
    }
    stacked
}

impl Wheel {
    pub(super) fn check(&self, number: usize) -> Result<(), ChassisError> {
        let error = |field, value, expected| {
            Err(ChassisError::Wheel {
                wheel: number,
                field,
                value,
                expected,
            })
        };
        let (name, of_kind) = match self.kind {
            WheelKind::Fixed | WheelKind::Steered => ("kind", 0.0),
            WheelKind::Caster { offset } => ("offset", offset),
            WheelKind::Swedish { rollers } => ("rollers", rollers),
        };
        let finite = [
            ("bearing", self.bearing),
            ("orientation", self.orientation),
            (name, of_kind),
        ];
        if let Some(&(field, value)) = finite.iter().find(|(_, value)| !value.is_finite()) {
            return error(field, value, "a finite number");
        }
        if !(self.distance >= 0.0 && self.distance.is_finite()) {
            return error("distance", self.distance, "at least 0 and finite");
        }
        if !(self.radius > 0.0 && self.radius.is_finite()) {
            return error("radius", self.radius, "more than 0 and finite");
        }
        match self.kind {
            WheelKind::Caster { offset } if offset <= 0.0 => error(
                "offset",
                offset,
                "more than 0: without it a caster does not follow",
            ),
            // cos γ = 0: the rollers roll in the wheel's own direction, and turning it moves nothing.
            WheelKind::Swedish { rollers } if libm::cos(rollers).abs() < 1e-9 => {
                error("rollers", rollers, "an angle that is not a right one")
            }
            _ => Ok(()),
        }
    }

    /// Whether it lets the body move along its axle (by its rollers, or by turning about its joint).
    pub(super) fn slides(&self) -> bool {
        matches!(
            self.kind,
            WheelKind::Caster { .. } | WheelKind::Swedish { .. }
        )
    }

    /// Speed at the ground, m/s, for a radian a second: r, or r cos γ where rollers take a part.
    pub(super) fn rim_speed(&self) -> f64 {
        match self.kind {
            WheelKind::Swedish { rollers } => self.radius * libm::cos(rollers),
            _ => self.radius,
        }
    }

    /// Row of J1: [sin(α+β), -cos(α+β), -l cos β], with β + γ for β on a Swedish wheel. TDK 2016 eq. (2.3).
    pub(super) fn rolling(&self) -> RowVector3<f64> {
        let along = match self.kind {
            WheelKind::Swedish { rollers } => self.orientation + rollers,
            _ => self.orientation,
        };
        let (sin, cos) = sin_cos(self.bearing + along);
        RowVector3::new(sin, -cos, -self.distance * libm::cos(along))
    }

    /// Row of C1: [cos(α+β), sin(α+β), l sin β]. TDK 2016 eq. (2.4).
    pub(super) fn sliding(&self) -> RowVector3<f64> {
        let (sin, cos) = sin_cos(self.bearing + self.orientation);
        RowVector3::new(cos, sin, self.distance * libm::sin(self.orientation))
    }

    /// What it does when the body moves by `twist`.
    pub(super) fn under(&self, twist: &Vector3<f64>) -> WheelMotion {
        let (rolling, sideways) = ((self.rolling() * twist).x, (self.sliding() * twist).x);
        let (steering, skid) = match self.kind {
            // [cos(α+β), sin(α+β), d + l sin β] ξ + d β' = 0: the joint gives way. Siegwart & Nourbakhsh eq. (3.15).
            WheelKind::Caster { offset } => (-(sideways + offset * twist.z) / offset, 0.0),
            WheelKind::Swedish { .. } => (0.0, 0.0),
            WheelKind::Fixed | WheelKind::Steered => (0.0, sideways),
        };
        WheelMotion {
            speed: rolling / self.rim_speed(),
            steering,
            skid,
        }
    }
}
