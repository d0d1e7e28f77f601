//! Names in the order people expect: `scan2` before `scan10`.

use std::cmp::Ordering;

/// Compares runs of digits by value and everything else by character.
pub fn compare(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a.as_bytes(), b.as_bytes());
    loop {
        let (Some(first_a), Some(first_b)) = (a.first(), b.first()) else {
            return a.len().cmp(&b.len());
        };
        let order = if first_a.is_ascii_digit() && first_b.is_ascii_digit() {
            let (digits_a, digits_b);
            (digits_a, a) = split_digits(a);
            (digits_b, b) = split_digits(b);
            digits_a.len().cmp(&digits_b.len()).then_with(|| digits_a.cmp(digits_b))
        } else {
            let order = first_a.cmp(first_b);
            (a, b) = (&a[1..], &b[1..]);
            order
        };
        if order != Ordering::Equal {
            return order;
        }
    }
}

/// The leading digits without leading zeros, and the rest.
fn split_digits(text: &[u8]) -> (&[u8], &[u8]) {
    let end = text.iter().position(|c| !c.is_ascii_digit()).unwrap_or(text.len());
    let (digits, rest) = text.split_at(end);
    let zeros = digits.iter().position(|c| *c != b'0').unwrap_or(digits.len());
    (&digits[zeros..], rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_count_by_value() {
        let mut names = vec!["scan10.pcd", "scan2.pcd", "scan1.pcd", "a9", "a10", "000010", "9", "x"];
        names.sort_by(|a, b| compare(a, b));
        assert_eq!(names, ["9", "000010", "a9", "a10", "scan1.pcd", "scan2.pcd", "scan10.pcd", "x"]);
    }
}
