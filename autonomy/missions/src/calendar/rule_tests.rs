//! Rules against another implementation: `rules.txt` holds what python-dateutil makes of the examples of RFC 5545 and of random rules.

use super::civil::{date_of, day_number, local_of, minute_number};
use super::*;
use proptest::prelude::*;
use site_model::{LocalDate, LocalDateTime, LocalTime};

fn local(text: &str) -> LocalDateTime {
    let number = |range: std::ops::Range<usize>| text[range].parse().expect("digits");
    LocalDateTime {
        date: LocalDate { year: text[0..4].parse().expect("digits"), month: number(4..6), day: number(6..8) },
        time: LocalTime { hour: number(9..11), minute: number(11..13) },
    }
}

fn rules() -> Vec<(LocalDateTime, &'static str, Vec<LocalDateTime>)> {
    let lines = include_str!("rules.txt").lines().filter(|line| !line.starts_with('#'));
    let rule = |line: &'static str| {
        let parts: Vec<&str> = line.split('|').collect();
        (local(parts[0]), parts[1], parts[2].split_whitespace().map(local).collect())
    };
    lines.map(rule).collect()
}

#[test]
fn rules_have_the_slots_that_another_implementation_finds() {
    let mut differing = Vec::new();
    let rules = rules();
    for (first, text, expected) in &rules {
        let rule = RecurrenceRule::parse(*first, text).unwrap_or_else(|error| panic!("{text}: {error}"));
        let limit = minute_number(*first) + 365 * 20 * 24 * 60;
        let slots: Vec<_> = rule
            .slots_after(minute_number(*first) - 1)
            .take_while(|slot| minute_number(*slot) < limit)
            .take(14)
            .collect();
        if slots != *expected {
            differing.push(format!("{first:?} {text}:\n  {slots:?}\n  {expected:?}"));
        }
    }
    assert!(
        rules.len() > 280 && differing.is_empty(),
        "{} of {}:\n{}",
        differing.len(),
        rules.len(),
        differing.join("\n")
    );
}

#[test]
fn slots_after_an_instant_are_the_rest_of_all_slots() {
    for (first, text, expected) in rules() {
        let rule = RecurrenceRule::parse(first, text).expect("parsed above");
        for (index, slot) in expected.iter().enumerate() {
            let rest = &expected[index + 1..];
            let found: Vec<_> = rule.slots_after(minute_number(*slot)).take(rest.len()).collect();
            assert_eq!(found, rest, "{text} after {slot:?}");
        }
    }
}

#[test]
fn what_is_wrong_with_a_rule_is_said() {
    let first = local("20261124T1100");
    let error = |text: &str| RecurrenceRule::parse(first, text).expect_err("wrong").to_string();
    assert_eq!(error("BYDAY=MO"), "the rule has no FREQ");
    assert_eq!(error("FREQ=DAILY;BYDAY=XX"), "BYDAY cannot be \"XX\"");
    assert_eq!(error("FREQ=DAILY;INTERVAL=0"), "INTERVAL cannot be \"0\"");
    assert_eq!(error("FREQ=DAILY;COUNT=3;UNTIL=20270101"), "COUNT and UNTIL exclude each other");
    assert_eq!(error("FREQ=DAILY;FREQ=DAILY"), "the part FREQ occurs twice");
    assert_eq!(error("FREQ=DAILY;MOON=FULL"), "recurrence rules have no part MOON");
    assert_eq!(error("FREQ=SECONDLY"), "slots have whole minutes; FREQ=SECONDLY cannot be used");
    assert_eq!(error("FREQ=WEEKLY;BYDAY=1MO"), "FREQ and numbers in BYDAY exclude each other");
    assert!(error("every day").contains("is not a part of a recurrence rule"));
    assert!(RecurrenceRule::parse(first, "RRULE:freq=weekly;byday=mo,fr").is_ok());
    assert_eq!(error("FREQ=DAILY;UNTIL=2026"), "UNTIL cannot be \"2026\"");
    assert_eq!(error("FREQ=DAILY;BYDAY=é1MO"), "BYDAY cannot be \"É1MO\"".replace('É', "é"));
}

#[test]
fn rules_that_never_fit_end() {
    let first = local("20261124T1100");
    for text in [
        "FREQ=YEARLY;BYMONTH=2;BYMONTHDAY=30",
        "FREQ=MINUTELY;INTERVAL=2;BYMINUTE=1",
        "FREQ=HOURLY;INTERVAL=24;BYHOUR=3",
    ] {
        let rule = RecurrenceRule::parse(first, text).expect("a rule");
        assert_eq!(rule.slots_after(minute_number(first)).next(), None, "{text}");
    }
}

proptest! {
    #[test]
    fn days_have_numbers_and_back(number in -700_000_i64..2_900_000) {
        let date = date_of(number);
        prop_assert!(date.is_valid());
        prop_assert_eq!(day_number(date), number);
        let minute = number * 1440 + number.rem_euclid(1440);
        prop_assert_eq!(minute_number(local_of(minute)), minute);
    }

    #[test]
    fn any_text_is_a_rule_or_an_error(text in "[A-Z=;,0-9+éT:-]{0,60}") {
        let first = local("20261124T1100");
        if let Ok(rule) = RecurrenceRule::parse(first, &text) {
            let slots: Vec<_> = rule.slots_after(minute_number(first)).take(3).collect();
            prop_assert!(slots.is_sorted());
        }
    }

    #[test]
    fn parts_put_together_are_a_rule_or_an_error(
        parts in proptest::collection::vec(prop_oneof![
            Just("FREQ=DAILY"), Just("FREQ=YEARLY"), Just("FREQ=MINUTELY"), Just("INTERVAL=7"), Just("BYDAY=MO,-1FR"),
            Just("BYMONTHDAY=31,-1"), Just("BYSETPOS=-1"), Just("BYWEEKNO=53"), Just("BYHOUR=25"), Just("COUNT=2"),
            Just("UNTIL=20270101T000000Z"), Just("BYMONTH=2"), Just("BYMINUTE=59"),
        ], 0..6),
    ) {
        let first = local("20261124T1100");
        if let Ok(rule) = RecurrenceRule::parse(first, &parts.join(";")) {
            let slots: Vec<_> = rule.slots_after(minute_number(first)).take(3).collect();
            prop_assert!(slots.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
