//! What serde says of a world file, in words for whoever wrote the file.
//!
//! In: the message, and the part of the file that it is about. Out: a sentence. A message that is not known is passed on as it
//! stands: it is better than none.

use serde_json::Error;

/// One sentence on what is wrong, the part in front: `obstacle 3, radius: is text ("wide"), expected a number`.
pub(super) fn in_words(part: &serde_path_to_error::Path, error: &Error) -> String {
    let text = error.to_string();
    // serde_json ends its messages with the place, which the caller says in front.
    let place = format!(" at line {} column {}", error.line(), error.column());
    let text = text.strip_suffix(&place).unwrap_or(&text);
    let what = sentence(text);
    match name_of(part) {
        // serde_json says so of a fixed number of elements with one more.
        Some(name) if text == "trailing characters" => format!("{name}: has more numbers than two"),
        // A file that is no JSON is at fault where it stands, whatever it was meant to be.
        Some(name) if !error.is_syntax() && !error.is_eof() => format!("{name}: {what}"),
        _ => what,
    }
}

/// `obstacles[3].size[0]` is "obstacle 3, size, number 0"; `None` for the file itself.
fn name_of(path: &serde_path_to_error::Path) -> Option<String> {
    use serde_path_to_error::Segment;
    let mut names: Vec<String> = vec![];
    for segment in path {
        match segment {
            Segment::Seq { index } => {
                let list = names.pop().unwrap_or_default();
                match list.as_str() {
                    "obstacles" => names.push(format!("obstacle {index}")),
                    "movers" => names.push(format!("mover {index}")),
                    "points" | "waypoints" => names.push(format!("point {index}")),
                    _ => names.extend([list, format!("number {index}")]),
                }
            }
            Segment::Map { key } => names.push(key.clone()),
            _ => {}
        }
    }
    (!names.is_empty()).then(|| names.join(", "))
}

fn sentence(text: &str) -> String {
    if let Some(rest) = text.strip_prefix("missing field ") {
        return format!("the field {rest} is missing");
    }
    if let Some(rest) = text.strip_prefix("duplicate field ") {
        return format!("the field {rest} stands here twice");
    }
    for (prefix, what) in [
        ("unknown field ", "there is no field "),
        ("unknown variant ", "there is no "),
    ] {
        if let Some((name, expected)) = parts(text, prefix) {
            let expected = expected.strip_prefix("one of ").unwrap_or(expected);
            return format!("{what}{name}; expected one of {expected}");
        }
    }
    for prefix in ["invalid type: ", "invalid value: "] {
        if let Some((found, expected)) = parts(text, prefix) {
            return format!("is {}, expected {}", thing(found), wanted(expected));
        }
    }
    if let Some((found, expected)) = parts(text, "invalid length ") {
        return format!("has {found} numbers, expected {}", wanted(expected));
    }
    of_json(text).unwrap_or(text).to_owned()
}

/// `{prefix}{found}, expected {expected}`.
fn parts<'a>(text: &'a str, prefix: &str) -> Option<(&'a str, &'a str)> {
    text.strip_prefix(prefix)?.rsplit_once(", expected ")
}

/// What was found.
fn thing(found: &str) -> String {
    let (kind, value) = found.split_once(' ').unwrap_or((found, ""));
    match kind {
        "string" => format!("text ({value})"),
        "integer" => format!("the whole number {}", value.trim_matches('`')),
        "floating" => format!(
            "the number {}",
            value.trim_start_matches("point ").trim_matches('`')
        ),
        "boolean" => value.trim_matches('`').to_owned(),
        "null" => "null".to_owned(),
        "map" => "an object { … }".to_owned(),
        "sequence" => "a list [ … ]".to_owned(),
        _ => found.to_owned(),
    }
}

/// What was expected.
fn wanted(expected: &str) -> String {
    match expected {
        "f64" => "a number",
        "u32" | "u64" => "a whole number of 0 or more",
        "a boolean" => "true or false",
        "a string" => "text in quotes",
        "a sequence" => "a list [ … ]",
        "an array of length 2" => "a pair of numbers [x, y]",
        "string or map" => "a name in quotes",
        "struct PoseFile" => "a pose { \"x\": …, \"y\": …, \"heading\": … }",
        "struct PointFile" => "a point { \"x\": …, \"y\": … }",
        "struct ObstacleFile" => "an obstacle { \"shape\": …, … }",
        "struct MoverFile" => "a mover { \"waypoints\": …, \"speed\": …, \"radius\": … }",
        "struct WorldFile" => "a world { \"slamlab_world\": 1, … }",
        other => other,
    }
    .to_owned()
}

/// What is no JSON.
fn of_json(text: &str) -> Option<&'static str> {
    Some(match text {
        "EOF while parsing an object" => "the file ends inside of an object: a } is missing",
        "EOF while parsing a list" => "the file ends inside of a list: a ] is missing",
        "EOF while parsing a string" => "the file ends inside of a text: a \" is missing",
        "EOF while parsing a value" => "the file ends where a value is expected",
        "expected `,` or `}`" => "expected a comma or } after a field",
        "expected `,` or `]`" => "expected a comma or ] after an element of a list",
        "expected `:`" => "expected a colon after the name of a field",
        "expected value" => "expected a value: a number, a text in quotes, a list or an object",
        "key must be a string" => "expected the name of a field in quotes",
        "trailing comma" => "a comma stands before the end of a list or object",
        "trailing characters" => "something stands after the end of the world",
        "number out of range" => "the number is too large",
        "invalid number" => "this is no number",
        "control character (\\u0000-\\u001F) found while parsing a string" => {
            "a line ends inside of a text: a \" is missing"
        }
        "recursion limit exceeded" => "lists stand within lists too deep",
        _ => return None,
    })
}
