//! Depth images of a table, compared with the labels of their objects.

use anyhow::{Context, Result};
use changes::{Change, DepthChangesConfig, DepthImage, UprightBox, detect_depth_changes};
use formats::pcd;
use nalgebra::Point3;
use serde::Deserialize;
use std::fs;
use std::path::Path;

/// A named place is that of a labelled object if they are at most this far apart, metres: the centre of the points that a camera sees is before the middle of the object.
const NEAR_M: f64 = 0.06;

/// Numbers of objects. Those whose state the truth leaves open are not counted.
#[derive(Clone, Copy, Debug, Default)]
pub struct TableScore {
    pub pairs: usize,
    /// Labelled objects that changed, and those of them that are found.
    pub changed: usize,
    pub found: usize,
    /// Places that are named, and those of them at which something changed.
    pub named: usize,
    pub right: usize,
}

#[derive(Deserialize)]
struct Truth {
    pairs: Vec<Pair>,
}

#[derive(Deserialize)]
struct Pair {
    pair: [String; 2],
    #[serde(rename = "objects_in_A")]
    before: Vec<Labelled>,
    #[serde(rename = "objects_in_B")]
    after: Vec<Labelled>,
}

#[derive(Deserialize)]
struct Labelled {
    centroid_m: [f64; 3],
    state: String,
}

/// A place in the image before (0) or after (1), metres, in the camera's frame.
type Place = (usize, Point3<f64>);

/// Scores all pairs of a folder.
///
/// # Errors
/// When its files cannot be read.
pub fn score(folder: &Path) -> Result<TableScore> {
    let path = folder.join("truth.json");
    let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let truth: Truth = serde_json::from_str(&text)?;
    let mut total = TableScore::default();
    for pair in &truth.pairs {
        let [before, after] = [read(folder, &pair.pair[0])?, read(folder, &pair.pair[1])?];
        let places = places(&before, &after)?;
        let (changed, unclear) = (labelled(pair, "changed"), labelled(pair, "ambiguous"));
        let counted: Vec<&Place> =
            places.iter().filter(|place| is_met(place, &changed) || !is_met(place, &unclear)).collect();
        total.pairs += 1;
        total.changed += changed.len();
        total.found += changed.iter().filter(|place| is_met(place, &places)).count();
        total.named += counted.len();
        total.right += counted.iter().filter(|place| is_met(place, &changed)).count();
    }
    Ok(total)
}

fn read(folder: &Path, name: &str) -> Result<DepthImage> {
    let path = folder.join(format!("{name}.pcd"));
    let bytes = fs::read(&path).with_context(|| path.display().to_string())?;
    let table = pcd::read(&bytes)?;
    Ok(DepthImage::new(table.grid(), table.positions()?, table.colours())?)
}

/// The places that a comparison names.
fn places(before: &DepthImage, after: &DepthImage) -> Result<Vec<Place>> {
    let found = detect_depth_changes(before, after, &DepthChangesConfig::default())?;
    let centre = |place: &UprightBox| found.camera_from_support * Point3::from(place.centre_m);
    let mut places = Vec::new();
    for object in &found.changes.objects {
        match &object.change {
            Change::Appeared => places.push((1, centre(&object.place))),
            Change::Removed => places.push((0, centre(&object.place))),
            Change::Moved { from } => places.extend([(0, centre(from)), (1, centre(&object.place))]),
        }
    }
    Ok(places)
}

fn labelled(pair: &Pair, state: &str) -> Vec<Place> {
    [&pair.before, &pair.after]
        .into_iter()
        .enumerate()
        .flat_map(|(image, objects)| objects.iter().map(move |object| (image, object)))
        .filter(|(_, object)| object.state == state)
        .map(|(image, object)| (image, Point3::from(object.centroid_m)))
        .collect()
}

fn is_met(place: &Place, others: &[Place]) -> bool {
    others.iter().any(|other| other.0 == place.0 && (other.1 - place.1).norm() <= NEAR_M)
}
