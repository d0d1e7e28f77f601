//! Files of changes: they are read as they were written, and every mistake gives one sentence.

use crate::SiteChanges;
use sim::{ConditionChange, ConditionChangesConfig, LooseObjectsConfig, SimulatedSite, SiteName};
use std::fs;

const EXAMPLE: &str = r#"{
  "version": 1,
  "changes": [
    { "kind": "door", "hinge_m": [50.1, 6.7, 0], "turn_deg": 60 },
    { "kind": "leak", "at_m": [5, 5, 0], "radius_m": 0.4, "liquid": "water", "warmer_k": 12 },
    { "kind": "gauge-drift", "tag": "PI-101", "per_day": 0.05, "begun_days_ago": 30 },
    { "kind": "gauge-stuck", "tag": "TI-104", "value": 61 },
    { "kind": "object-put", "foot_m": [7, 5, 0], "size_m": [0.6, 0.4, 1], "material": "wood" }
  ]
}"#;

#[test]
fn changes_are_read_made_and_written_as_truth_that_is_a_script_again() {
    let site = SimulatedSite::new(SiteName::B1);
    let changes = SiteChanges::parse(EXAMPLE.as_bytes()).unwrap();
    let changed = changes.apply(&site).unwrap();
    let truth = SiteChanges::of(&changed);
    assert_eq!((truth.objects.len(), truth.conditions.len()), (1, 4));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("truth.json");
    truth.write(&file).unwrap();
    let again = SiteChanges::read(&file).unwrap().apply(&site).unwrap();
    assert_eq!(again.loose_objects(), changed.loose_objects());
    assert_eq!(again.condition_changes()[1..], changed.condition_changes()[1..]);
    let door = |site: &SimulatedSite| match &site.condition_changes()[0] {
        ConditionChange::DoorTurned { turn_rad, .. } => turn_rad.to_degrees(),
        other => panic!("{other:?}"),
    };
    assert!((door(&again) - 60.0).abs() < 1e-9 && (door(&changed) - 60.0).abs() < 1e-9);
}

#[test]
fn random_changes_survive_a_file() {
    let site = SimulatedSite::new(SiteName::Plant).with_loose_objects(1, 2, &LooseObjectsConfig::default());
    let conditions = site.random_condition_changes(3, 8, &ConditionChangesConfig::default());
    let truth = SiteChanges { conditions, ..SiteChanges::of(&site) };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("truth.json");
    truth.write(&file).unwrap();
    let again = SiteChanges::read(&file).unwrap();
    assert_eq!((again.objects.len(), again.conditions.len()), (2, 8));
    let lamps_and_gauges = |changes: &SiteChanges| {
        let is_exact = |change: &&ConditionChange| !matches!(change, ConditionChange::DoorTurned { .. });
        changes.conditions.iter().filter(is_exact).cloned().collect::<Vec<_>>()
    };
    assert_eq!(lamps_and_gauges(&again), lamps_and_gauges(&truth));
}

/// The sentence about a file with this list of changes.
fn sentence(changes: &str) -> String {
    let text = format!(r#"{{"version": 1, "changes": [{changes}]}}"#);
    match SiteChanges::parse(text.as_bytes()) {
        Err(reason) => reason,
        Ok(changes) => changes.apply(&SimulatedSite::new(SiteName::B1)).unwrap_err(),
    }
}

#[test]
fn mistakes_are_told_in_one_sentence() {
    for (changes, expected) in [
        (r#"{"kind": "fire"}"#, "unknown variant `fire`"),
        (r#"{"kind": "lamp-out", "at_m": [1, 2, 3], "colour": 3}"#, "unknown field `colour`"),
        (r#"{"kind": "lamp-out"}"#, "missing field `at_m`"),
        (r#"{"kind": "lamp-out", "at_m": [1e300, 2, 3]}"#, "change 1: a point is farther than 10000 m"),
        (r#"{"kind": "lamp-out", "at_m": [1e999, 2, 3]}"#, "it cannot be understood"),
        (r#"{"kind": "lamp-out", "at_m": [5, 5, 900]}"#, "no lamp is within 1 m of (5.00, 5.00, 900.00)"),
        (r#"{"kind": "door", "hinge_m": [5, 5, 0], "turn_deg": 9}"#, "no door has its hinge within 0.5 m"),
        (r#"{"kind": "door", "hinge_m": [50.1, 6.7, 0], "turn_deg": 1e9}"#, "the angle of a door"),
        (
            r#"{"kind": "gauge-stuck", "tag": "PI-999", "value": 1}"#,
            "no gauge has the tag \"PI-999\": take one of PI-101",
        ),
        (
            r#"{"kind": "leak", "at_m": [5, 5, 2], "radius_m": 0.4, "liquid": "oil"}"#,
            "the leak at (5.00, 5.00, 2.00) is on no surface",
        ),
        (r#"{"kind": "leak", "at_m": [5, 5, 0], "radius_m": -4, "liquid": "oil"}"#, "the radius of a leak"),
        (
            r#"{"kind": "leak", "at_m": [5, 5, 0], "radius_m": 1, "liquid": "mercury"}"#,
            "unknown variant `mercury`",
        ),
        (
            r#"{"kind": "object-put", "foot_m": [5, 5, 0], "size_m": [1, 0, 1], "material": "wood"}"#,
            "a side of an object",
        ),
        (
            r#"{"kind": "object-put", "foot_m": [5, 5, 0], "size_m": [1, 1, 1], "material": "cheese"}"#,
            "there is no material \"cheese\"",
        ),
        (
            r#"{"kind": "gauge-stuck", "tag": "PI-101", "value": 1}, {"kind": "gauge-drift", "tag": "PI-101", "per_day": 1}"#,
            "the gauge PI-101 is changed twice",
        ),
    ] {
        let told = sentence(changes);
        assert!(told.contains(expected), "{changes}: {told}");
        assert!(!told.contains('\n'), "{told}");
    }
    let many = vec![r#"{"kind": "gauge-stuck", "tag": "x", "value": 1}"#; 1001].join(",");
    assert!(sentence(&many).contains("more than 1000 changes"));
    for (text, expected) in [
        (&b""[..], "it cannot be understood: EOF"),
        (b"[]", "it cannot be understood"),
        (b"\xff\xfe", "it cannot be understood"),
        (br#"{"changes": []}"#, "missing field `version`"),
        (br#"{"version": 7, "rooms": 3}"#, "it has version 7, and this program reads version 1"),
        (br#"{"version": 1, "changes": [], "rooms": 3}"#, "unknown field `rooms`"),
    ] {
        let told = SiteChanges::parse(text).unwrap_err();
        assert!(told.contains(expected), "{told}");
    }
    let deep = "[".repeat(100_000);
    assert!(SiteChanges::parse(deep.as_bytes()).is_err());
    assert!(SiteChanges::parse(&vec![b' '; 2 << 20]).is_err());
    let folder = tempfile::tempdir().unwrap();
    let told = SiteChanges::read(&folder.path().join("none.json")).unwrap_err().to_string();
    assert!(told.contains("none.json: it cannot be read"), "{told}");
}

#[test]
fn a_file_that_is_cut_or_has_a_wrong_byte_gives_a_sentence_or_changes() {
    let site = SimulatedSite::new(SiteName::Twins);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("changes.json");
    for at in 0..EXAMPLE.len() {
        assert!(SiteChanges::parse(&EXAMPLE.as_bytes()[..at]).is_err(), "cut at {at}");
        for byte in [b'0', b'-', b'"', b'}', 0, 0xff] {
            let mut bytes = EXAMPLE.as_bytes().to_vec();
            bytes[at] = byte;
            // Neither panics; what can be read is for a site that has none of this.
            if let Err(reason) = SiteChanges::parse(&bytes) {
                assert!(!reason.is_empty() && !reason.contains('\n'), "{reason}");
            }
        }
    }
    fs::write(&file, EXAMPLE).unwrap();
    let told = SiteChanges::read(&file).unwrap().apply(&site).unwrap_err();
    assert!(told.contains("no door has its hinge"), "{told}");
}
