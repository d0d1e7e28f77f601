//! Numbers and dates as text.

use crate::format;
use vocab::{Stamp, Vec3};

#[test]
fn numbers_carry_units() {
    assert_eq!(format::distance(12.345), "12.3 m");
    assert_eq!(format::distance(1234.0), "1.23 km");
    assert_eq!(format::accuracy(0.014), "1.4 cm");
    assert_eq!(format::position(&Vec3::new(-0.04, 12.34, -5.0)), "0.0, 12.3, -5.0 m");
    assert_eq!(format::elapsed(3753.0), "1:02:33");
    assert_eq!(format::duration(7500.0), "2 h 05");
    assert_eq!([86_399.0, 86_400.0, 1e6].map(format::duration), ["1 day", "1 day", "12 days"]);
    assert_eq!(format::age(2.04), "2.0 s old");
    assert_eq!(format::points(2_345_678), "2.35 million");
    assert_eq!(format::bit_rate(1.84e6), "1.8 Mbit/s");
}

#[test]
fn dates_follow_the_calendar() {
    for (secs, expected) in [
        (0.0, "1 Jan 1970, 00:00"),
        (951_782_400.0, "29 Feb 2000, 00:00"),
        (1_709_251_140.0, "29 Feb 2024, 23:59"),
        (1_795_260_060.0, "21 Nov 2026, 11:21"),
        (-86_400.0, "31 Dec 1969, 00:00"),
    ] {
        assert_eq!(format::date(Stamp::from_secs_f64(secs), 0), expected);
    }
    assert_eq!(format::date(Stamp::EPOCH, -3600), "31 Dec 1969, 23:00");
}

#[test]
fn what_rounds_to_zero_has_no_sign() {
    assert_eq!(format::decimal(-0.004, 2), "0.00");
    assert_eq!(format::decimal(-0.006, 2), "-0.01");
    assert_eq!(format::decimal(-0.4, 0), "0");
    assert_eq!(format::distance(-0.01), "0.0 m");
}
