//! Maps of other people's programs, read whole: counts, offsets, and what is refused. The files are not part of the repository.

#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

use formats::SurveyLimits;
use formats::survey::{self, Survey};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

fn folder() -> Option<PathBuf> {
    let root = std::env::var_os("AUTOINSPECT_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from);
    let folder = root.join("map-import");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: test data {} is not there; set AUTOINSPECT_DATA to its parent", folder.display());
    None
}

fn read(path: &Path) -> Survey {
    let mut last = 0.0;
    let survey = survey::read(path, SurveyLimits::NONE, &mut |done| {
        assert!((last..=1.0).contains(&done), "{}: {done} after {last}", path.display());
        last = done;
    });
    survey.unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn every_survey_has_its_known_points() {
    let Some(folder) = folder() else { return };
    for (name, stations, points, unusable) in [
        ("hilti-uzh-prior-map.laz", 1, 2_782_624, 0),
        ("indoor.laz", 1, 808_042, 0),
        ("lone-star.laz", 1, 518_862, 0),
        ("simple.las", 1, 1_065, 0),
        ("simple.laz", 1, 1_065, 0),
        ("1.2-with-color.las", 1, 1_065, 0),
        ("interesting.las", 1, 1_065, 0),
        ("100-points.las", 1, 100, 0),
        ("extrabytes.las", 1, 1_065, 0),
        ("pdrf6-1.4.las", 1, 1_024, 0),
        ("pdrf8-1.4.laz", 1, 1_024, 0),
        ("pdrf7-v4-1.4.laz", 1, 1_024, 0),
        ("test_tree.las", 1, 11_631, 0),
        ("1.2-with-color.ptx", 1, 1_065, 0),
        ("autzen-utm.pcd", 1, 1_065, 0),
        ("automotive_ring_timestamp_compressed.pcd", 1, 80_787, 0),
        ("bunnyInt32.e57", 1, 30_571, 0),
        ("bunnyFloat.e57", 1, 30_571, 0),
        ("tinyCartesianFloatRgb.e57", 1, 2_090, 0),
        ("tiny_spherical.e57", 1, 180, 180),
        ("tiny_pc_and_images.e57", 1, 2, 0),
        ("scaled_integer_intensity.e57", 1, 2, 0),
        ("cartesian_invalid_state_single.e57", 1, 1, 2),
        ("empty_pc.e57", 1, 0, 0),
        ("empty.e57", 0, 0, 0),
        ("malformed/spurious.las", 1, 1_065, 0),
        ("malformed/bad-geotiff-keys.las", 1, 10, 0),
        ("malformed/read_error.e57", 1, 2_651, 0),
    ] {
        let survey = read(&folder.join(name));
        let found = (survey.stations.len(), survey.points(), survey.unusable);
        assert_eq!(found, (stations, points, unusable), "{name}");
    }
}

#[test]
fn unreadable_files_are_refused_at_once_with_a_sentence() {
    let Some(folder) = folder() else { return };
    for (name, words) in [
        ("malformed/corrupt_crc.e57", "E57"),
        ("malformed/garbage_nVariableLength.las", "do not fit"),
        ("../trajectories/freiburg1_xyz-groundtruth.txt", "begins like no"),
    ] {
        let began = Instant::now();
        let problem = survey::read(&folder.join(name), SurveyLimits::NONE, &mut |_| {})
            .map(|s| s.points())
            .unwrap_err()
            .to_string();
        eprintln!("{name}: {problem}");
        assert!(problem.contains(words) && !problem.contains('\n'), "{name}: {problem}");
        assert!(began.elapsed() < Duration::from_secs(2), "{name}");
    }
}

#[test]
fn far_coordinates_keep_their_millimetres() {
    let Some(folder) = folder() else { return };
    let [las, laz, text] =
        ["1.2-with-color.las", "simple.laz", "1.2-with-color.ptx"].map(|name| read(&folder.join(name)));
    assert!(las.offset[0] > 600_000.0 && las.offset == text.offset && las.offset == laz.offset);
    for (a, b) in las.stations[0].xyz.iter().zip(&text.stations[0].xyz) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3), "{a:?} {b:?}");
    }
}
