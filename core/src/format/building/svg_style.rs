//! How elements of a drawing are drawn, by their attributes, their own `style` and the style sheets of the file.
//!
//! In: an element and the name of a property. Out: its value.
//!
//! 1. The attribute `style` comes before style sheets, these before an attribute of the property's name; `!important` before all.
//! 2. Of the rules of style sheets those for elements, classes, identifiers and attributes are read. Rules for elements within or beside
//!    others are not, nor those for some media only: they are counted.

use roxmltree::{Document, Node};
use simplecss::{AttributeOperator, PseudoClass, Rule, StyleSheet};

use super::SvgError;
use super::svg::line_of;

/// More rules than this are refused: each is held against each element.
const MOST_RULES: usize = 1000;

/// The style sheets of a drawing.
#[derive(Debug)]
pub(super) struct Styles<'a> {
    /// In the order of what they weigh.
    rules: Vec<Rule<'a>>,
    /// Rules that were not read.
    pub(super) left_out: usize,
}

impl<'a> Styles<'a> {
    /// All that the document holds.
    ///
    /// # Errors    [`SvgError::Syntax`] for more rules than can be.
    pub(super) fn of(document: &'a Document) -> Result<Self, SvgError> {
        let mut sheet = StyleSheet::new();
        let mut at_rules = 0;
        let is_sheet = |node: &Node| node.tag_name().name() == "style";
        for style in document.root_element().descendants().filter(is_sheet) {
            for text in style.children().filter_map(|child| child.text()) {
                sheet.parse_more(text);
                at_rules += text.matches('@').count();
            }
            if sheet.rules.len() > MOST_RULES {
                return Err(SvgError::Syntax {
                    line: line_of(&style),
                    what: format!("more than {MOST_RULES} rules in <style>"),
                });
            }
        }
        let all = sheet.rules.len();
        let is_single = |rule: &Rule| !rule.selector.to_string().contains([' ', '>', '+']);
        sheet.rules.retain(is_single);
        Ok(Self {
            left_out: all - sheet.rules.len() + at_rules,
            rules: sheet.rules,
        })
    }

    /// The value of a property that an element has of itself, not of its group.
    pub(super) fn property<'s>(&'s self, node: &Node<'s, 's>, name: &str) -> Option<&'s str> {
        let (mut said, mut important) = (None, None);
        for rule in self
            .rules
            .iter()
            .filter(|r| r.selector.matches(&InTree(*node)))
        {
            for found in rule.declarations.iter().filter(|d| d.name == name) {
                *(if found.important {
                    &mut important
                } else {
                    &mut said
                }) = Some(found.value);
            }
        }
        let own = node.attribute("style").and_then(|style| {
            style.split(';').find_map(|part| {
                let (key, value) = part.split_once(':')?;
                (key.trim() == name).then_some(value)
            })
        });
        let found = important.or(own).or(said);
        found.or_else(|| node.attribute(name)).map(str::trim)
    }
}

/// An element as selectors see it.
struct InTree<'a>(Node<'a, 'a>);

impl simplecss::Element for InTree<'_> {
    fn parent_element(&self) -> Option<Self> {
        self.0.parent_element().map(Self)
    }

    fn prev_sibling_element(&self) -> Option<Self> {
        self.0.prev_sibling_element().map(Self)
    }

    fn has_local_name(&self, name: &str) -> bool {
        self.0.tag_name().name() == name
    }

    fn attribute_matches(&self, name: &str, operator: AttributeOperator<'_>) -> bool {
        self.0
            .attribute(name)
            .is_some_and(|value| operator.matches(value))
    }

    /// A drawing on paper is not hovered over.
    fn pseudo_class_matches(&self, class: PseudoClass<'_>) -> bool {
        class == PseudoClass::FirstChild && self.prev_sibling_element().is_none()
    }
}
