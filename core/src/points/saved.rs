//! Points as bytes.

use super::{Beam, OrientedPoint, Points};
use crate::snapshot::snapshot;

snapshot!(OrientedPoint { position, normal });
snapshot!(Points {
    stamp,
    sensor_in_robot,
    bearing_sigma,
    beams,
});
snapshot!(Beam {
    beam_idx,
    origin_in_robot,
    end_in_robot,
    range,
    sigma,
    is_hit,
    quality,
    age,
});
