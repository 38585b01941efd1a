//! Rows of eight finite numbers with `#` comments: what relations and TUM trajectories are written in.

/// What is wrong with a row.
pub(super) enum RowError {
    /// Not eight fields.
    Count { line: usize, found: usize },
    /// A field, counted from 1, that is no finite number.
    Field {
        line: usize,
        field: usize,
        found: String,
    },
}

/// The rows of a text, empty ones and comments left out.
pub(super) fn rows(text: &str) -> impl Iterator<Item = Result<[f64; 8], RowError>> {
    text.lines().enumerate().filter_map(|(index, text)| {
        let text = text.split('#').next().unwrap_or("");
        let words: Vec<_> = text.split_ascii_whitespace().collect();
        (!words.is_empty()).then(|| row(index + 1, &words))
    })
}

fn row(line: usize, words: &[&str]) -> Result<[f64; 8], RowError> {
    let mut numbers = [0.0; 8];
    if words.len() != numbers.len() {
        return Err(RowError::Count {
            line,
            found: words.len(),
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
