//! Polynomials of the fifth degree: value, derivative, roots within an interval.

/// Degree of the characteristic.
pub(super) const DEGREE: usize = 5;
/// Bisections that shrink a bracket from the length of the interval to the last bit.
const HALVINGS: usize = 60;

/// Coefficients, the constant first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Polynomial(pub(super) [f64; DEGREE + 1]);

impl Polynomial {
    /// Value at `x`, by Horner's rule.
    pub(super) fn at(&self, x: f64) -> f64 {
        self.0.iter().rev().fold(0.0, |sum, c| sum * x + c)
    }

    pub(super) fn derivative(&self) -> Self {
        let mut slopes = [0.0; DEGREE + 1];
        for (power, (slope, c)) in slopes.iter_mut().zip(self.0.iter().skip(1)).enumerate() {
            *slope = c * (power + 1) as f64;
        }
        Self(slopes)
    }

    /// The places between `low` and `high` where it changes its sign, in ascending order.
    ///
    /// Between two roots of its derivative a polynomial is monotonic, so it has at most one root
    /// there, found by bisection.
    pub(super) fn roots_within(&self, low: f64, high: f64) -> Vec<f64> {
        if self.0.iter().skip(1).all(|c| *c == 0.0) {
            return Vec::new();
        }
        let mut borders = vec![low];
        borders.extend(self.derivative().roots_within(low, high));
        borders.push(high);
        let stretches = borders.iter().zip(borders.iter().skip(1));
        let holds_one = |(a, b): &(&f64, &f64)| (self.at(**a) < 0.0) != (self.at(**b) < 0.0);
        let root = |(a, b): (&f64, &f64)| self.root_between(*a, *b);
        stretches.filter(holds_one).map(root).collect()
    }

    fn root_between(&self, mut low: f64, mut high: f64) -> f64 {
        let is_negative = self.at(low) < 0.0;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if (self.at(middle) < 0.0) == is_negative {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_those_it_was_made_of() {
        // (x + 0.8)(x + 0.1)(x - 0.3)(x - 0.9)(x - 2) multiplied out.
        let mut coefficients = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        for root in [-0.8, -0.1, 0.3, 0.9, 2.0] {
            let mut next = [0.0; 6];
            for (power, c) in coefficients.iter().enumerate() {
                next[power] -= root * c;
                if power < 5 {
                    next[power + 1] += c;
                }
            }
            coefficients = next;
        }
        let polynomial = Polynomial(coefficients);
        let roots = polynomial.roots_within(-1.0, 1.0);
        assert_eq!(roots.len(), 4);
        for (root, expect) in roots.iter().zip([-0.8, -0.1, 0.3, 0.9]) {
            assert!((root - expect).abs() < 1e-12, "{root}");
        }
        assert!(
            Polynomial([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
                .roots_within(-1.0, 1.0)
                .is_empty()
        );
    }

    #[test]
    fn derivative_is_that_of_central_differences() {
        let polynomial = Polynomial([0.3, -1.2, 0.7, 2.0, -0.4, 0.9]);
        for x in [-1.0, -0.3, 0.0, 0.6, 1.0] {
            let numeric = (polynomial.at(x + 1e-6) - polynomial.at(x - 1e-6)) / 2e-6;
            assert!((polynomial.derivative().at(x) - numeric).abs() < 1e-8);
        }
    }
}
