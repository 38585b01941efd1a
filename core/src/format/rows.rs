//! Rows of eight finite numbers with `#` comments: what relations and TUM trajectories are written
//! in.

use super::FieldError;

/// The rows of a text with these columns, without empty ones and comments.
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
        return Err(FieldError::count(
            line,
            words.len(),
            format!("8: {columns}"),
        ));
    }
    for (field, (word, number)) in (1..).zip(words.iter().zip(&mut numbers)) {
        let parsed = word.parse().ok().filter(|n: &f64| n.is_finite());
        *number = parsed.ok_or_else(|| {
            FieldError::new(line, format!("field {field}"), word, "a finite number")
        })?;
    }
    Ok(numbers)
}
