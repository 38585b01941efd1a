//! Optimises a file's pose graph, starting from the file's own poses.

use super::{G2oError, G2oGraph};

/// Graphs that have not converged by then never will.
const MOST_ITERATIONS: usize = 100;

/// The result of the optimisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solved {
    /// χ² of all edges, at the poses of the file.
    pub chi2_before: f64,
    /// χ² at the optimised poses.
    pub chi2_after: f64,
    /// Whether the last step was negligible.
    pub converged: bool,
    /// Number of linear systems solved.
    pub iterations: usize,
}

impl G2oGraph {
    /// Moves the poses to the minimum of the cost; the cost never rises.
    ///
    /// # Errors   [`G2oError`], as of [`Self::to_pose_graph`].
    pub fn solve(&mut self) -> Result<Solved, G2oError> {
        let mut graph = self.to_pose_graph()?;
        let chi2_before = graph.chi2();
        let found = graph.optimize_with_figures(MOST_ITERATIONS);
        self.set_poses(&graph)?;
        Ok(Solved {
            chi2_before,
            chi2_after: graph.chi2(),
            converged: found.converged,
            iterations: found.iterations,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;

    /// Two measurements of 1 m and 1.2 m, with information 1 and 3: the minimum lies at (1 + 3 ·
    /// 1.2) / 4 = 1.15 m, where χ² is 0.15² + 3 · 0.05² = 0.03.
    #[test]
    fn two_measurements_meet_at_their_weighted_mean() {
        let text = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 3 0 0\n\
            EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 0 1 1.2 0 0 3 0 0 3 0 3\n";
        let mut file = parse(text.as_bytes()).unwrap();
        let solved = file.solve().unwrap();
        assert!((solved.chi2_before - (4.0 + 3.0 * 1.8 * 1.8)).abs() < 1e-12);
        assert!((solved.chi2_after - 0.03).abs() < 1e-9, "{solved:?}");
        assert!(solved.converged && solved.iterations > 0);
        assert!((file.vertices[1].pose.x - 1.15).abs() < 1e-9);
        assert_eq!(file.edges.len(), 2);
    }
}
