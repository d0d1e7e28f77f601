//! Where a cloud or a map lies in a map that is there already: found by what it looks like, or told by points picked in both.
//!
//! Both are level, so a heading and a place are all there is to find; what a robot was taught in the old map is true in the new one then.

use crate::failure::Failure;
use crate::keyframe_descriptors::read_keyframe_descriptors;
use geometry::{Isometry, Vector3, align_yaw_only, pose_from_isometry, rms_distance};
use localisation::{GlobalLocaliser, LocalisationMap};
use mapping::KeyframeDescriptor;
use nalgebra::Point3;
use serde::{Serialize, Serializer};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use store::SavedMap;

/// So many scans of the map are looked for at most, so far apart at least, metres.
const SCANS: usize = 60;
const SPACING: f64 = 1.0;
/// Two of them agree within this, metres.
const AGREE: f64 = 0.5;
/// As many have to agree, and another way may have such a share of them.
const AGREED: usize = 5;
const RIVAL: f64 = 0.5;
/// Picked points may be so far apart, metres: a hand's breadth is usual.
const PICKED: f64 = 0.5;
/// Nobody's site is larger, metres.
const FAR: f64 = 1e5;

/// The same point in the cloud and in the map: as the cloud's file has it, or the map that is moved, and as the map shows it, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// In the cloud.
    pub cloud: [f64; 3],
    /// In the map.
    pub map: [f64; 3],
}

/// How a cloud was aligned.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameAlignment {
    /// The map that it was found in.
    #[serde(skip_serializing_if = "Option::is_none")]
    map: Option<PathBuf>,
    /// Where the cloud lies: a file as read, less the offset, its z axis up; or a map.
    #[serde(serialize_with = "as_pose")]
    map_from_cloud: Isometry,
    /// Places recognised, or points picked, that agree on it.
    agreed: u64,
    /// How far they are apart, root mean square, metres.
    apart: f64,
}

/// Looks for a cloud, as it is seen from `seen`, in a map: each of that map's scans is looked for in the cloud, as a robot that is switched on
/// there would, and the alignment on which most of them agree is taken, if they are many and no other way has half as many.
/// Costs a fifth of a second for each scan asked, and says what share of them is done.
pub fn find(
    seen: Vec<(Isometry, KeyframeDescriptor)>,
    map: &Path,
    progress: &mut dyn FnMut(f64),
) -> Result<FrameAlignment, Failure> {
    // Only to say what is wrong with it, before much is done.
    let chosen = all_over(&SavedMap::read(map).map_err(Failure::usage)?.poses);
    let localiser = GlobalLocaliser::new(Arc::new(LocalisationMap::new(seen)));
    let mut votes = Vec::new();
    let scans = read_keyframe_descriptors(map, |keyframe| chosen.contains(&keyframe))?;
    for (scan, (map_from_base, place)) in scans.iter().enumerate() {
        progress(scan as f64 / scans.len() as f64);
        let found = localiser.find_poses(place, &map_from_base.rotation, None);
        let found = localiser.classify(&found).into_accepted();
        for one in found {
            let cloud_from_map = one.map_from_base * map_from_base.inverse();
            let place = (map_from_base.translation.vector, one.map_from_base.translation.vector);
            votes.push(Vote { scan, cloud_from_map, place });
        }
    }
    let (agreed, rival) = count(&votes);
    let refused = || Failure::failed(words(agreed.len(), rival, map));
    if agreed.len() < AGREED || rival as f64 > RIVAL * agreed.len() as f64 {
        return Err(refused());
    }
    let pairs: Vec<(Vector3, Vector3)> = agreed.iter().map(|vote| vote.place).collect();
    let aligned = aligned(&pairs).ok_or_else(refused)?;
    Ok(FrameAlignment { map: Some(map.to_owned()), ..aligned })
}

/// Where one of the map's scans may lie in the cloud.
struct Vote {
    scan: usize,
    cloud_from_map: Isometry,
    /// Of the scan, in the map and in the cloud.
    place: (Vector3, Vector3),
}

impl Vote {
    /// Whether both give the same alignment, as far as both scans' places show.
    fn agrees(&self, other: &Self) -> bool {
        let off = |one: &Self, by: &Self| {
            (by.cloud_from_map.transform_point(&Point3::from(one.place.0)).coords - one.place.1).norm()
        };
        off(self, other) <= AGREE && off(other, self) <= AGREE
    }
}

/// The votes that agree with the one with which most do, and how many agree on the best other way. Quadratic in the votes, some hundred.
fn count(votes: &[Vote]) -> (Vec<&Vote>, usize) {
    let all: Vec<&Vote> = votes.iter().collect();
    let Some((best, agreed)) = most(&all) else { return (Vec::new(), 0) };
    let others: Vec<&Vote> = all.into_iter().filter(|vote| !vote.agrees(best)).collect();
    (agreed, most(&others).map_or(0, |(_, agreed)| agreed.len()))
}

/// The vote with which those of most scans agree, and these: of each scan its best.
fn most<'a>(among: &[&'a Vote]) -> Option<(&'a Vote, Vec<&'a Vote>)> {
    let supported = among.iter().map(|of| {
        let mut agreed: Vec<&Vote> = among.iter().copied().filter(|vote| vote.agrees(of)).collect();
        agreed.dedup_by_key(|vote| vote.scan);
        (*of, agreed)
    });
    // The first of equals.
    supported.rev().max_by_key(|(_, agreed)| agreed.len())
}

/// Numbers of keyframes all over a map.
fn all_over(poses: &[Isometry]) -> BTreeSet<usize> {
    let (mut apart, mut last): (Vec<usize>, Option<Vector3>) = (Vec::new(), None);
    for (keyframe, pose) in poses.iter().enumerate() {
        let at = pose.translation.vector;
        if last.is_none_or(|last| (at - last).norm() >= SPACING) {
            last = Some(at);
            apart.push(keyframe);
        }
    }
    let every = apart.len().div_ceil(SCANS).max(1);
    apart.into_iter().step_by(every).collect()
}

/// By points that somebody picked; both z axes point up.
pub fn align_by_point_pairs(pairs: &[Pair]) -> Result<FrameAlignment, Failure> {
    let pairs: Vec<(Vector3, Vector3)> =
        pairs.iter().map(|pair| (Vector3::from(pair.map), Vector3::from(pair.cloud))).collect();
    let aligned = aligned(&pairs).ok_or_else(|| {
        Failure::usage("two --pair or more are needed, of points that are not above each other".to_owned())
    })?;
    let far = aligned.map_from_cloud.translation.vector.norm();
    if !(aligned.apart.is_finite() && far <= FAR) {
        let text = format!(
            "the pairs place the cloud farther away than {:.0} km; check their coordinates",
            FAR / 1e3
        );
        return Err(Failure::usage(text));
    }
    if aligned.apart > PICKED {
        return Err(Failure::usage(format!(
            "the pairs contradict each other: whichever way the cloud is laid, they stay {:.2} m apart in the mean; check their order, \
             and --up",
            aligned.apart
        )));
    }
    Ok(aligned)
}

impl FrameAlignment {
    /// Where the cloud lies.
    pub fn map_from_cloud(&self) -> &Isometry {
        &self.map_from_cloud
    }

    /// Moves points of the cloud, metres, into the map.
    pub fn move_points(&self, xyz: &mut [[f32; 3]]) {
        for point in xyz {
            let moved = self.map_from_cloud.transform_point(&Point3::from(point.map(f64::from)));
            *point = moved.coords.map(|coordinate| coordinate as f32).into();
        }
    }

    /// For people.
    pub fn describe(&self) -> String {
        let (by, place) = (self.agreed, self.map_from_cloud.translation);
        let where_to = format!("its origin lies at {:.2} {:.2} {:.2} m", place.x, place.y, place.z);
        match &self.map {
            Some(map) => format!(
                "found in {}: {by} places recognised, {:.3} m apart in the mean; {where_to}",
                map.display(),
                self.apart
            ),
            None => {
                format!("laid by {by} pairs of points, {:.3} m apart in the mean; {where_to}", self.apart)
            }
        }
    }
}

fn aligned(pairs: &[(Vector3, Vector3)]) -> Option<FrameAlignment> {
    let map_from_cloud = align_yaw_only(pairs)?;
    let apart = rms_distance(pairs, &map_from_cloud);
    Some(FrameAlignment { map: None, map_from_cloud, agreed: pairs.len() as u64, apart })
}

fn as_pose<S: Serializer>(motion: &Isometry, serializer: S) -> Result<S::Ok, S::Error> {
    pose_from_isometry(motion).serialize(serializer)
}

fn words(agreed: usize, rival: usize, map: &Path) -> String {
    let map = map.display();
    let remedy = "points picked in both (--pair) align it";
    if agreed < AGREED {
        format!("only {agreed} places of {map} were recognised in the cloud; {remedy}")
    } else {
        format!(
            "the cloud fits into {map} in two ways, with {agreed} and {rival} places recognised; {remedy}"
        )
    }
}

/// `X,Y,Z=X,Y,Z`.
pub fn pair(text: &str) -> Result<Pair, String> {
    let point = |text: &str| -> Option<[f64; 3]> {
        let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
        numbers.ok()?.try_into().ok().filter(|point: &[f64; 3]| point.iter().all(|c| c.is_finite()))
    };
    text.split_once('=')
        .and_then(|(cloud, map)| Some(Pair { cloud: point(cloud)?, map: point(map)? }))
        .ok_or_else(|| "a point and the same one in the other map are expected, like 12,3.5,0=1.2,4,0".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_read_or_refused() {
        let read = Pair { cloud: [1.0, -2.0, 3.5], map: [0.0, 0.0, 1e6] };
        assert_eq!(pair("1,-2,3.5=0,0,1000000"), Ok(read));
        for text in ["", "1,2,3", "1,2=3,4", "1,2,3=4,5,6,7", "a,2,3=4,5,6", "1,2,NaN=4,5,6"] {
            assert!(pair(text).is_err(), "{text}");
        }
    }
}
