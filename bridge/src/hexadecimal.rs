//! Bytes in hexadecimal, as written in scripts and files.

pub(crate) fn write(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Reads exactly `N` bytes; none if the text is anything else.
pub(crate) fn read<const N: usize>(text: &str) -> Option<[u8; N]> {
    let mut bytes = [0; N];
    if text.len() != 2 * N || !text.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    for (at, byte) in bytes.iter_mut().enumerate() {
        *byte = u8::from_str_radix(text.get(2 * at..2 * at + 2)?, 16).ok()?;
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hexadecimal_is_read_as_it_is_written_and_nothing_else_is() {
        let bytes = [0xA5, 0, 1, 0xFF];
        assert_eq!(write(&bytes), "a50001ff");
        assert_eq!(read(&write(&bytes)), Some(bytes));
        for bad in ["", "a5", "zzzzzzzz", "éééé", "+5+5+5+5"] {
            assert_eq!(read::<4>(bad), None, "{bad}");
        }
    }
}
