//! The principal directions of a few points.

use nalgebra::Vector2;

use crate::geom::Length;

/// A surface counts as a line while the scatter across it is less than this fraction of the scatter
/// along it.
pub(crate) const MAX_FLATNESS: f64 = 0.1;

/// Sums of a set of points, enough for their principal directions.
#[derive(Clone, Copy, Default)]
pub(crate) struct Scatter {
    pub(crate) count: f64,
    sum: Vector2<f64>,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Scatter {
    pub(crate) fn add(&mut self, p: Vector2<f64>) {
        self.count += 1.0;
        self.sum += p;
        self.xx += p.x * p.x;
        self.xy += p.x * p.y;
        self.yy += p.y * p.y;
    }

    pub(crate) fn mean(&self) -> Vector2<f64> {
        self.sum / self.count.max(1.0)
    }

    /// The direction across the line, if the points form one.
    pub(crate) fn normal(&self) -> Option<Vector2<f64>> {
        if self.count < 3.0 {
            return None;
        }
        let mean = self.mean();
        let xx = self.xx / self.count - mean.x * mean.x;
        let xy = self.xy / self.count - mean.x * mean.y;
        let yy = self.yy / self.count - mean.y * mean.y;
        let (half, half_trace) = (0.5 * (xx - yy), 0.5 * (xx + yy));
        let spread = (half * half + xy * xy).sqrt();
        let (across, along) = (half_trace - spread, half_trace + spread);
        if along <= 1e-8 || across > MAX_FLATNESS * along {
            return None;
        }
        // The eigenvector of the larger eigenvalue is (spread + half, xy) or (xy, spread - half):
        // take the longer.
        let tangent = if half >= 0.0 {
            Vector2::new(spread + half, xy)
        } else {
            Vector2::new(xy, spread - half)
        };
        let length = tangent.length();
        (length > 0.0).then(|| Vector2::new(-tangent.y, tangent.x) / length)
    }
}
