//! Tests of `autoinspect changes`: objects that differ between two visits.

use crate::program::{data, json, refused, text};
use serde_json::Value;
use std::fs;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|number| number.as_f64().expect("a number")).collect()
}

/// Whether an object is where a box of the truth is: its centre within 0.2 m, its extent along each axis within 20 %.
fn is_at(found: &Value, truth: &Value) -> bool {
    let (found_m, truth_m) = (numbers(&found["centre_m"]), numbers(&truth["centre_m"]));
    let distance_m = found_m.iter().zip(&truth_m).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    // The length of a found box is its longer side.
    let mut size_m = numbers(&truth["size_m"]);
    size_m[..2].sort_by(|a, b| b.total_cmp(a));
    let sizes = numbers(&found["size_m"]).into_iter().zip(size_m);
    distance_m <= 0.2 && sizes.into_iter().all(|(found, truth)| (found - truth).abs() <= 0.2 * truth)
}

fn of_kind<'a>(document: &'a Value, kind: &str) -> Vec<&'a Value> {
    document["objects"].as_array().expect("objects").iter().filter(|object| object["kind"] == kind).collect()
}

#[test]
fn boxes_that_were_put_into_recorded_walks_are_found_and_nothing_else_is() {
    let Some(sessions) = data("change-lidar-inserted") else { return };
    let dir = tempfile::tempdir().expect("temporary directory");
    let session = |name: &str| sessions.join(name);
    let (before, after) = (session("session_a"), session("session_b"));
    let printed = json(&["changes", text(&before), text(&after), "--out", text(dir.path())]);
    let written = fs::read_to_string(dir.path().join("changes.json")).expect("written");
    assert_eq!(printed, serde_json::from_str::<Value>(&written).expect("JSON"));
    let truth: Value =
        serde_json::from_str(&fs::read_to_string(session("truth.json")).expect("truth")).expect("JSON");
    let mut matched = 0;
    for kind in ["appeared", "removed"] {
        for expected in truth[kind].as_array().expect("a list") {
            let is_found = of_kind(&printed, kind).into_iter().any(|object| is_at(object, expected));
            // Of a box with fewer points not enough is seen.
            assert!(is_found || expected["points"].as_u64() < Some(150), "{kind}: {expected}\n{printed:#}");
            matched += usize::from(is_found);
        }
    }
    for expected in truth["moved"].as_array().expect("a list") {
        let is_same =
            |object: &&Value| is_at(object, &expected["to"]) && is_at(&object["from"], &expected["from"]);
        assert!(of_kind(&printed, "moved").iter().any(is_same), "{expected}\n{printed:#}");
        matched += 1;
    }
    assert_eq!(printed["objects"].as_array().expect("objects").len(), matched, "something else: {printed:#}");
    for number in 1..=matched {
        assert!(dir.path().join(format!("object-{number}.ply")).is_file());
    }
    let again = json(&["changes", text(&before), text(&before)]);
    assert_eq!(again["objects"].as_array().map(Vec::len), Some(0), "a visit compared with itself");
}

#[test]
fn visits_that_cannot_be_compared_are_refused_with_a_sentence() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let walk = dir.path().join("walk.mcap");
    let fixed = ["sim", "record", "--site", "b1", "--route", "short", "--columns", "50", "--minutes", "0.05"];
    json(&[&fixed[..], &["--out", text(&walk)]].concat());
    let sentence = refused(&["changes", text(&walk), text(&walk)]);
    assert!(sentence.contains("holds no poses"), "{sentence}");
    let nothing = dir.path().join("nothing.mcap");
    assert!(refused(&["changes", text(&nothing), text(&walk)]).contains("nothing.mcap"));
}

/// A labelled object of the tabletop data, or a found one, at a place of one of the two images.
struct TablePlace {
    /// 0: in the image before, 1: in the one after.
    image: usize,
    centre_m: Vec<f64>,
}

impl TablePlace {
    fn distance_m(&self, other: &Self) -> f64 {
        let squares = self.centre_m.iter().zip(&other.centre_m).map(|(a, b)| (a - b).powi(2));
        if self.image == other.image { squares.sum::<f64>().sqrt() } else { f64::INFINITY }
    }
}

/// The places that a document of changes names: one that is gone is in the image before, a new one in the image after, one that was moved in both.
fn found_places(document: &Value) -> Vec<TablePlace> {
    let mut places = Vec::new();
    for object in document["objects"].as_array().expect("objects") {
        let image = usize::from(object["kind"] != "removed");
        places.push(TablePlace { image, centre_m: numbers(&object["centre_m"]) });
        if let Some(from) = object.get("from") {
            places.push(TablePlace { image: 0, centre_m: numbers(&from["centre_m"]) });
        }
    }
    places
}

/// The labelled objects of a pair of images with one of these states.
fn labelled_places(pair: &Value, states: &[&str]) -> Vec<TablePlace> {
    let mut places = Vec::new();
    for (image, list) in ["objects_in_A", "objects_in_B"].into_iter().enumerate() {
        for object in pair[list].as_array().expect("a list") {
            if states.iter().any(|state| object["state"] == *state) {
                places.push(TablePlace { image, centre_m: numbers(&object["centroid_m"]) });
            }
        }
    }
    places
}

#[test]
fn objects_that_changed_on_a_table_are_found_in_recorded_depth_images() {
    let Some(images) = data("change-rgbd-tabletop") else { return };
    let truth = fs::read_to_string(images.join("truth.json")).expect("truth");
    let truth: Value = serde_json::from_str(&truth).expect("JSON");
    let dir = tempfile::tempdir().expect("temporary directory");
    let (mut changed, mut found, mut named, mut right) = (0_usize, 0_usize, 0_usize, 0_usize);
    for pair in truth["pairs"].as_array().expect("pairs") {
        let file =
            |place: usize| images.join(format!("{}.pcd", pair["pair"][place].as_str().expect("a name")));
        let (before, after) = (file(0), file(1));
        let document = json(&["changes", text(&before), text(&after), "--out", text(dir.path())]);
        let places = found_places(&document);
        // The centre of the points that a camera sees of an object is half of its depth before its middle.
        let is_near = |a: &TablePlace, b: &TablePlace| a.distance_m(b) <= 0.06;
        let is_met = |one: &TablePlace, others: &[TablePlace]| others.iter().any(|other| is_near(one, other));
        // All labelled objects of the data are larger than 5 cm.
        let expected = labelled_places(pair, &["changed"]);
        changed += expected.len();
        found += expected.iter().filter(|place| is_met(place, &places)).count();
        // Objects whose state the truth leaves open count neither way.
        let unclear = labelled_places(pair, &["ambiguous"]);
        let counted: Vec<&TablePlace> =
            places.iter().filter(|place| is_met(place, &expected) || !is_met(place, &unclear)).collect();
        named += counted.len();
        right += counted.into_iter().filter(|place| is_met(place, &expected)).count();
        let same = json(&["changes", text(&before), text(&before)]);
        assert_eq!(same["objects"].as_array().map(Vec::len), Some(0), "an image compared with itself");
    }
    println!("{found} of {changed} changed objects found; {right} of {named} named places are right");
    assert!(changed > 0 && found as f64 >= 0.9 * changed as f64, "{found} of {changed} found");
    assert!(right as f64 >= 0.9 * named as f64, "{right} of {named} right");
}

#[test]
fn clouds_that_are_no_images_of_one_camera_are_refused_with_a_sentence() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let row = dir.path().join("row.pcd");
    let header = "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n\
                  VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n0 0 1\n1 0 1\n";
    fs::write(&row, header).expect("written");
    assert!(refused(&["changes", text(&row), text(&row)]).contains("is not organised"));
    assert!(refused(&["changes", text(&row), text(dir.path())]).contains("is not; give two"));
    let cut = dir.path().join("cut.pcd");
    fs::write(&cut, &header[..header.len() - 12]).expect("written");
    assert!(refused(&["changes", text(&cut), text(&cut)]).contains("cut.pcd"));
    let image = dir.path().join("image.pcd");
    let few = header.replace("WIDTH 2\nHEIGHT 1", "WIDTH 2\nHEIGHT 2").replace("POINTS 2", "POINTS 4");
    fs::write(&image, few + "0 1 1\n1 1 1\n").expect("written");
    assert!(refused(&["changes", text(&image), text(&image)]).contains("only 4 pixels have a return"));
}
