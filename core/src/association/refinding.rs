//! How well sightings are found again, when the truth is known.
//!
//! Source: Pilch 2016 §1.2.3 for the task. The ratios are those of any detector; with the gate as
//! threshold they form a receiver operating characteristic (Fawcett 2006, "An introduction to ROC
//! analysis").

/// How often the decisions about sightings were right.
///
/// A sighting has a partner if what it shows is already known. It is found if it was matched to
/// something known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RefindingCounts {
    /// With a partner, and matched to it.
    pub right: usize,
    /// Matched to something that they are not, with or without a partner.
    pub wrong: usize,
    /// With a partner.
    pub with_partner: usize,
    /// Without a partner.
    pub without: usize,
    /// Without a partner, but matched to something all the same.
    pub taken: usize,
}

impl RefindingCounts {
    /// Counts a sighting; if it was found, `found` says whether rightly.
    pub fn count(&mut self, has_partner: bool, found: Option<bool>) {
        let is_right = found == Some(true);
        self.right += usize::from(is_right);
        self.wrong += usize::from(found == Some(false));
        self.with_partner += usize::from(has_partner);
        self.without += usize::from(!has_partner);
        self.taken += usize::from(!has_partner && found.is_some());
    }

    /// True positive rate: of those with a partner, the part matched to it. NaN without any.
    #[must_use]
    pub fn tpr(&self) -> f64 {
        ratio(self.right, self.with_partner)
    }

    /// False positive rate: of those without a partner, the part matched to something. NaN without
    /// any.
    #[must_use]
    pub fn fpr(&self) -> f64 {
        ratio(self.taken, self.without)
    }

    /// Positive predictive value: of those found, the part matched rightly. NaN without any.
    #[must_use]
    pub fn ppv(&self) -> f64 {
        ratio(self.right, self.right + self.wrong)
    }

    /// Accuracy: the part of all sightings decided rightly. NaN without any.
    #[must_use]
    pub fn acc(&self) -> f64 {
        let rightly = self.right + (self.without - self.taken);
        ratio(rightly, self.with_partner + self.without)
    }
}

fn ratio(part: usize, whole: usize) -> f64 {
    part as f64 / whole as f64
}

/// The same for several gates at once: what would have been found with each.
#[derive(Clone, Debug, PartialEq)]
pub struct RefindingCurve {
    /// Gates, d², in rising order, with the counts at each.
    points: Vec<(f64, RefindingCounts)>,
}

impl RefindingCurve {
    /// Nothing counted yet.
    #[must_use]
    pub fn new(gates: impl IntoIterator<Item = f64>) -> Self {
        let points = gates.into_iter().map(|gate| (gate, Default::default()));
        Self {
            points: points.collect(),
        }
    }

    /// Counts a sighting by the d² of its nearest candidate, and whether that is the right one.
    pub fn count(&mut self, has_partner: bool, nearest: Option<(f64, bool)>) {
        for (gate, counts) in &mut self.points {
            let found = nearest.filter(|(d2, _)| d2 <= gate);
            counts.count(has_partner, found.map(|(_, is_right)| is_right));
        }
    }

    /// Each gate with its counts, in order.
    #[must_use]
    pub fn points(&self) -> &[(f64, RefindingCounts)] {
        &self.points
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn ratios_are_those_of_the_confusion_table() {
        let mut counts = RefindingCounts::default();
        assert!(counts.tpr().is_nan() && counts.ppv().is_nan());
        // Of six with a partner, four are found, one is matched to something else, one is missed;
        // of five without, two are matched to something.
        let seen = [
            (true, Some(true), 4),
            (true, Some(false), 1),
            (true, None, 1),
            (false, Some(false), 2),
            (false, None, 3),
        ];
        for (has_partner, found, times) in seen {
            for _ in 0..times {
                counts.count(has_partner, found);
            }
        }
        assert_eq!((counts.tpr(), counts.fpr()), (4.0 / 6.0, 2.0 / 5.0));
        assert_eq!((counts.ppv(), counts.acc()), (4.0 / 7.0, 7.0 / 11.0));
    }

    proptest! {
        /// Compared with brute force over the gates; both rates grow with the gate.
        #[test]
        fn curve_is_what_each_gate_alone_would_have_counted(
            seen in prop::collection::vec((any::<bool>(), prop::option::of((0.0..50.0_f64, any::<bool>()))), 0..60),
        ) {
            let gates = [0.5, 3.0, 9.21, 30.0];
            let mut curve = RefindingCurve::new(gates);
            for (has_partner, nearest) in &seen {
                curve.count(*has_partner, *nearest);
            }
            for (gate, counts) in curve.points() {
                let passes = |(d2, _): &(f64, bool)| d2 <= gate;
                let with = seen.iter().filter(|s| s.0).count();
                let right = seen.iter().filter(|s| s.1.as_ref().is_some_and(|n| passes(n) && n.1)).count();
                let taken = seen.iter().filter(|s| !s.0 && s.1.as_ref().is_some_and(passes)).count();
                prop_assert_eq!((counts.with_partner, counts.right, counts.taken), (with, right, taken));
            }
            let of = |i: usize| curve.points()[i].1;
            for i in 1..gates.len() {
                prop_assert!(of(i).right >= of(i - 1).right && of(i).taken >= of(i - 1).taken);
            }
        }
    }
}
