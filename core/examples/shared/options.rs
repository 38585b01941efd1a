//! In: the text of an option that several programs take. Out: what it says.

/// A setting as `KEY=NUMBER`.
pub(crate) fn setting(text: &str) -> Result<(String, f64), String> {
    let (key, number) = text.split_once('=').ok_or("expected KEY=NUMBER")?;
    let number = number
        .parse()
        .map_err(|error| format!("{number}: {error}"))?;
    Ok((key.to_owned(), number))
}
