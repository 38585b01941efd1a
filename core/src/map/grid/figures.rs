//! In: a place. Out: what the map knows of the cell there, and how one more observation would
//! change it.
//!
//! Celej §2 sums up evidence as l ← l + l_hit or l + l_miss, kept within ± a limit, and returns the
//! probability as p = 1 - 1/(1 + eˡ) (erratum to Celej eq. (3)). The counts of hits and misses are
//! not kept, only the sum.

use nalgebra::Point2;

use super::Grid;
use crate::map::{CellIndex, CellState, Layer, Layers};

/// What is known of one cell. Log-odds are natural: l = ln(p / (1 - p)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellFigures {
    /// The cell.
    pub cell: CellIndex,
    /// Its side, m.
    pub resolution: f64,
    /// Log-odds in the map that is shown; 0 if unknown.
    pub log_odds: f64,
    /// Probability that it is occupied.
    pub probability: f64,
    /// The believed state.
    pub state: CellState,
    /// Log-odds from the main sensor alone, which the pose comes from.
    pub of_sensor: f64,
    /// Log-odds from the sonars beside it alone, if there are any.
    pub of_sonars: Option<f64>,
    /// Log-odds added by a scan with a beam that ended in it.
    pub hit: f64,
    /// Log-odds added by a scan whose beams went through it and did not end there.
    pub miss: f64,
    /// Limit of the log-odds of one sensor, to either side.
    pub limit: f64,
    /// Probability after one more hit.
    pub after_hit: f64,
    /// Probability after one more miss.
    pub after_miss: f64,
}

impl Layers<'_> {
    /// What is known of the cell that holds a point, map frame, m, in the map that is shown. One
    /// more observation is computed for the sensor that is shown; in the map of both, for the main
    /// sensor.
    ///
    /// # Source   Celej §2, and the erratum to eq. (3).
    #[must_use]
    pub fn figures(&self, at: Point2<f64>) -> CellFigures {
        let cell = self.main.cell_at(at);
        let of = |grid: &Grid| f64::from(grid.log_odds(cell));
        let of_sensor = of(self.main);
        let of_sonars = self.sonar.map(of);
        // The grid of the sensor that observes again, its log-odds so far, and those of the other
        // sensor.
        let (grid, own, other) = match (self.shown, self.sonar, of_sonars) {
            (Layer::Sonar, Some(sonar), Some(own)) => (sonar, own, 0.0),
            (Layer::Fused, _, Some(other)) => (self.main, of_sensor, other),
            _ => (self.main, of_sensor, 0.0),
        };
        let log_odds = own + other;
        let [hit, miss, limit] = [grid.odds.hit, grid.odds.miss, grid.odds.limit].map(f64::from);
        let after = |look: f64| probability((own + look).clamp(-limit, limit) + other);
        CellFigures {
            cell,
            resolution: grid.resolution(),
            log_odds,
            probability: probability(log_odds),
            state: grid.state_of(log_odds as f32),
            of_sensor,
            of_sonars,
            hit,
            miss,
            limit,
            after_hit: after(hit),
            after_miss: after(miss),
        }
    }
}

/// Erratum to Celej eq. (3).
fn probability(log_odds: f64) -> f64 {
    1.0 - 1.0 / (1.0 + libm::exp(log_odds))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose2;
    use crate::map::{Evidence, GridConfig};

    const PLACE: Point2<f64> = Point2::new(1.01, 0.01);

    /// A grid in which a beam along x ended at `PLACE` so many times, and then went through it.
    fn seen(config: GridConfig, hits: usize, misses: usize) -> Grid {
        let mut grid = Grid::new(config).unwrap();
        let way = |to: f64| vec![[Point2::new(0.01, 0.01), Point2::new(to, 0.01)]];
        for look in 0..hits + misses {
            let evidence = match look < hits {
                true => Evidence {
                    free: way(1.0),
                    hits: vec![PLACE],
                },
                false => Evidence {
                    free: way(2.0),
                    hits: vec![],
                },
            };
            grid.draw(&evidence, &Pose2::identity());
        }
        grid
    }

    fn alone(grid: &Grid) -> CellFigures {
        let layers = Layers {
            main: grid,
            sonar: None,
            shown: Layer::Main,
        };
        layers.figures(PLACE)
    }

    /// Bayes' rule with an even prior, one observation after another: on the probability itself,
    /// without log-odds.
    fn bayes(p: f64, look: f64) -> f64 {
        p * look / (p * look + (1.0 - p) * (1.0 - look))
    }

    #[test]
    fn what_one_more_look_makes_of_a_cell_is_what_it_then_makes_of_it() {
        let config = GridConfig::default();
        for (hits, misses) in [(0, 0), (1, 0), (0, 1), (2, 1), (3, 4), (1, 9), (30, 0)] {
            let now = alone(&seen(config, hits, misses));
            assert_eq!((now.cell.col, now.cell.row), (20, 0));
            let miss = alone(&seen(config, hits, misses + 1));
            assert!(
                (now.after_miss - miss.probability).abs() < 1e-6,
                "{hits} {misses}"
            );
            if misses == 0 {
                let hit = alone(&seen(config, hits + 1, 0));
                assert!((now.after_hit - hit.probability).abs() < 1e-6, "{hits}");
            }
        }
    }

    #[test]
    fn the_probability_is_that_of_bayes_rule() {
        let config = GridConfig::default();
        let expected = [config.hit, config.hit, config.miss]
            .into_iter()
            .fold(0.5, bayes);
        let found = alone(&seen(config, 2, 1));
        assert!((found.probability - expected).abs() < 1e-6, "{found:?}");
        assert!((found.log_odds - (2.0 * found.hit + found.miss)).abs() < 1e-6);
    }

    #[test]
    fn nothing_is_known_of_a_cell_that_nobody_saw() {
        let figures = alone(&seen(GridConfig::default(), 0, 0));
        assert_eq!((figures.log_odds, figures.probability), (0.0, 0.5));
        assert_eq!(figures.state, CellState::Unknown);
        let far = Layers {
            main: &seen(GridConfig::default(), 1, 0),
            sonar: None,
            shown: Layer::Fused,
        };
        for at in [f64::NAN, f64::INFINITY, -1e300] {
            assert_eq!(far.figures(Point2::new(at, at)).state, CellState::Unknown);
        }
    }

    #[test]
    fn both_sensors_add_and_one_more_look_is_that_of_the_first() {
        let config = GridConfig::default();
        let (main, sonar) = (seen(config, 1, 0), seen(config, 0, 2));
        let layers = |shown| Layers {
            main: &main,
            sonar: Some(&sonar),
            shown,
        };
        let both = layers(Layer::Fused).figures(PLACE);
        let expected = [config.hit, config.miss, config.miss]
            .into_iter()
            .fold(0.5, bayes);
        assert!((both.probability - expected).abs() < 1e-6);
        assert!((both.after_hit - bayes(expected, config.hit)).abs() < 1e-6);
        let heard = layers(Layer::Sonar).figures(PLACE);
        assert_eq!(Some(heard.log_odds), both.of_sonars);
        assert_eq!(layers(Layer::Main).figures(PLACE).log_odds, both.of_sensor);
    }
}
