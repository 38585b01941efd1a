//! The settings. Accessors are plain functions, so that the table is a constant and each entry stands in one place.

mod body;
mod driving;
mod estimation;
mod near;
mod odometry;
mod perception;
mod sensor;

use super::Setting;

/// All settings, those of a group together.
pub fn table() -> impl Iterator<Item = &'static Setting> + Clone {
    let parts = [
        sensor::SENSOR,
        body::BODY,
        odometry::ODOMETRY,
        perception::PERCEPTION,
        near::NEAR,
        estimation::ESTIMATION,
        driving::DRIVING,
    ];
    parts.into_iter().flatten()
}
