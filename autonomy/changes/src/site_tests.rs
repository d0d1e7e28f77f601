//! Two visits of a simulated site between which loose objects have changed. The benchmark `changes` scores many more of them.

use crate::{Change, ChangesConfig, SensorView, UprightBox, Visit, detect_changes};
use geometry::{RngTree, Vector3};
use sim::{LooseObject, LooseObjectsConfig, ObjectChange, SimulatedSite, SiteName};
use std::f64::consts::TAU;

const COLUMNS: u32 = 300;
/// Objects are looked at from places along the round that are at most this far away, metres.
const WITHIN_M: f64 = 8.0;

fn place(object: &LooseObject) -> UprightBox {
    UprightBox { centre_m: object.middle(), size_m: object.size_m, yaw_rad: object.yaw_rad }
}

/// Places of the sensor along the round, 2 m apart.
fn viewpoints(site: &SimulatedSite) -> Vec<Vector3> {
    let round = site.route("round").expect("a round");
    let mut at = Vector3::new(round.start.position.x, round.start.position.y, 0.7);
    let mut places = Vec::new();
    for [x, y] in &round.waypoints {
        let along = Vector3::new(*x, *y, 0.7) - at;
        let steps = (along.norm() / 2.0).ceil().max(1.0);
        places.extend((0..steps as usize).map(|step| at + along * (step as f64 / steps)));
        at += along;
    }
    places
}

/// Sweeps from these places, with the noise of a LiDAR.
fn visit(site: &SimulatedSite, places: &[Vector3], seed: u64) -> Visit {
    let mut rng = RngTree::new(seed).child("visit").rng();
    let mut visit = Visit::default();
    for sensor in places {
        let first_rad = rng.uniform() * TAU;
        let mut points = Vec::new();
        for column in 0..COLUMNS {
            let azimuth = first_rad + f64::from(column) / f64::from(COLUMNS) * TAU;
            for elevation_deg in -16..=15 {
                let (up, flat) = f64::from(elevation_deg).to_radians().sin_cos();
                let along = Vector3::new(flat * azimuth.cos(), flat * azimuth.sin(), up);
                if let Some((range_m, _)) = site.cast_ray(sensor, &along, 25.0) {
                    let point = sensor + along * (range_m + 0.01 * rng.normal());
                    points.push(point.map(|at| at as f32).into());
                }
            }
        }
        visit.views.push(SensorView { sensor: *sensor, points });
    }
    visit
}

#[test]
fn objects_that_changed_at_a_simulated_site_are_found_and_nothing_else_is() {
    // Without small ones: 300 columns are too few for them.
    let objects = LooseObjectsConfig { small_share: 0.0, ..LooseObjectsConfig::default() };
    let site = SimulatedSite::new(SiteName::B1).with_loose_objects(1, 4, &objects);
    let changes = site.random_changes(2, 3, &objects);
    let ends = |change: &ObjectChange| match *change {
        ObjectChange::Put(object) => (None, Some(place(&object))),
        ObjectChange::Taken(object) => (Some(place(&object)), None),
        ObjectChange::Moved { from, to } | ObjectChange::Turned { from, to } => {
            (Some(place(&from)), Some(place(&to)))
        }
    };
    let places: Vec<UprightBox> =
        changes.iter().flat_map(|change| <[_; 2]>::from(ends(change))).flatten().collect();
    let is_near = |at: &Vector3| places.iter().any(|place| (place.centre_m - at).norm() < WITHIN_M);
    let viewpoints: Vec<Vector3> = viewpoints(&site).into_iter().filter(is_near).collect();
    let (before, after) = (visit(&site, &viewpoints, 3), visit(&site.with_changes(&changes), &viewpoints, 4));
    let found = detect_changes(&before, &after, &ChangesConfig::default()).objects;
    let is_at = |a: &UprightBox, b: &UprightBox| (a.centre_m - b.centre_m).norm() < 0.3;
    for change in &changes {
        let is_found = |object: &&crate::ChangedObject| match (&object.change, ends(change)) {
            (Change::Appeared, (None, Some(to))) => is_at(&object.place, &to),
            (Change::Removed, (Some(from), None)) => is_at(&object.place, &from),
            (Change::Moved { from: was }, (Some(from), Some(to))) => {
                is_at(was, &from) && is_at(&object.place, &to)
            }
            _ => false,
        };
        let named: Vec<_> = found.iter().map(|object| (object.change, object.place)).collect();
        assert!(found.iter().any(|object| is_found(&object)), "{change:?} is not among {named:#?}");
    }
    assert_eq!(found.len(), changes.len());
    let same = detect_changes(&before, &visit(&site, &viewpoints, 5), &ChangesConfig::default());
    assert_eq!(same.objects, [], "nothing has changed");
}
