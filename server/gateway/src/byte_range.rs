//! A part of a file that a client asks for: one range of bytes (RFC 9110, section 14). Lists of ranges are answered with the whole file, as the standard allows.

use axum::http::{HeaderMap, header};

/// What a request asks for of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ByteRange {
    /// All of it.
    Whole,
    /// From the first to the last byte, both included.
    Part { first: u64, last: u64 },
    /// A part that it does not have.
    Unsatisfiable,
}

impl ByteRange {
    /// What is asked for of a file of `bytes` with this strong validator, in quotes.
    pub(crate) fn of(request: &HeaderMap, bytes: u64, etag: &str) -> Self {
        let mut ranges = request.get_all(header::RANGE).iter();
        let (Some(range), None) = (ranges.next(), ranges.next()) else { return Self::Whole };
        // A client that has part of another version gets all of this one.
        let is_of_this =
            request.get(header::IF_RANGE).is_none_or(|known| known.as_bytes() == etag.as_bytes());
        match range.to_str().ok().and_then(|text| text.strip_prefix("bytes=")) {
            Some(range) if is_of_this => Self::parse(range.trim(), bytes),
            _ => Self::Whole,
        }
    }

    /// Malformed ranges, and lists of them, count as none.
    fn parse(range: &str, bytes: u64) -> Self {
        let Some((first, last)) = range.split_once('-') else { return Self::Whole };
        let number =
            |text: &str| text.bytes().all(|digit| digit.is_ascii_digit()).then(|| text.parse::<u64>().ok());
        match (first, last) {
            ("", last) => match number(last).flatten() {
                Some(0) => Self::Unsatisfiable,
                Some(_) if bytes == 0 => Self::Unsatisfiable,
                Some(count) => Self::Part { first: bytes.saturating_sub(count), last: bytes - 1 },
                None => Self::Whole,
            },
            (first, last) => {
                let Some(first) = number(first).flatten() else { return Self::Whole };
                let last = if last.is_empty() { Some(u64::MAX) } else { number(last).flatten() };
                match last {
                    Some(last) if last < first => Self::Whole,
                    Some(_) if first >= bytes => Self::Unsatisfiable,
                    Some(last) => Self::Part { first, last: last.min(bytes - 1) },
                    None => Self::Whole,
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    fn asked(range: &'static str, bytes: u64) -> ByteRange {
        let request = HeaderMap::from_iter([(header::RANGE, HeaderValue::from_static(range))]);
        ByteRange::of(&request, bytes, "\"a\"")
    }

    #[test]
    fn one_range_is_a_part_and_all_else_the_whole_file() {
        let part = |first, last| ByteRange::Part { first, last };
        let cases = [
            ("bytes=0-0", part(0, 0)),
            ("bytes=2-", part(2, 9)),
            ("bytes=3-99", part(3, 9)),
            ("bytes=-4", part(6, 9)),
            ("bytes=-40", part(0, 9)),
            ("bytes=10-", ByteRange::Unsatisfiable),
            ("bytes=-0", ByteRange::Unsatisfiable),
            ("bytes=5-3", ByteRange::Whole),
            ("bytes=0-1,3-4", ByteRange::Whole),
            ("bytes=+1-2", ByteRange::Whole),
            ("bytes=99999999999999999999-", ByteRange::Whole),
            ("items=0-1", ByteRange::Whole),
            ("bytes=", ByteRange::Whole),
        ];
        for (range, expected) in cases {
            assert_eq!(asked(range, 10), expected, "{range}");
        }
        assert_eq!(
            (asked("bytes=0-", 0), asked("bytes=-5", 0)),
            (ByteRange::Unsatisfiable, ByteRange::Unsatisfiable)
        );
    }

    #[test]
    fn a_part_of_another_version_is_answered_with_all_of_this_one() {
        for (known, expected) in
            [("\"a\"", ByteRange::Part { first: 1, last: 2 }), ("\"b\"", ByteRange::Whole)]
        {
            let request = HeaderMap::from_iter([
                (header::RANGE, HeaderValue::from_static("bytes=1-2")),
                (header::IF_RANGE, HeaderValue::from_static(known)),
            ]);
            assert_eq!(ByteRange::of(&request, 10, "\"a\""), expected);
        }
    }
}
