//! Optimises a pose graph of another program (`.g2o`), for the page.

use serde::{Deserialize, Serialize};
use slamlab_core::format::g2o::{self, G2oGraph};
use tsify::Tsify;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Float32Array, Typed, Uint8Array, WebError, typed};

/// A pose graph, as in its file and optimised.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct SolvedGraph {
    /// Number of poses.
    pub poses: usize,
    /// Number of measured motions.
    pub edges: usize,
    /// χ² of all edges, at the file's own poses.
    pub chi2_before: f64,
    /// χ² at the optimised poses.
    pub chi2_after: f64,
    /// Whether the last step was negligible.
    pub converged: bool,
    /// Number of linear systems solved.
    pub iterations: usize,
    /// What was left out of the file, in words.
    pub left_out: Vec<String>,
    /// x1 y1 x2 y2 of each edge, m, at the file's own poses.
    pub before: Float32Array,
    /// The same at the optimised poses.
    pub after: Float32Array,
    /// The optimised graph as a file.
    #[tsify(type = "Uint8Array<ArrayBuffer>")]
    pub file: Uint8Array,
}

/// Reads a pose graph and optimises it from its own poses.
///
/// # Errors    A sentence on what is wrong with it, and where.
#[wasm_bindgen]
pub fn solve_graph(bytes: &[u8]) -> Typed<SolvedGraph> {
    let mut graph = g2o::parse(bytes).map_err(WebError::from)?;
    let before = ends(&graph);
    let solved = graph.solve().map_err(WebError::from)?;
    let left_out = graph.left_out.iter();
    typed(&SolvedGraph {
        poses: graph.vertices.len(),
        edges: graph.edges.len(),
        chi2_before: solved.chi2_before,
        chi2_after: solved.chi2_after,
        converged: solved.converged,
        iterations: solved.iterations,
        left_out: left_out
            .map(|(tag, lines)| format!("{lines} of {tag}"))
            .collect(),
        before,
        after: ends(&graph),
        file: g2o::write(&graph).into_bytes().into(),
    })
}

/// x1 y1 x2 y2 of each edge.
fn ends(graph: &G2oGraph) -> Float32Array {
    let ends = graph.edge_ends();
    ends.flat_map(|[from, to]| [from.x, from.y, to.x, to.y].map(|n| n as f32))
        .collect()
}
