//! Rows of eight finite numbers with `#` comments: the layout of relations files.

use super::FieldError;
use super::field_error::number;

/// The rows of a text with these columns, without empty lines and comments.
pub(super) fn rows(
    text: &str,
    columns: &'static str,
) -> impl Iterator<Item = Result<[f64; 8], FieldError>> {
    text.lines().enumerate().filter_map(move |(index, text)| {
        let text = text.split('#').next().unwrap_or("");
        let words: Vec<_> = text.split_ascii_whitespace().collect();
        (!words.is_empty()).then(|| row(index + 1, &words, columns))
    })
}

fn row(line: usize, words: &[&str], columns: &str) -> Result<[f64; 8], FieldError> {
    let mut numbers = [0.0; 8];
    if words.len() != numbers.len() {
        let expected = format_args!("8: {columns}");
        return Err(FieldError::count(line, words.len(), expected));
    }
    for (field, (word, to)) in (1..).zip(words.iter().zip(&mut numbers)) {
        *to = number(line, format_args!("field {field}"), word)?;
    }
    Ok(numbers)
}
