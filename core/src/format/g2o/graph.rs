//! From a file's pose graph to one that can be optimised, and back.

use std::collections::BTreeMap;

use nalgebra::{Point2, Vector3};

use super::{G2oEdge, G2oError, G2oGraph, G2oVertex};
use crate::estimation::{Edge, PoseGraph};
use crate::geom::Pose2;

impl G2oGraph {
    /// The graph to be optimised. Its first pose, which stays where it is, is the vertex that the
    /// file fixes, by default the file's first; it changes places with vertex 0. No edge gets a
    /// robust kernel.
    ///
    /// # Errors   [`G2oError::ManyFixed`]; and edges that name missing vertices, which no graph
    /// read from a file has.
    pub fn to_pose_graph(&self) -> Result<PoseGraph, G2oError> {
        let anchor = self.anchor()?;
        let mut order: Vec<usize> = (0..self.vertices.len()).collect();
        order.swap(0, anchor);
        let mut graph = PoseGraph::default();
        for &index in &order {
            let pose = self.vertices[index].pose;
            graph.add_pose(Pose2::new(pose.x, pose.y, pose.z));
        }
        let mut places: Vec<(u64, usize)> = (order.iter().enumerate())
            .map(|(place, &index)| (self.vertices[index].id, place))
            .collect();
        places.sort_unstable();
        let place = |id: u64| {
            let at = places.binary_search_by_key(&id, |&(id, _)| id);
            at.map(|at| places[at].1)
                .map_err(|_| G2oError::NoVertex { line: 0, id })
        };
        for edge in &self.edges {
            let z = edge.motion;
            graph.add_edge(Edge {
                from: place(edge.from)?,
                to: place(edge.to)?,
                motion: Pose2::new(z.x, z.y, z.z),
                information: edge.information,
                cauchy: None,
            });
        }
        Ok(graph)
    }

    /// Takes over the poses of the graph that [`Self::to_pose_graph`] made from this one.
    ///
    /// # Errors   [`G2oError::ManyFixed`].
    pub fn set_poses(&mut self, graph: &PoseGraph) -> Result<(), G2oError> {
        let anchor = self.anchor()?;
        let mut poses: Vec<Vector3<f64>> = graph.poses().iter().map(numbers).collect();
        if anchor < poses.len() {
            poses.swap(0, anchor);
        }
        for (vertex, pose) in self.vertices.iter_mut().zip(poses) {
            vertex.pose = pose;
        }
        Ok(())
    }

    /// For each edge the positions of its two vertices, m.
    pub fn edge_ends(&self) -> impl Iterator<Item = [Point2<f64>; 2]> {
        let place = |vertex: &G2oVertex| Point2::new(vertex.pose.x, vertex.pose.y);
        let places: BTreeMap<u64, Point2<f64>> = (self.vertices.iter())
            .map(|vertex| (vertex.id, place(vertex)))
            .collect();
        let edges = self.edges.iter();
        edges.filter_map(move |edge| Some([*places.get(&edge.from)?, *places.get(&edge.to)?]))
    }

    /// Index of the vertex that stays where it is.
    fn anchor(&self) -> Result<usize, G2oError> {
        match self.fixed.len() {
            0 | 1 => {}
            many => return Err(G2oError::ManyFixed(many)),
        }
        if self.vertices.is_empty() {
            let left_out = self.left_out.clone();
            return Err(G2oError::Empty { left_out });
        }
        let mut vertices = self.vertices.iter();
        let fixed = vertices.position(|vertex| self.fixed.contains(&vertex.id));
        Ok(fixed.unwrap_or(0))
    }
}

impl From<&PoseGraph> for G2oGraph {
    /// Vertices have the numbers of the poses, and the first one is fixed. The format cannot
    /// express the robust kernel of an edge.
    fn from(graph: &PoseGraph) -> Self {
        let vertices = (0..).zip(graph.poses());
        let edge = |edge: &Edge| G2oEdge {
            from: edge.from as u64,
            to: edge.to as u64,
            motion: numbers(&edge.motion),
            information: edge.information,
        };
        Self {
            vertices: vertices
                .map(|(id, pose)| G2oVertex {
                    id,
                    pose: numbers(pose),
                })
                .collect(),
            edges: graph.edges().iter().map(edge).collect(),
            fixed: graph.poses().first().map(|_| 0).into_iter().collect(),
            left_out: Default::default(),
        }
    }
}

fn numbers(pose: &Pose2) -> Vector3<f64> {
    Vector3::new(pose.x(), pose.y(), pose.heading())
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;

    const TEXT: &str = "VERTEX_SE2 3 0 0 0\nVERTEX_SE2 5 1 0.5 0.1\nVERTEX_SE2 9 2 0 0\nFIX 9\n\
        EDGE_SE2 3 5 1 0 0 1 0 0 1 0 1\nEDGE_SE2 9 5 -1 0 0 2 0 0 2 0 2\n";

    #[test]
    fn the_fixed_vertex_stays_and_names_are_kept() {
        let mut file = parse(TEXT.as_bytes()).unwrap();
        let mut graph = file.to_pose_graph().unwrap();
        assert_eq!(graph.poses()[0], Pose2::new(2.0, 0.0, 0.0));
        assert!(graph.optimize(20) && graph.chi2() < 1e-12);
        file.set_poses(&graph).unwrap();
        let ends: Vec<_> = file.edge_ends().collect();
        let [a, b, c] = [0, 1, 2].map(|i: usize| file.vertices[i].pose.xy().into());
        assert_eq!(ends, [[a, b], [c, b]]);
        let ids: Vec<_> = file.vertices.iter().map(|vertex| vertex.id).collect();
        assert_eq!(ids, [3, 5, 9]);
        for (vertex, x) in file.vertices.iter().zip([0.0, 1.0, 2.0]) {
            assert!(
                (vertex.pose - Vector3::new(x, 0.0, 0.0)).amax() < 1e-6,
                "{vertex:?}"
            );
        }
    }

    #[test]
    fn a_graph_comes_back_from_its_file() {
        let graph = parse(TEXT.as_bytes()).unwrap().to_pose_graph().unwrap();
        let back = G2oGraph::from(&graph).to_pose_graph().unwrap();
        assert_eq!(graph.edges(), back.edges());
        // A heading goes through its sine and cosine.
        for (pose, back) in graph.poses().iter().zip(back.poses()) {
            assert!(pose.minus(back).amax() < 1e-15);
        }
    }

    #[test]
    fn two_fixed_vertices_are_refused() {
        let text = TEXT.replace("FIX 9", "FIX 9 3");
        let error = parse(text.as_bytes()).unwrap().to_pose_graph().unwrap_err();
        assert_eq!(error, G2oError::ManyFixed(2));
    }
}
