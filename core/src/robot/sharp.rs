//! Sharp's infra-red rangers: from range to volts.
//!
//! In: the true range. Out: the output voltage, without noise. The inverse is
//! [`super::Characteristic`], which is fitted to the pairs of the data sheet and not to this model.
//!
//! Source: the specification, "Sensors": GP2Y0A21 V = 26.54/(d + 2) + 0.085 with d in cm, 3.2 V at
//! its peak; GP2Y0A02 by pairs, linear in 1/d between them. Closer than the peak, the volts fall to
//! 0 at the lens.

use super::CalibrationPair;

/// Pairs of the GP2Y0A02: range in cm, volts.
#[rustfmt::skip]
const LONG: [(f64, f64); 15] = [
    (15.0, 2.75), (20.0, 2.51), (30.0, 1.99), (40.0, 1.52), (50.0, 1.25),
    (60.0, 1.04), (70.0, 0.87), (80.0, 0.79), (90.0, 0.74), (100.0, 0.69),
    (110.0, 0.60), (120.0, 0.55), (130.0, 0.50), (140.0, 0.47), (150.0, 0.45),
];
/// Pairs of the GP2Y0A21: range in cm, volts.
#[rustfmt::skip]
const SHORT: [(f64, f64); 8] = [
    (10.0, 2.28), (20.0, 1.30), (30.0, 0.90), (40.0, 0.75),
    (50.0, 0.60), (60.0, 0.50), (70.0, 0.45), (80.0, 0.40),
];
/// Highest volts of the GP2Y0A21.
const SHORT_PEAK: f64 = 3.2;

/// The types of ranger.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sharp {
    /// GP2Y0A02, 0.2 to 1.5 m.
    #[default]
    Long,
    /// GP2Y0A21, 0.1 to 0.8 m.
    Short,
}

impl Sharp {
    /// All of them, with their names in settings and for people.
    pub const ALL: [(&'static str, Self, &'static str); 2] = [
        ("gp2y0a02", Self::Long, "GP2Y0A02, 0.2 to 1.5 m"),
        ("gp2y0a21", Self::Short, "GP2Y0A21, 0.1 to 0.8 m"),
    ];

    /// The pairs of the data sheet, by rising range.
    #[must_use]
    pub fn data_sheet(self) -> Vec<CalibrationPair> {
        let pairs: &[_] = match self {
            Self::Long => &LONG,
            Self::Short => &SHORT,
        };
        let pair = |&(range, volts): &(f64, f64)| CalibrationPair {
            range: 0.01 * range,
            volts,
        };
        pairs.iter().map(pair).collect()
    }

    /// Range at which the volts are highest, m; what is nearer looks farther away.
    #[must_use]
    pub fn peak(self) -> f64 {
        match self {
            Self::Long => 0.01 * LONG[0].0,
            Self::Short => 0.01 * (26.54 / (SHORT_PEAK - 0.085) - 2.0),
        }
    }

    /// Volts for an object at `range` (m), infinite if there is none.
    #[must_use]
    pub fn volts_at(self, range: f64) -> f64 {
        let peak = self.peak();
        if range < peak {
            return self.beyond_peak(peak) * (range / peak).max(0.0);
        }
        self.beyond_peak(range)
    }

    fn beyond_peak(self, range: f64) -> f64 {
        let centimetres = 100.0 * range;
        match self {
            Self::Short => 26.54 / (centimetres + 2.0) + 0.085,
            Self::Long => between_pairs(1.0 / centimetres),
        }
    }
}

/// Volts of the GP2Y0A02, linear in 1/d; the last stretch continues beyond the last pair.
fn between_pairs(per_centimetre: f64) -> f64 {
    let stretches = LONG.windows(2).filter_map(|w| w.first().zip(w.get(1)));
    let mut volts = LONG[0].1;
    for (near, far) in stretches {
        let (from, to) = (1.0 / near.0, 1.0 / far.0);
        volts = far.1 + (near.1 - far.1) * (per_centimetre - to) / (from - to);
        if per_centimetre >= to {
            return volts;
        }
    }
    volts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volts_are_those_of_the_data_sheet() {
        for pair in Sharp::Long.data_sheet() {
            let volts = Sharp::Long.volts_at(pair.range);
            assert!((volts - pair.volts).abs() < 1e-9, "{pair:?}: {volts}");
        }
        // The closed form and the pairs of the short type come from two sources; they agree to 6 %,
        // or 4 cm at 0.8 m.
        for pair in Sharp::Short.data_sheet() {
            let volts = Sharp::Short.volts_at(pair.range);
            assert!((volts / pair.volts - 1.0).abs() < 0.13, "{pair:?}: {volts}");
        }
    }

    #[test]
    fn volts_rise_to_the_peak_and_fall_from_there() {
        for sharp in [Sharp::Long, Sharp::Short] {
            let volts = |millimetres: i32| sharp.volts_at(1e-3 * f64::from(millimetres));
            let peak = (1e3 * sharp.peak()).round() as i32;
            assert!((1..peak).all(|mm| volts(mm) > volts(mm - 1)));
            assert!((peak + 1..3000).all(|mm| volts(mm) < volts(mm - 1)));
            assert!(sharp.volts_at(f64::INFINITY) > 0.0);
            assert!(sharp.volts_at(f64::INFINITY) < sharp.volts_at(5.0));
            assert_eq!(sharp.volts_at(0.0), 0.0);
        }
        assert!((Sharp::Short.peak() - 0.065).abs() < 0.001);
        assert!((Sharp::Short.volts_at(Sharp::Short.peak()) - 3.2).abs() < 1e-9);
    }
}
