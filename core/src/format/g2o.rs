//! g2o text files: pose graphs, in the form that SLAM tools exchange.
//!
//! In: bytes. Out: a [`G2oGraph`], and back: text.
//!
//! ```text
//! VERTEX_SE2 id x y θ
//! FIX id..
//! EDGE_SE2 from to x y θ i11 i12 i13 i22 i23 i33
//! ```
//!
//! An edge is the motion from one vertex to another, with the upper triangle of its information
//! matrix, in the frame of the vertex it leads to. `#` starts a comment. Other tags (landmarks, 3D
//! poses, parameters) are left out and counted. Numbers are written as short as possible without
//! losing a bit when read again.
//!
//! Source: Kümmerle et al. (2011), "g2o: a general framework for graph optimization"; the file
//! format of its types `slam2d`.

mod graph;
mod solve;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use nalgebra::{Matrix3, Vector3};

use super::FieldError;
use super::field_error::{number, read, short};

pub use self::solve::Solved;

/// A pose graph as stored in a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct G2oGraph {
    /// In the order of the file.
    pub vertices: Vec<G2oVertex>,
    /// In the order of the file; each joins two of the vertices.
    pub edges: Vec<G2oEdge>,
    /// Vertices that stay where they are.
    pub fixed: BTreeSet<u64>,
    /// Lines left out, by their tag.
    pub left_out: BTreeMap<String, usize>,
}

/// A pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct G2oVertex {
    /// Its name in the file.
    pub id: u64,
    /// (x, y, θ), m and rad.
    pub pose: Vector3<f64>,
}

/// A measured motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct G2oEdge {
    /// Where it starts.
    pub from: u64,
    /// Where it ends.
    pub to: u64,
    /// (x, y, θ) of `to` in the frame of `from`, m and rad.
    pub motion: Vector3<f64>,
    /// Information matrix of the error, in the frame of the measured `to`; symmetric.
    pub information: Matrix3<f64>,
}

/// Why bytes are not a pose graph.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum G2oError {
    /// A line that cannot be read.
    #[error(transparent)]
    Line(#[from] FieldError),
    /// Two vertices with the same name.
    #[error("line {line}: there is a vertex {id} already")]
    Twice {
        /// Line, from 1.
        line: usize,
        /// Name of the vertex.
        id: u64,
    },
    /// An edge from a vertex to itself.
    #[error("line {line}: an edge joins vertex {id} to itself")]
    SelfLoop {
        /// Line, from 1.
        line: usize,
        /// Name of the vertex.
        id: u64,
    },
    /// An edge, or `FIX`, names a vertex that the file does not have.
    #[error("line {line}: there is no vertex {id} in the file")]
    NoVertex {
        /// Line, from 1.
        line: usize,
        /// Name of the vertex.
        id: u64,
    },
    /// More than one vertex is fixed, which a [`crate::estimation::PoseGraph`] does not support.
    #[error("{0} vertices are fixed; at most one can be")]
    ManyFixed(usize),
    /// No vertex at all.
    #[error("no VERTEX_SE2 in the file{}", others(left_out))]
    Empty {
        /// Lines with other tags.
        left_out: BTreeMap<String, usize>,
    },
}

fn others(left_out: &BTreeMap<String, usize>) -> String {
    let tags: Vec<_> = left_out.keys().take(5).map(String::as_str).collect();
    match tags.is_empty() {
        true => String::new(),
        false => format!(", but {}", tags.join(", ")),
    }
}

/// Reads a pose graph.
///
/// # Errors   [`G2oError`], with line and field.
pub fn parse(bytes: &[u8]) -> Result<G2oGraph, G2oError> {
    let text = String::from_utf8_lossy(bytes);
    let mut graph = G2oGraph::default();
    let mut ids = BTreeSet::new();
    // Edges may stand before the vertices that they join.
    let mut named = vec![];
    for (line, text) in (1..).zip(text.lines()) {
        let text = text.split('#').next().unwrap_or("");
        let mut words = text.split_ascii_whitespace();
        let Some(tag) = words.next() else { continue };
        let words: Vec<_> = words.collect();
        match tag {
            "VERTEX_SE2" => {
                count(line, &words, 4, "4 after the tag: id x y θ")?;
                let id = id(line, 1, words[0])?;
                if !ids.insert(id) {
                    return Err(G2oError::Twice { line, id });
                }
                let [x, y, theta] = numbers(line, 2, &words[1..])?;
                let pose = Vector3::new(x, y, theta);
                graph.vertices.push(G2oVertex { id, pose });
            }
            "EDGE_SE2" => {
                let expected = "11 after the tag: from to x y θ i11 i12 i13 i22 i23 i33";
                count(line, &words, 11, expected)?;
                let (from, to) = (id(line, 1, words[0])?, id(line, 2, words[1])?);
                if from == to {
                    return Err(G2oError::SelfLoop { line, id: from });
                }
                let [x, y, theta, a, b, c, d, e, f] = numbers(line, 3, &words[2..])?;
                named.extend([(line, from), (line, to)]);
                graph.edges.push(G2oEdge {
                    from,
                    to,
                    motion: Vector3::new(x, y, theta),
                    information: Matrix3::new(a, b, c, b, d, e, c, e, f),
                });
            }
            "FIX" => {
                for (field, word) in (1..).zip(&words) {
                    let id = id(line, field, word)?;
                    named.push((line, id));
                    graph.fixed.insert(id);
                }
            }
            other => *graph.left_out.entry(short(other)).or_default() += 1,
        }
    }
    if let Some(&(line, id)) = named.iter().find(|(_, id)| !ids.contains(id)) {
        return Err(G2oError::NoVertex { line, id });
    }
    if graph.vertices.is_empty() {
        let left_out = graph.left_out;
        return Err(G2oError::Empty { left_out });
    }
    Ok(graph)
}

/// Writes a pose graph: vertices, fixed vertices, edges. Lines that were left out are not written.
#[must_use]
pub fn write(graph: &G2oGraph) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for G2oVertex { id, pose } in &graph.vertices {
        let _ = writeln!(text, "VERTEX_SE2 {id} {} {} {}", pose.x, pose.y, pose.z);
    }
    for id in &graph.fixed {
        let _ = writeln!(text, "FIX {id}");
    }
    for edge in &graph.edges {
        let (z, i) = (&edge.motion, &edge.information);
        let _ = writeln!(
            text,
            "EDGE_SE2 {} {} {} {} {} {} {} {} {} {} {}",
            edge.from,
            edge.to,
            z.x,
            z.y,
            z.z,
            i[(0, 0)],
            i[(0, 1)],
            i[(0, 2)],
            i[(1, 1)],
            i[(1, 2)],
            i[(2, 2)]
        );
    }
    text
}

fn count(line: usize, words: &[&str], needed: usize, expected: &str) -> Result<(), FieldError> {
    match words.len() == needed {
        true => Ok(()),
        false => Err(FieldError::count(line, words.len(), expected)),
    }
}

fn id(line: usize, field: usize, word: &str) -> Result<u64, FieldError> {
    let expected = "the number of a vertex";
    read(
        line,
        format_args!("field {field}"),
        word,
        expected,
        |_: &u64| true,
    )
}

fn numbers<const N: usize>(
    line: usize,
    first: usize,
    words: &[&str],
) -> Result<[f64; N], FieldError> {
    let mut numbers = [0.0; N];
    for (field, (to, word)) in (first..).zip(numbers.iter_mut().zip(words)) {
        *to = number(line, format_args!("field {field}"), word)?;
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vector3<f64>> {
        let part = || prop_oneof![-1e3..1e3_f64, proptest::num::f64::NORMAL];
        (part(), part(), part()).prop_map(|(x, y, z)| Vector3::new(x, y, z))
    }

    prop_compose! {
        fn graphs()(poses in proptest::collection::vec(vector(), 2..20))(
            edges in proptest::collection::vec(
                (0..poses.len() as u64, 0..poses.len() as u64, vector(), vector(), vector())
                    .prop_filter("two vertices", |edge| edge.0 != edge.1), 0..poses.len()),
            fixed in proptest::collection::btree_set(0..poses.len() as u64, 0..3),
            poses in Just(poses),
        ) -> G2oGraph {
            let vertices = (0..).zip(poses).map(|(id, pose)| G2oVertex { id: 7 * id, pose });
            let edge = |(from, to, motion, a, b): (u64, u64, Vector3<f64>, Vector3<f64>, Vector3<f64>)| G2oEdge {
                from: 7 * from,
                to: 7 * to,
                motion,
                information: Matrix3::new(a.x, a.y, a.z, a.y, b.x, b.y, a.z, b.y, b.z),
            };
            G2oGraph {
                vertices: vertices.collect(),
                edges: edges.into_iter().map(edge).collect(),
                fixed: fixed.into_iter().map(|id| 7 * id).collect(),
                left_out: BTreeMap::new(),
            }
        }
    }

    proptest! {
        #[test]
        fn what_is_written_reads_the_same_to_the_bit(graph in graphs()) {
            prop_assert_eq!(parse(write(&graph).as_bytes()).unwrap(), graph);
        }
    }

    fn check(text: &str, says: &str) {
        let error = parse(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(says), "{text:?}: {error}");
    }

    #[test]
    fn errors_say_line_and_what() {
        check("", "no VERTEX_SE2 in the file");
        check("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n", "but VERTEX_SE3:QUAT");
        check(
            "# a\n\nVERTEX_SE2 0 1 2\n",
            "line 3: the number of fields is `3`",
        );
        check("VERTEX_SE2 0 1 2 nan\n", "line 1: field 4 is `nan`");
        check("VERTEX_SE2 -1 1 2 3\n", "line 1: field 1 is `-1`");
        check(
            "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 0 1 1 1\n",
            "line 2: there is a vertex 0 already",
        );
        check(
            "EDGE_SE2 0 1 0 0 0 1 0 0 1 0 1\nVERTEX_SE2 0 0 0 0\n",
            "line 1: there is no vertex 1",
        );
        check(
            "EDGE_SE2 3 3 0 0 0 1 0 0 1 0 1",
            "line 1: an edge joins vertex 3 to itself",
        );
        check(
            "VERTEX_SE2 0 0 0 0\nFIX 0 4\n",
            "line 2: there is no vertex 4",
        );
        check(
            "VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 0 0\n",
            "line 2: the number of fields is `3`",
        );
    }

    #[test]
    fn bytes_that_are_no_text_are_escaped_and_cut_short() {
        let mut picture = b"\xff\xd8\x00\x1b[31mJFIF\x07\n".to_vec();
        picture.extend([0x1b; 5000]);
        let error = parse(&picture).unwrap_err().to_string();
        assert!(!error.chars().any(char::is_control), "{error}");
        assert!(error.contains("\\u{0}\\u{1b}[31mJFIF\\u{7}"), "{error}");
        assert!(error.len() < 300, "{error}");
    }

    #[test]
    fn comments_fixed_vertices_and_other_tags_are_known() {
        let text = "# g2o\nVERTEX_SE2 4 1 2 3 # here\r\nFIX 4\nVERTEX_XY 5 1 1\nVERTEX_XY 6 1 1\n";
        let graph = parse(text.as_bytes()).unwrap();
        assert_eq!(
            graph.vertices,
            [G2oVertex {
                id: 4,
                pose: Vector3::new(1.0, 2.0, 3.0)
            }]
        );
        assert_eq!(graph.fixed, BTreeSet::from([4]));
        assert_eq!(
            graph.left_out,
            BTreeMap::from([("VERTEX_XY".to_owned(), 2)])
        );
    }

    #[test]
    fn published_graphs_are_read_whole() {
        for (name, vertices, edges) in [("intel.g2o", 1228, 1483), ("m3500.g2o", 3500, 5453)] {
            let Some(bytes) = crate::format::recorded(&format!("posegraphs/{name}")) else {
                continue;
            };
            let graph = parse(&bytes).unwrap();
            assert_eq!(
                (graph.vertices.len(), graph.edges.len()),
                (vertices, edges),
                "{name}"
            );
            assert!(graph.left_out.is_empty(), "{name}");
        }
    }
}
