//! The trajectories of all particles, as a tree, because particles drawn from one share its past.
//!
//! A node is a pose at one of the scans taken into the maps; the particles are at the leaves. Nodes
//! that no longer lead to a particle are dropped from time to time.

use crate::geom::Pose2;

/// The index of a node. It changes when nodes are dropped.
pub(super) type NodeId = u32;
const NO_PARENT: NodeId = NodeId::MAX;

#[derive(Clone, Copy, Debug)]
struct Node {
    parent: NodeId,
    pose: Pose2,
}

/// The tree.
#[derive(Clone, Debug, Default)]
pub(super) struct Ancestry {
    /// Parents before their children.
    nodes: Vec<Node>,
    /// Number of nodes that remained when some were last dropped.
    left: usize,
}

impl Ancestry {
    /// Adds the pose that follows `parent`; `None` starts a trajectory.
    pub(super) fn push(&mut self, parent: Option<NodeId>, pose: Pose2) -> NodeId {
        let parent = parent.unwrap_or(NO_PARENT);
        self.nodes.push(Node { parent, pose });
        (self.nodes.len() - 1) as NodeId
    }

    /// The poses that led to a node, the oldest first.
    pub(super) fn line(&self, leaf: NodeId) -> Vec<Pose2> {
        let at = |id: NodeId| self.nodes.get(id as usize);
        let nodes = std::iter::successors(at(leaf), |node| at(node.parent));
        let mut line: Vec<Pose2> = nodes.map(|node| node.pose).collect();
        line.reverse();
        line
    }

    /// Drops nodes that lead to none of `leaves`, if they may be half of all, and updates the ids
    /// in `leaves`.
    pub(super) fn prune<'a>(&mut self, leaves: impl Iterator<Item = &'a mut NodeId>) {
        const FEW: usize = 1000;
        if self.nodes.len() < 2 * self.left + FEW {
            return;
        }
        let leaves: Vec<&mut NodeId> = leaves.collect();
        let mut is_needed = vec![false; self.nodes.len()];
        for leaf in &leaves {
            let mut at = **leaf;
            while let Some(needed) = is_needed.get_mut(at as usize) {
                if std::mem::replace(needed, true) {
                    break;
                }
                at = self.nodes[at as usize].parent;
            }
        }
        let mut new = vec![NO_PARENT; self.nodes.len()];
        let mut kept = vec![];
        for (old, node) in self
            .nodes
            .iter()
            .enumerate()
            .filter(|(old, _)| is_needed[*old])
        {
            new[old] = kept.len() as NodeId;
            let parent = new.get(node.parent as usize).copied();
            kept.push(Node {
                parent: parent.unwrap_or(NO_PARENT),
                pose: node.pose,
            });
        }
        for leaf in leaves {
            *leaf = new.get(*leaf as usize).copied().unwrap_or(NO_PARENT);
        }
        self.left = kept.len();
        self.nodes = kept;
    }

    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn lines_are_those_of_full_copies_and_dead_branches_are_dropped() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut tree = Ancestry::default();
        let mut copies: Vec<Vec<Pose2>> = vec![vec![]; 20];
        let mut leaves: Vec<Option<NodeId>> = vec![None; 20];
        for step in 0..1000 {
            if step % 7 == 6 {
                let drawn: Vec<usize> = (0..20).map(|_| rng.random_range(0..20)).collect();
                copies = drawn.iter().map(|&i| copies[i].clone()).collect();
                leaves = drawn.iter().map(|&i| leaves[i]).collect();
                tree.prune(leaves.iter_mut().flatten());
            }
            for (copy, leaf) in copies.iter_mut().zip(&mut leaves) {
                let pose = Pose2::new(rng.random::<f64>(), f64::from(step), 0.0);
                copy.push(pose);
                *leaf = Some(tree.push(*leaf, pose));
            }
        }
        for (copy, leaf) in copies.iter().zip(&leaves) {
            assert_eq!(&tree.line(leaf.unwrap()), copy);
        }
        // Few of 20 000 nodes have descendants: one line, and the last branches.
        assert!(tree.len() < 5000, "{}", tree.len());
    }
}
