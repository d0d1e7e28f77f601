//! A survey as it was read: the stations of a scanner with their points.

use super::coordinate_offset::CoordinateOffset;
use vocab::{Pose, Vec3};

/// A survey of a site.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Survey {
    /// Subtracted from all coordinates of the file, metres.
    pub offset: [f64; 3],
    /// One for each station of the scanner; a single one if the file has no stations.
    pub stations: Vec<Station>,
    /// Number of points left out: not finite, or without a return.
    pub unusable: usize,
}

/// The points of one station, or the whole cloud.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Station {
    /// As written in the file.
    pub name: Option<String>,
    /// Pose of the scanner in the file's frame without the offset. None if the file does not say; the points are then in that
    /// frame.
    pub survey_from_station: Option<Pose>,
    /// Metres.
    pub xyz: Vec<[f32; 3]>,
    /// In the file's units, one for each point, or empty.
    pub intensity: Vec<f32>,
}

impl Survey {
    /// Usable points of all stations.
    pub fn points(&self) -> usize {
        self.stations.iter().map(|station| station.xyz.len()).sum()
    }
}

/// A station with its pose. `xyz` is in its own frame, less the offset `local`. Some programs write points in the survey's frame and a scanner at its
/// origin. If points are far from the scanner, its pose is therefore unknown.
pub(super) fn station_with_pose(
    survey_from_station: &Pose,
    local: &CoordinateOffset,
    mut xyz: Vec<[f32; 3]>,
    intensity: Vec<f32>,
    coordinate_offset: &mut CoordinateOffset,
) -> Station {
    let [x, y, z] = rotate(&survey_from_station.orientation, local.offset());
    let place = survey_from_station.position;
    let origin = Vec3::new(place.x + x, place.y + y, place.z + z);
    coordinate_offset.decide(&[[origin.x, origin.y, origin.z]]);
    let position = coordinate_offset.relative(origin);
    let orientation = survey_from_station.orientation;
    if local.offset() == [0.0; 3] {
        let survey_from_station = Some(Pose { position, orientation });
        return Station { name: None, survey_from_station, xyz, intensity };
    }
    for point in &mut xyz {
        let [x, y, z] = rotate(&orientation, point.map(f64::from));
        *point = [position.x + x, position.y + y, position.z + z].map(|coordinate| coordinate as f32);
    }
    Station { name: None, survey_from_station: None, xyz, intensity }
}

fn rotate(q: &vocab::Quat, v: [f64; 3]) -> [f64; 3] {
    let axis = [q.x, q.y, q.z];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let turn = cross(axis, v).map(|c| 2.0 * c);
    let second = cross(axis, turn);
    std::array::from_fn(|i| v[i] + q.w * turn[i] + second[i])
}
