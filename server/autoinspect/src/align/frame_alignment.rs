//! Aligns a cloud or a map with the frame of an existing map, by recognising scans or from picked point pairs.
//!
//! Both are level, so only a heading and a translation are unknown. Goals and docks of the existing map stay valid in the new one.

use crate::failure::Failure;
use crate::keyframe_descriptors::read_keyframe_descriptors;
use crate::{summaries, texts};
use geometry::{Isometry, Vector3, align_yaw_only, pose_from_isometry, rms_distance};
use localisation::{GlobalLocaliser, LocalisationMap};
use mapping::KeyframeDescriptor;
use nalgebra::Point3;
use serde::{Serialize, Serializer};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use store::SavedMap;

/// Parameters of [`find_alignment`] and [`align_point_pairs`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlignmentConfig {
    /// Largest number of the map's scans that are searched for in the cloud. Each search takes 0.2 s. Chosen: the search then takes some 12 s at most.
    pub max_scans: usize,
    /// Smallest distance between these scans, metres. Chosen: the distance of keyframes; nearer ones see the same.
    pub scan_spacing_m: f64,
    /// Two scans agree on an alignment if their alignments move the position of each by at most this distance, metres. Chosen: half of [`Self::scan_spacing_m`], and as
    /// for poses that count as one in the verification of loops ([`mapping::VerificationConfig::distinct_m`]).
    pub agreement_distance_m: f64,
    /// Number of scans that must agree on the alignment. Chosen: fewer may agree by chance in a building that repeats.
    pub min_agreeing_scans: usize,
    /// Largest ratio of the scans of the best other alignment to those of the best one. Chosen: as for maps that are merged
    /// ([`mapping::MapMatcherConfig::max_runner_up_share`]).
    pub max_other_share: f64,
    /// Greatest root mean square distance of picked points after the alignment, metres: [`api::MAX_PAIR_RMS_M`], which the client checks too.
    pub max_pair_rms_m: f64,
    /// Greatest distance by which picked points may move a cloud, metres. A greater one means mistyped coordinates. Chosen: 100 km, more than the extent of a local
    /// system of coordinates.
    pub max_distance_m: f64,
}

impl Default for AlignmentConfig {
    fn default() -> Self {
        Self {
            max_scans: 60,
            scan_spacing_m: 1.0,
            agreement_distance_m: 0.5,
            min_agreeing_scans: 5,
            max_other_share: 0.5,
            max_pair_rms_m: api::MAX_PAIR_RMS_M,
            max_distance_m: 1e5,
        }
    }
}

/// The same point in the cloud and in the map, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointPair {
    /// In the cloud's file, or in the map that is moved.
    pub cloud: [f64; 3],
    /// In the existing map.
    pub map: [f64; 3],
}

/// The alignment of a cloud with a map, and its evidence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameAlignment {
    /// The map in which it was recognised; `None` for picked points.
    #[serde(skip_serializing_if = "Option::is_none")]
    map: Option<PathBuf>,
    /// Pose of the cloud in the map. The cloud's frame is that of the file, less the offset, with z up; or that of a map.
    #[serde(serialize_with = "serialize_pose")]
    map_from_cloud: Isometry,
    /// Number of scans or picked points that agree on it.
    #[serde(rename = "agreed")]
    agreeing: u64,
    /// Root mean square distance between them after the alignment, metres.
    #[serde(rename = "apart")]
    rms_m: f64,
}

/// Recognises a map's scans in a cloud and returns the alignment on which most of them agree.
///
/// - `cloud`: descriptors of the cloud's viewpoints with their poses in the cloud.
/// - `map`: folder of the existing map. Each of its scans is localised globally in the cloud, like a robot that is switched on there.
/// - `progress`: called with the share of scans done, 0 to 1.
///
/// # Errors
/// When the map cannot be read, too few scans are recognised, or another alignment has nearly as many.
pub fn find_alignment(
    cloud: Vec<(Isometry, KeyframeDescriptor)>,
    map: &Path,
    config: &AlignmentConfig,
    progress: &mut dyn FnMut(f64),
) -> Result<FrameAlignment, Failure> {
    // Read first, so that a damaged map is reported before the long computation.
    let chosen = spread_keyframes(&SavedMap::read(map).map_err(Failure::usage)?.poses, config);
    let localiser = GlobalLocaliser::new(Arc::new(LocalisationMap::new(cloud)));
    let mut votes = Vec::new();
    let scans = read_keyframe_descriptors(map, |keyframe| chosen.contains(&keyframe))?;
    for (scan, (map_from_base, descriptor)) in scans.iter().enumerate() {
        progress(scan as f64 / scans.len() as f64);
        let found = localiser.find_poses(descriptor, &map_from_base.rotation, None);
        let found = localiser.classify(&found).into_accepted();
        for hypothesis in found {
            let cloud_from_map = hypothesis.map_from_base * map_from_base.inverse();
            let in_map = map_from_base.translation.vector;
            let in_cloud = hypothesis.map_from_base.translation.vector;
            votes.push(AlignmentVote { scan, cloud_from_map, in_map, in_cloud });
        }
    }
    let (agreeing, others) = count_votes(&votes, config);
    let too_few = || Failure::failed(texts::too_few_scans_recognised(map, agreeing.len()));
    if agreeing.len() < config.min_agreeing_scans {
        return Err(too_few());
    }
    if others as f64 > config.max_other_share * agreeing.len() as f64 {
        return Err(Failure::failed(texts::ambiguous_alignment(map, agreeing.len(), others)));
    }
    let pairs: Vec<(Vector3, Vector3)> = agreeing.iter().map(|vote| (vote.in_map, vote.in_cloud)).collect();
    let alignment = align(&pairs).ok_or_else(too_few)?;
    Ok(FrameAlignment { map: Some(map.to_owned()), ..alignment })
}

/// One possible alignment, from one of the map's scans.
struct AlignmentVote {
    scan: usize,
    cloud_from_map: Isometry,
    /// Position of the scan in the map.
    in_map: Vector3,
    /// Position of the scan in the cloud.
    in_cloud: Vector3,
}

impl AlignmentVote {
    /// Whether both alignments are the same at the positions of both scans.
    fn agrees(&self, other: &Self, config: &AlignmentConfig) -> bool {
        let distance = |scan: &Self, by: &Self| {
            (by.cloud_from_map.transform_point(&Point3::from(scan.in_map)).coords - scan.in_cloud).norm()
        };
        distance(self, other) <= config.agreement_distance_m
            && distance(other, self) <= config.agreement_distance_m
    }
}

/// The votes for the alignment with most scans, and the number of scans for the best other one. Cost: quadratic in the votes, about a hundred.
fn count_votes<'a>(votes: &'a [AlignmentVote], config: &AlignmentConfig) -> (Vec<&'a AlignmentVote>, usize) {
    let all: Vec<&AlignmentVote> = votes.iter().collect();
    let Some((best, agreeing)) = best_supported(&all, config) else { return (Vec::new(), 0) };
    let others: Vec<&AlignmentVote> = all.into_iter().filter(|vote| !vote.agrees(best, config)).collect();
    (agreeing, best_supported(&others, config).map_or(0, |(_, agreeing)| agreeing.len()))
}

/// The vote that agrees with votes of the most scans, and these votes: the best one of each scan.
fn best_supported<'a>(
    among: &[&'a AlignmentVote],
    config: &AlignmentConfig,
) -> Option<(&'a AlignmentVote, Vec<&'a AlignmentVote>)> {
    let supported = among.iter().map(|vote| {
        let mut agreeing: Vec<&AlignmentVote> =
            among.iter().copied().filter(|other| other.agrees(vote, config)).collect();
        agreeing.dedup_by_key(|vote| vote.scan);
        (*vote, agreeing)
    });
    // Of equal votes the first is taken.
    supported.rev().max_by_key(|(_, agreeing)| agreeing.len())
}

/// Numbers of keyframes that are spread over the whole map.
fn spread_keyframes(poses: &[Isometry], config: &AlignmentConfig) -> BTreeSet<usize> {
    let (mut spaced, mut last): (Vec<usize>, Option<Vector3>) = (Vec::new(), None);
    for (keyframe, pose) in poses.iter().enumerate() {
        let at = pose.translation.vector;
        if last.is_none_or(|last| (at - last).norm() >= config.scan_spacing_m) {
            last = Some(at);
            spaced.push(keyframe);
        }
    }
    let every = spaced.len().div_ceil(config.max_scans).max(1);
    spaced.into_iter().step_by(every).collect()
}

/// The alignment that brings picked points together; both z axes point up.
///
/// # Errors
/// When the pairs do not determine an alignment, contradict each other, or are too far apart.
pub fn align_point_pairs(pairs: &[PointPair], config: &AlignmentConfig) -> Result<FrameAlignment, Failure> {
    let pairs: Vec<(Vector3, Vector3)> =
        pairs.iter().map(|pair| (Vector3::from(pair.map), Vector3::from(pair.cloud))).collect();
    let alignment = align(&pairs).ok_or_else(|| Failure::usage(texts::TOO_FEW_PAIRS))?;
    let distance_m = alignment.map_from_cloud.translation.vector.norm();
    if !(alignment.rms_m.is_finite() && distance_m <= config.max_distance_m) {
        return Err(Failure::usage(texts::pairs_too_far(config.max_distance_m / 1e3)));
    }
    if alignment.rms_m > config.max_pair_rms_m {
        return Err(Failure::usage(texts::pairs_contradict(alignment.rms_m)));
    }
    Ok(alignment)
}

impl FrameAlignment {
    /// Pose of the cloud in the map.
    pub fn map_from_cloud(&self) -> &Isometry {
        &self.map_from_cloud
    }

    /// Transforms points of the cloud, metres, into the map.
    pub fn transform_points(&self, xyz: &mut [[f32; 3]]) {
        for point in xyz {
            let moved = self.map_from_cloud.transform_point(&Point3::from(point.map(f64::from)));
            *point = moved.coords.map(|coordinate| coordinate as f32).into();
        }
    }

    /// A description for people.
    pub fn describe(&self) -> String {
        let origin_m = self.map_from_cloud.translation.vector.into();
        summaries::cloud_aligned(self.map.as_deref(), self.agreeing, self.rms_m, origin_m)
    }
}

/// The level alignment of `pairs`: points in the map and in the cloud.
fn align(pairs: &[(Vector3, Vector3)]) -> Option<FrameAlignment> {
    let map_from_cloud = align_yaw_only(pairs)?;
    let rms_m = rms_distance(pairs, &map_from_cloud);
    Some(FrameAlignment { map: None, map_from_cloud, agreeing: pairs.len() as u64, rms_m })
}

fn serialize_pose<S: Serializer>(motion: &Isometry, serializer: S) -> Result<S::Ok, S::Error> {
    pose_from_isometry(motion).serialize(serializer)
}

/// Parses `X,Y,Z=X,Y,Z`.
pub fn parse_point_pair(text: &str) -> Result<PointPair, String> {
    let point = |text: &str| -> Option<[f64; 3]> {
        let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
        numbers.ok()?.try_into().ok().filter(|point: &[f64; 3]| point.iter().all(|c| c.is_finite()))
    };
    text.split_once('=')
        .and_then(|(cloud, map)| Some(PointPair { cloud: point(cloud)?, map: point(map)? }))
        .ok_or_else(|| texts::INVALID_PAIR.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_parsed_or_rejected() {
        let read = PointPair { cloud: [1.0, -2.0, 3.5], map: [0.0, 0.0, 1e6] };
        assert_eq!(parse_point_pair("1,-2,3.5=0,0,1000000"), Ok(read));
        for text in ["", "1,2,3", "1,2=3,4", "1,2,3=4,5,6,7", "a,2,3=4,5,6", "1,2,NaN=4,5,6"] {
            assert!(parse_point_pair(text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_alignment_with_most_scans_is_chosen_and_the_next_best_is_counted() {
        let config = AlignmentConfig::default();
        let vote = |scan: usize, offset: f64| {
            let in_map = Vector3::new(scan as f64, 0.0, 0.0);
            let shift = Vector3::new(0.0, offset, 0.0);
            let cloud_from_map = Isometry::translation(0.0, offset, 0.0);
            AlignmentVote { scan, cloud_from_map, in_map, in_cloud: in_map + shift }
        };
        let votes = [vote(0, 3.0), vote(1, 3.1), vote(1, 9.0), vote(2, 2.9), vote(3, 9.2)];
        let (agreeing, others) = count_votes(&votes, &config);
        assert_eq!((agreeing.len(), others), (3, 2));
        assert!(count_votes(&[], &config).0.is_empty());
    }
}
