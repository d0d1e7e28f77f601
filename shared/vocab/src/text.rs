//! Foreign text in sentences for people.

/// Characters of a name from outside that a sentence shows, at most: of a file, a part, an action, a scan. Longer names push the sentence itself off the screen of a phone.
pub const MAX_SHOWN_NAME_CHARS: usize = 60;

/// Text from outside for a sentence: at most `max_chars` characters on one line, with those escaped that cannot be seen. Names in files, what clients
/// send, and errors of libraries, which quote both, come into a sentence only through this function.
pub fn legible(text: &str, max_chars: usize) -> String {
    let (mut shown, mut left) = (String::new(), max_chars);
    for letter in text.chars() {
        let start = shown.len();
        match letter {
            '"' | '\'' | '\\' => shown.push(letter),
            _ => shown.extend(letter.escape_debug()),
        }
        let Some(rest) = left.checked_sub(shown[start..].chars().count()) else {
            shown.truncate(start);
            shown.push('…');
            break;
        };
        left = rest;
    }
    shown
}

/// A whole number with its thousands apart: `1 234 567`, with spaces at which no line breaks.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut grouped = String::with_capacity(digits.len() * 2);
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            grouped.push('\u{a0}');
        }
        grouped.push(digit);
    }
    grouped
}

#[cfg(test)]
mod tests {
    use super::{grouped, legible};

    #[test]
    fn thousands_are_apart() {
        assert_eq!(
            [0, 999, 1_000, 1_234_567].map(grouped),
            ["0", "999", "1\u{a0}000", "1\u{a0}234\u{a0}567"]
        );
    }

    #[test]
    fn text_from_outside_fits_into_a_sentence() {
        assert_eq!(legible("/points", 10), "/points");
        assert_eq!(legible("the field `ä` is no \"b\"", 100), "the field `ä` is no \"b\"");
        assert_eq!(legible("a\nb\u{0}\u{7f}\u{202e}\u{2028}", 40), "a\\nb\\0\\u{7f}\\u{202e}\\u{2028}");
        assert_eq!(legible(&"x".repeat(1000), 3), "xxx…");
        assert_eq!(legible("ab\u{7f}", 7), "ab…");
        assert_eq!(legible("ab\u{7f}", 8), "ab\\u{7f}");
    }
}
