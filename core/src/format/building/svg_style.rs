//! The style of elements of a drawing: from their attributes, their own `style` and the style
//! sheets of the file.
//!
//! In: an element and the name of a property. Out: its value.
//!
//! 1. The attribute `style` overrides style sheets, and these override an attribute of the
//!    property's name; `!important` overrides all. Of two with equal weight the later one holds.
//! 2. Style sheet rules for elements, classes, identifiers and attributes are read. Rules that
//!    combine several elements (descendants, siblings), and rules for particular media, are only
//!    counted.
//! 3. Only properties that decide whether something is drawn are kept, and each element is matched
//!    against the rules once, however often it is copied.

use std::collections::BTreeMap;

use roxmltree::{Document, Node};
use simplecss::{AttributeOperator, Declaration, PseudoClass, StyleSheet};

use super::SvgError;
use super::error::line_of;

/// More selectors than this are refused, because each is matched against each element; so are more
/// declarations, because the parser takes time quadratic in their number.
const MOST_SELECTORS: usize = 1000;
const MOST_DECLARATIONS: usize = 10_000;

/// The properties that decide whether an element is drawn, in the order of [`Style`]'s values.
const NAMES: [&str; 4] = ["stroke", "fill", "display", "visibility"];

/// An element's own values, without what it inherits from its group.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Style<'a> {
    values: [Option<&'a str>; NAMES.len()],
}

impl<'a> Style<'a> {
    /// The value of one of [`NAMES`].
    pub(super) fn get(&self, name: &str) -> Option<&'a str> {
        let at = NAMES.iter().position(|known| *known == name)?;
        self.values[at]
    }

    /// Its own values, and those of `lesser` where it has none.
    fn or(self, lesser: Self) -> Self {
        let mut values = self.values;
        for (value, other) in values.iter_mut().zip(lesser.values) {
            *value = value.or(other);
        }
        Self { values }
    }
}

/// What a rule, or an attribute `style`, declares.
#[derive(Clone, Copy, Debug, Default)]
struct Declared<'a> {
    said: Style<'a>,
    important: Style<'a>,
}

impl<'a> Declared<'a> {
    fn of(declarations: impl Iterator<Item = Declaration<'a>>) -> Self {
        let mut all = Self::default();
        for declaration in declarations {
            let style = match declaration.important {
                true => &mut all.important,
                false => &mut all.said,
            };
            if let Some(at) = NAMES.iter().position(|name| *name == declaration.name) {
                style.values[at] = Some(declaration.value.trim());
            }
        }
        all
    }

    fn is_empty(&self) -> bool {
        let mut values = self.said.values.iter().chain(&self.important.values);
        values.all(Option::is_none)
    }

    /// Both; declarations of `later` take precedence.
    fn then(self, later: Self) -> Self {
        Self {
            said: later.said.or(self.said),
            important: later.important.or(self.important),
        }
    }
}

/// The style sheets of a drawing.
#[derive(Debug)]
pub(super) struct Styles<'a> {
    /// In order of precedence, lowest first.
    rules: Vec<(simplecss::Selector<'a>, Declared<'a>)>,
    /// Rules that were not read.
    pub(super) skipped: usize,
    /// By the position at which the element begins in the text.
    known: BTreeMap<usize, Style<'a>>,
}

impl<'a> Styles<'a> {
    /// All style sheets of the document.
    ///
    /// # Errors    [`SvgError::Syntax`] for more rules than are accepted.
    pub(super) fn of(document: &'a Document) -> Result<Self, SvgError> {
        let mut sheet = StyleSheet::new();
        let (mut skipped, mut selectors, mut declarations) = (0, 0, 0);
        let is_sheet = |node: &Node| node.tag_name().name() == "style";
        for style in document.root_element().descendants().filter(is_sheet) {
            let media = style.attribute("media").map_or("all", str::trim);
            if !matches!(media, "all" | "screen" | "") {
                skipped += 1;
                continue;
            }
            for text in style.children().filter_map(|child| child.text()) {
                // Checked before any are parsed.
                let lists = text.split('}').filter_map(|rule| rule.split_once('{'));
                let counts = lists.map(|(list, _)| 1 + list.matches(',').count());
                selectors += counts.sum::<usize>();
                declarations += text.matches(';').count();
                if selectors > MOST_SELECTORS || declarations > MOST_DECLARATIONS {
                    return Err(SvgError::Syntax {
                        line: line_of(&style),
                        what: format!(
                            "more than {MOST_SELECTORS} selectors or {MOST_DECLARATIONS} declarations in <style>"
                        ),
                    });
                }
                sheet.parse_more(text);
                skipped += text.matches('@').count();
            }
        }
        let mut rules = Vec::with_capacity(sheet.rules.len());
        for rule in sheet.rules {
            let declared = Declared::of(rule.declarations.into_iter());
            match rule.selector.to_string().contains([' ', '>', '+']) {
                true => skipped += 1,
                false if declared.is_empty() => {}
                false => rules.push((rule.selector, declared)),
            }
        }
        Ok(Self {
            rules,
            skipped,
            known: BTreeMap::new(),
        })
    }

    /// An element's own values, without what it inherits from its group.
    pub(super) fn style(&mut self, node: &Node<'a, 'a>) -> Style<'a> {
        if let Some(style) = self.known.get(&node.range().start) {
            return *style;
        }
        let matching = |(selector, _): &&(simplecss::Selector, _)| selector.matches(&InTree(*node));
        let rules = self.rules.iter().filter(matching);
        let sheets = rules.fold(Declared::default(), |all, (_, rule)| all.then(*rule));
        let own = node.attribute("style").unwrap_or_default();
        let own = Declared::of(own.split(';').filter_map(declaration));
        let attributes = Style {
            values: NAMES.map(|name| node.attribute(name).map(str::trim)),
        };
        let important = own.important.or(sheets.important);
        let style = important.or(own.said).or(sheets.said).or(attributes);
        self.known.insert(node.range().start, style);
        style
    }
}

/// One declaration of an attribute `style`.
fn declaration(text: &str) -> Option<Declaration<'_>> {
    let (name, value) = text.split_once(':')?;
    let (value, mark) = value.split_once('!').unwrap_or((value, ""));
    Some(Declaration {
        name: name.trim(),
        value,
        important: mark.trim() == "important",
    })
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

    /// A drawing on paper has no hover or other state.
    fn pseudo_class_matches(&self, class: PseudoClass<'_>) -> bool {
        class == PseudoClass::FirstChild && self.prev_sibling_element().is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BuildingError, of_svg};
    use super::*;

    /// What a style sheet and an attribute `style` make of a line's stroke.
    fn stroke(sheet: &str, own: &str) -> Option<String> {
        let text = format!("<svg><style>{sheet}</style><path style='{own}' stroke='red'/></svg>");
        let document = Document::parse(&text).unwrap();
        let mut styles = Styles::of(&document).unwrap();
        let path = document.root_element().last_element_child().unwrap();
        styles.style(&path).get("stroke").map(str::to_owned)
    }

    #[test]
    fn the_later_and_the_more_important_holds() {
        for (sheet, own, expect) in [
            ("", "", "red"),
            ("path { stroke: blue }", "", "blue"),
            ("path { stroke: blue; stroke: green }", "", "green"),
            ("path { stroke: blue }", "stroke: none", "none"),
            ("path { stroke: blue !important }", "stroke: none", "blue"),
            (
                "path { stroke: blue !important }",
                "stroke: none !important",
                "none",
            ),
            ("", "stroke: blue; stroke: none", "none"),
            ("", "stroke: none !important; stroke: blue", "none"),
        ] {
            assert_eq!(
                stroke(sheet, own).as_deref(),
                Some(expect),
                "{sheet} | {own}"
            );
        }
    }

    #[test]
    fn a_style_sheet_for_paper_is_skipped_and_counted() {
        let text = "<svg><style media='print'>path { stroke: none }</style></svg>";
        let document = Document::parse(text).unwrap();
        let styles = Styles::of(&document).unwrap();
        assert!(styles.rules.is_empty());
        assert_eq!(styles.skipped, 1);
    }

    /// A few megabytes that would take minutes: they are refused, or read at once.
    #[test]
    fn what_is_copied_costs_no_more_than_what_is_drawn() {
        let comments = "<!---->".repeat(20_000);
        let copies = "<use href='#a'/>".repeat(20_000);
        for hidden in ["", " display='none'"] {
            let text = format!(
                "<svg><defs><g id='a'><g{hidden}>{comments}</g></g></defs>{copies}<path d='M0 0H900V900' stroke='red'/></svg>"
            );
            match (hidden, of_svg(text.as_bytes(), None, "copies")) {
                ("", Err(BuildingError::Svg(SvgError::TooManyCopies { .. }))) => {}
                (" display='none'", Ok(_)) => {}
                (_, other) => panic!("{hidden}: {other:?}"),
            }
        }
        let many = "stroke:x;".repeat(300_000);
        let path = "<path d='M0 0H900V900' stroke='red'/>";
        for sheet in [
            format!("*{{{many}}}"),
            format!("{}* {{ fill: none }}", "g,".repeat(2_000)),
        ] {
            let text = format!("<svg><style>{sheet}</style>{path}</svg>");
            let refused = of_svg(text.as_bytes(), None, "sheet")
                .unwrap_err()
                .to_string();
            assert!(refused.contains("more than 1000 selectors"), "{refused}");
        }
        let text = format!("<svg><g style='{many}'>{path}</g></svg>");
        of_svg(text.as_bytes(), None, "own").unwrap();
    }
}
