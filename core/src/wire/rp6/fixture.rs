//! The hello of an RP6 in tests.

use super::{Hello, PROTOCOL, ResetCause};

/// A robot with four rangers, 90° apart, that answers the greeting with this nonce.
pub(crate) fn hello(nonce: u8) -> Hello {
    Hello {
        protocol: PROTOCOL,
        firmware: [1, 0],
        nonce,
        cause: ResetCause::PowerOn,
        capabilities: 1,
        length_mm: 189,
        width_mm: 113,
        track_width_mm: 197,
        count_nm: 240_000,
        max_speed_mm_s: 300,
        ranger_angles_mrad: vec![0, 1571, 3142, -1571],
    }
}
