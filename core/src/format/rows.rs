//! Rows of eight finite numbers with `#` comments: what relations and TUM trajectories are written in.

/// What is wrong with a row.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RowError {
    /// A line with a wrong number of fields.
    #[error("line {line}: found {found} fields, expected 8: {columns}")]
    Count {
        /// Line, from 1.
        line: usize,
        /// Number of fields.
        found: usize,
        /// The fields, by their names.
        columns: &'static str,
    },
    /// A field that is no number.
    #[error("line {line}, field {field} is \"{found}\", expected a finite number")]
    Field {
        /// Line, from 1.
        line: usize,
        /// Field, from 1.
        field: usize,
        /// What stands there.
        found: String,
    },
}

/// The rows of a text with these columns, without empty ones and comments.
pub(super) fn rows(
    text: &str,
    columns: &'static str,
) -> impl Iterator<Item = Result<[f64; 8], RowError>> {
    text.lines().enumerate().filter_map(move |(index, text)| {
        let text = text.split('#').next().unwrap_or("");
        let words: Vec<_> = text.split_ascii_whitespace().collect();
        (!words.is_empty()).then(|| row(index + 1, &words, columns))
    })
}

fn row(line: usize, words: &[&str], columns: &'static str) -> Result<[f64; 8], RowError> {
    let mut numbers = [0.0; 8];
    if words.len() != numbers.len() {
        return Err(RowError::Count {
            line,
            found: words.len(),
            columns,
        });
    }
    for (field, (word, number)) in words.iter().zip(&mut numbers).enumerate() {
        *number = word
            .parse()
            .ok()
            .filter(|n: &f64| n.is_finite())
            .ok_or_else(|| RowError::Field {
                line,
                field: field + 1,
                found: word.chars().take(24).collect(),
            })?;
    }
    Ok(numbers)
}
