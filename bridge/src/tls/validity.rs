//! When a certificate ends, read from its bytes.
//!
//! In: DER of a certificate. Out: its `notAfter`, since 1970; none if the bytes are not a
//! certificate. Nothing here decides whom to trust: it only serves to warn the certificate's owner.
//!
//! 1. `Certificate` and `TBSCertificate` are nested sequences.
//! 2. The validity follows version (tag `[0]`, absent in version 1), serial number, algorithm and
//!    issuer.
//! 3. The validity is a sequence of two times, each `UTCTime` or `GeneralizedTime`, in UTC.
//!
//! Source: RFC 5280 §4.1; lengths by X.690 §8.1.3.

use std::time::Duration;

use time::{Date, Month, OffsetDateTime, Time};

const SEQUENCE: u8 = 0x30;
const VERSION: u8 = 0xA0;
const UTC_TIME: u8 = 0x17;
const GENERALIZED_TIME: u8 = 0x18;

/// When the certificate ends.
pub(super) fn ends(der: &[u8]) -> Option<Duration> {
    let whole = expect(SEQUENCE, &mut { der })?;
    let tbs = &mut expect(SEQUENCE, &mut { whole })?;
    let (tag, _) = next(tbs)?;
    // Without a version, the first value was the serial number.
    let before_issuer = if tag == VERSION { 2 } else { 1 };
    for _ in 0..=before_issuer {
        next(tbs)?;
    }
    let validity = &mut expect(SEQUENCE, tbs)?;
    next(validity)?;
    let (tag, text) = next(validity)?;
    moment(tag, std::str::from_utf8(text).ok()?)
}

/// Takes the next value, with its tag, and moves on past it.
fn next<'a>(rest: &mut &'a [u8]) -> Option<(u8, &'a [u8])> {
    let (&[tag, first], behind) = rest.split_first_chunk()?;
    let (length, behind) = match first {
        0..0x80 => (usize::from(first), behind),
        _ => {
            // No certificate needs more than four bytes for a length.
            let count = usize::from(first & 0x7F);
            let (bytes, behind) = behind.split_at_checked(count).filter(|_| count <= 4)?;
            let length = bytes
                .iter()
                .fold(0, |sum, byte| sum << 8 | usize::from(*byte));
            (length, behind)
        }
    };
    let (value, behind) = behind.split_at_checked(length)?;
    *rest = behind;
    Some((tag, value))
}

fn expect<'a>(tag: u8, rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    next(rest)
        .filter(|(found, _)| *found == tag)
        .map(|(_, value)| value)
}

/// `YYMMDDHHMMSSZ` in the years 1950 to 2049, or with a year of four digits.
fn moment(tag: u8, text: &str) -> Option<Duration> {
    let years = match tag {
        UTC_TIME => 2,
        GENERALIZED_TIME => 4,
        _ => return None,
    };
    let (year, rest) = text.strip_suffix('Z')?.split_at_checked(years)?;
    let year: i32 = year.parse().ok()?;
    let year = match (years, year) {
        (2, 0..50) => 2000 + year,
        (2, _) => 1900 + year,
        _ => year,
    };
    let figures: Option<Vec<u8>> = (0..5)
        .map(|at| rest.get(2 * at..2 * at + 2)?.parse().ok())
        .collect();
    let &[month, day, hour, minute, second] = &*figures? else {
        return None;
    };
    let date = Date::from_calendar_date(year, Month::try_from(month).ok()?, day).ok()?;
    let time = Time::from_hms(hour, minute, second).ok()?;
    let seconds = OffsetDateTime::new_utc(date, time).unix_timestamp();
    // A time before 1970 counts as 1970: it is past in any case.
    Some(Duration::from_secs(u64::try_from(seconds).unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(year: i32) -> Vec<u8> {
        let mut params = rcgen::CertificateParams::new(["robot.example".to_owned()]).unwrap();
        params.not_before = rcgen::date_time_ymd(1999, 1, 1);
        params.not_after = rcgen::date_time_ymd(year, 2, 28);
        let key = rcgen::KeyPair::generate().unwrap();
        params.self_signed(&key).unwrap().der().to_vec()
    }

    #[test]
    fn the_end_is_read_in_both_forms_of_time() {
        for year in [2026, 2049, 2050, 2100] {
            let end = rcgen::date_time_ymd(year, 2, 28).unix_timestamp();
            assert_eq!(
                ends(&made(year)),
                Some(Duration::from_secs(end as u64)),
                "{year}"
            );
        }
        // 2020-01-01T00:00:01Z is 1577836801 by `date -d … +%s`.
        let second = Some(Duration::from_secs(1_577_836_801));
        assert_eq!(moment(UTC_TIME, "200101000001Z"), second);
        assert_eq!(moment(GENERALIZED_TIME, "20200101000001Z"), second);
        assert_eq!(moment(UTC_TIME, "500101000000Z"), Some(Duration::ZERO));
    }

    #[test]
    fn what_is_no_certificate_has_no_end() {
        let good = made(2030);
        for length in 0..good.len() {
            let cut = good.get(..length).unwrap();
            assert_eq!(ends(cut), None, "cut off after {length}");
        }
        for text in [
            "",
            "Z",
            "2001010000Z",
            "209901000001Z",
            "2001010000€1Z",
            "200101000001",
        ] {
            assert_eq!(moment(UTC_TIME, text), None, "{text}");
        }
        assert_eq!(ends(&[SEQUENCE, 0x89, 0, 0, 0, 0, 0, 0, 0, 0, 1]), None);
    }
}
