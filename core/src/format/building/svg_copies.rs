//! Copies of other parts of a drawing: `use`.
//!
//! In: an element `use`, and the copy that it stands in. Out: what it copies and where that lies,
//! or why it cannot be copied.
//!
//! Source: W3C, Scalable Vector Graphics 1.1, chapter 5.6. A `symbol` with a view box of its own,
//! and references to other files, are not supported.

use std::collections::BTreeMap;

use kurbo::Affine;
use roxmltree::{Document, Node, NodeId};

use super::SvgError;
use super::error::wrong;
use super::svg_shape::length;

/// Maximum depth of copies within copies.
const DEEPEST: usize = 32;
const XLINK: &str = "http://www.w3.org/1999/xlink";

/// The named parts of a drawing, and the copies that are being read.
#[derive(Debug)]
pub(super) struct Copies<'a> {
    named: BTreeMap<&'a str, Node<'a, 'a>>,
    /// What was copied, and the number of the enclosing copy.
    made: Vec<(NodeId, Option<usize>)>,
}

/// A copy: what, where, and its number.
pub(super) type Copy<'a> = (Node<'a, 'a>, Affine, usize);

impl<'a> Copies<'a> {
    pub(super) fn of(document: &'a Document) -> Self {
        let mut named = BTreeMap::new();
        for node in document.root_element().descendants() {
            if let Some(id) = node.attribute("id") {
                named.entry(id).or_insert(node);
            }
        }
        Self {
            named,
            made: vec![],
        }
    }

    /// What a `use` copies; the `use` itself stands in the copy with the number `within`. `None`
    /// where it is skipped.
    ///
    /// # Errors    [`SvgError::Attribute`]: a copy of a part that contains it, copies nested too
    /// deeply, or an invalid position.
    pub(super) fn copy(
        &mut self,
        node: &Node<'a, 'a>,
        within: Option<usize>,
    ) -> Result<Option<Copy<'a>>, SvgError> {
        let link = node.attribute((XLINK, "href"));
        let link = node.attribute("href").or(link).unwrap_or("").trim();
        let target = link.strip_prefix('#').and_then(|id| self.named.get(id));
        let has_view = |node: &Node| node.attribute("viewBox").is_some();
        let Some(&target) = target.filter(|target| !has_view(target)) else {
            return Ok(None);
        };
        let (mut outer, mut depth) = (within, 0);
        while let Some(&(copied, next)) = outer.and_then(|number| self.made.get(number)) {
            depth += 1;
            let expected = if copied == target.id() {
                "a part that does not hold this copy itself"
            } else if depth == DEEPEST {
                "copies within copies no deeper than 32"
            } else {
                outer = next;
                continue;
            };
            return Err(wrong(node, "href", link, expected));
        }
        self.made.push((target.id(), within));
        let place = Affine::translate((length(node, "x")?, length(node, "y")?));
        Ok(Some((target, place, self.made.len() - 1)))
    }
}
