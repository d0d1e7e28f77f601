//! Joins the points of a survey to one cloud, thins it, and describes viewpoints in it.

use formats::survey::Station;
use geometry::{Isometry, Vector3, isometry_from_pose};
use mapping::KeyframeDescriptor;
use mapping::virtual_viewpoint::{ViewpointConfig, VirtualViewpoint, VirtualViewpoints};
use points::Downsampler;
use store::{CloudViewpoint, MapPoints, visible_points};

/// Joins all points in the survey's frame.
pub fn gather_points(stations: Vec<Station>) -> MapPoints {
    let mut all = MapPoints::default();
    for Station { survey_from_station, mut xyz, mut intensity, .. } in stations {
        if let Some(pose) = survey_from_station.as_ref().and_then(isometry_from_pose) {
            for point in &mut xyz {
                let placed = pose.rotation * Vector3::from(point.map(f64::from)) + pose.translation.vector;
                *point = placed.map(|coordinate| coordinate as f32).into();
            }
        }
        intensity.resize(xyz.len(), 0.0);
        if all.xyz.is_empty() {
            all = MapPoints { xyz, intensity };
        } else {
            all.xyz.append(&mut xyz);
            all.intensity.append(&mut intensity);
        }
    }
    all
}

/// One averaged point, position and intensity, for each voxel of edge `spacing_m`.
pub fn thin(points: &MapPoints, spacing_m: f32) -> MapPoints {
    let mut centroids = Vec::new();
    Downsampler::default().downsample(&points.xyz, &points.intensity, spacing_m, &mut centroids);
    MapPoints {
        xyz: centroids.iter().map(|centroid| centroid.xyz).collect(),
        intensity: centroids.iter().map(|centroid| centroid.attribute).collect(),
    }
}

/// Lowest and highest corner of the box around all points, metres.
pub fn bounds(xyz: &[[f32; 3]]) -> [[f32; 3]; 2] {
    let of = |pick: fn(f32, f32) -> f32| {
        std::array::from_fn(|axis| xyz.iter().map(|point| point[axis]).reduce(pick).unwrap_or(0.0))
    };
    [of(f32::min), of(f32::max)]
}

/// Descriptors of the simulated scan at each viewpoint, with the viewpoint's pose in the cloud.
pub fn describe_viewpoints(
    found: &VirtualViewpoints,
    cloud: &MapPoints,
    config: &ViewpointConfig,
) -> Vec<(Isometry, KeyframeDescriptor)> {
    let mut downsampler = Downsampler::default();
    let describe = |place: &VirtualViewpoint| {
        let viewpoint = stored_viewpoint(place, config);
        let xyz = visible_points(&viewpoint, &cloud.xyz);
        let rotation = &place.map_from_base.rotation;
        let descriptor = KeyframeDescriptor::new(&xyz, rotation, viewpoint.lidar, &mut downsampler);
        (place.map_from_base, descriptor)
    };
    found.viewpoints.iter().map(describe).collect()
}

/// The viewpoints in the form of the store, one after the other.
pub fn stored_viewpoints(
    found: &VirtualViewpoints,
    config: &ViewpointConfig,
) -> impl ExactSizeIterator<Item = CloudViewpoint> {
    found.viewpoints.iter().map(|place| stored_viewpoint(place, config))
}

fn stored_viewpoint(place: &VirtualViewpoint, config: &ViewpointConfig) -> CloudViewpoint {
    CloudViewpoint {
        cloud_from_base: place.map_from_base,
        lidar: [0.0, 0.0, config.lidar_height_m],
        visible: place.visible.iter().collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::{Pose, Quat, Vec3};

    #[test]
    fn scans_with_poses_are_joined_to_one_cloud() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turned = Pose {
            position: Vec3::new(10.0, 0.0, 0.0),
            orientation: Quat { w: half, x: 0.0, y: 0.0, z: half },
        };
        let station = |pose, intensity| Station {
            name: None,
            survey_from_station: pose,
            xyz: vec![[1.0, 2.0, 3.0]],
            intensity,
        };
        let all = gather_points(vec![station(None, vec![7.0]), station(Some(turned), Vec::new())]);
        assert_eq!(all.intensity, [7.0, 0.0]);
        let differs = |point: [f32; 3], expected: [f32; 3]| {
            (0..3).any(|axis| (point[axis] - expected[axis]).abs() > 1e-5)
        };
        assert!(
            !differs(all.xyz[0], [1.0, 2.0, 3.0]) && !differs(all.xyz[1], [8.0, 1.0, 3.0]),
            "{:?}",
            all.xyz
        );
        assert_eq!(bounds(&all.xyz)[0], [1.0, 1.0, 3.0]);
    }

    #[test]
    fn thinning_averages_positions_and_intensities() {
        let points = MapPoints {
            xyz: vec![[0.01, 0.0, 0.0], [0.03, 0.0, 0.0], [5.0, 0.0, 0.0]],
            intensity: vec![1.0, 3.0, 7.0],
        };
        let thinned = thin(&points, 0.1);
        assert_eq!(thinned.intensity, [2.0, 7.0]);
        assert!((thinned.xyz[0][0] - 0.02).abs() < 1e-6);
    }
}
