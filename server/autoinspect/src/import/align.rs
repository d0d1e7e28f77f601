//! Where an imported cloud lies in a map that is there already: found by what it looks like, or told by points picked in both.
//!
//! Both are level, so a heading and a place are all there is to find; what a robot was taught in the old map is true in the new one then.

use super::Origin;
use crate::charts::chart_of;
use crate::failure::Failure;
use geometry::{Isometry, Vector3, isometry_from_pose, level_alignment, pose_from_isometry};
use mapping::vantage::{VantageOptions, Vantages};
use mapping::{Chart, Gates, Joint, Unrelated};
use nalgebra::Point3;
use serde::Serialize;
use std::path::{Path, PathBuf};
use store::{MapPoints, SavedMap};
use vocab::Pose;

/// Picked points may be so far apart, metres: a hand's breadth is usual.
const PICKED: f64 = 0.5;

/// The same point in the file and in the map: coordinates as the file has them, and as the map shows them, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    file: [f64; 3],
    map: [f64; 3],
}

/// How a cloud was aligned.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Aligned {
    /// The map that it was found in.
    #[serde(skip_serializing_if = "Option::is_none")]
    map: Option<PathBuf>,
    /// Where the cloud lies, as read, less the offset, its z axis up.
    map_from_cloud: Pose,
    /// Places recognised, or points picked, that agree on it.
    agreed: u64,
    /// How far they are apart, root mean square, metres.
    apart: f64,
}

/// Looks for what was imported in a map.
pub fn find(
    found: &Vantages,
    thinned: &MapPoints,
    options: &VantageOptions,
    map: &Path,
) -> Result<Aligned, Failure> {
    let saved = SavedMap::read(map).map_err(Failure::usage)?;
    let (mut chart, mut own) = (chart_of(&saved)?, chart_of_places(found, thinned, options));
    let joint = chart.join(&mut own, &Gates::default());
    let joint = joint.map_err(|unrelated| Failure::failed(words(&unrelated, map)))?;
    let Joint { links, support, .. } = joint;
    let pairs: Vec<(Vector3, Vector3)> = links
        .iter()
        .map(|link| {
            let there = saved.poses[link.from.0 as usize] * link.from_from_to;
            let here = found.places[link.to.0 as usize].map_from_base;
            (there.translation.vector, here.translation.vector)
        })
        .collect();
    let aligned = aligned(&pairs).ok_or_else(|| Failure::failed(words(&Unrelated::TooFew(support), map)))?;
    Ok(Aligned { map: Some(map.to_owned()), agreed: support as u64, ..aligned })
}

/// By points that somebody picked.
pub fn by_pairs(pairs: &[Pair], origin: &Origin) -> Result<Aligned, Failure> {
    let pairs: Vec<(Vector3, Vector3)> = pairs
        .iter()
        .map(|pair| {
            let near: [f64; 3] = std::array::from_fn(|axis| pair.file[axis] - origin.offset[axis]);
            let mut near = [near.map(|coordinate| coordinate as f32)];
            origin.up.turn(&mut near);
            (Vector3::from(pair.map), Vector3::from(near[0].map(f64::from)))
        })
        .collect();
    let aligned = aligned(&pairs).ok_or_else(|| {
        Failure::usage("two --pair or more are needed, of points that are not above each other".to_owned())
    })?;
    if aligned.apart > PICKED {
        return Err(Failure::usage(format!(
            "the pairs contradict each other: whichever way the cloud is laid, they stay {:.2} m apart in the mean; check their order, \
             and --up",
            aligned.apart
        )));
    }
    Ok(aligned)
}

impl Aligned {
    /// Moves all that was read into the map.
    pub fn apply(&self, clouds: [&mut MapPoints; 2], found: &mut Vantages) {
        let motion = isometry_from_pose(&self.map_from_cloud).unwrap_or_else(Isometry::identity);
        for cloud in clouds {
            for point in &mut cloud.xyz {
                let moved = motion.transform_point(&Point3::from(point.map(f64::from)));
                *point = moved.coords.map(|coordinate| coordinate as f32).into();
            }
        }
        for place in &mut found.places {
            place.map_from_base = motion * place.map_from_base;
        }
    }

    /// For people.
    pub fn describe(&self) -> String {
        let (by, place) = (self.agreed, self.map_from_cloud.position);
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

fn aligned(pairs: &[(Vector3, Vector3)]) -> Option<Aligned> {
    let motion = level_alignment(pairs)?;
    let square = |(there, here): &(Vector3, Vector3)| {
        (motion.transform_point(&Point3::from(*here)).coords - there).norm_squared()
    };
    let apart = (pairs.iter().map(square).sum::<f64>() / pairs.len() as f64).sqrt();
    let map_from_cloud = pose_from_isometry(&motion);
    Some(Aligned { map: None, map_from_cloud, agreed: pairs.len() as u64, apart })
}

/// The places to stand at, with what is seen from them.
fn chart_of_places(found: &Vantages, thinned: &MapPoints, options: &VantageOptions) -> Chart {
    let mut chart = Chart::default();
    for place in &found.places {
        let seen = super::seen_from(place, thinned);
        chart.push(&place.map_from_base, &seen, [0.0, 0.0, options.lidar_height]);
    }
    chart
}

fn words(unrelated: &Unrelated, map: &Path) -> String {
    let map = map.display();
    let remedy = "pick points in both, and give them with --pair";
    match unrelated {
        Unrelated::TooFew(count) => {
            format!("only {count} places of the cloud were recognised in {map}; {remedy}")
        }
        Unrelated::Ambiguous(count, rival) => format!(
            "the cloud fits into {map} in two ways, with {count} and {rival} places recognised; {remedy}"
        ),
    }
}

/// `X,Y,Z=X,Y,Z`.
pub fn pair(text: &str) -> Result<Pair, String> {
    let point = |text: &str| -> Option<[f64; 3]> {
        let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
        numbers.ok()?.try_into().ok().filter(|point: &[f64; 3]| point.iter().all(|c| c.is_finite()))
    };
    text.split_once('=')
        .and_then(|(file, map)| Some(Pair { file: point(file)?, map: point(map)? }))
        .ok_or_else(|| {
            "a point of the file and the same one in the map are expected, like 12,3.5,0=1.2,4,0".into()
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_read_or_refused() {
        let read = Pair { file: [1.0, -2.0, 3.5], map: [0.0, 0.0, 1e6] };
        assert_eq!(pair("1,-2,3.5=0,0,1000000"), Ok(read));
        for text in ["", "1,2,3", "1,2=3,4", "1,2,3=4,5,6,7", "a,2,3=4,5,6", "1,2,NaN=4,5,6"] {
            assert!(pair(text).is_err(), "{text}");
        }
    }
}
