//! A known map as localisation uses it: its surfaces, and the free space that its keyframes saw.

use crate::tiled_surfaces::{Keyframes, TiledSurfaces, TiledSurfacesConfig};
use geometry::Isometry;
use mapping::KeyframeDescriptor;
use mapping::range_image::Occupancy;
use nalgebra::Point3;

/// Parameters of [`LocalisationMap`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LocalisationMapConfig {
    /// Parameters of the surfaces.
    pub surfaces: TiledSurfacesConfig,
    /// Parameters of the free-space check.
    pub free_space: FreeSpaceCheckConfig,
}

/// Parameters of [`LocalisationMap::check_free_space`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeSpaceCheckConfig {
    /// Greatest distance of a compared keyframe from the robot, metres. Chosen: as the submaps' ([`mapping::submap::SubmapConfig::radius_m`]).
    pub radius_m: f64,
    /// Greatest height difference of a compared keyframe from the robot, metres. Less than a storey. Chosen: half a storey, so that a ramp is compared and another floor
    /// is not.
    pub max_height_difference_m: f64,
    /// Number of compared keyframes, the nearest. Chosen: views from several sides; the time is in proportion.
    pub max_keyframes: usize,
    /// Number of points of the scan that are compared with them, spread evenly. Chosen: a share of violations of 0.1 is then known to 0.015 (binomial standard
    /// deviation).
    pub max_points: usize,
}

impl Default for FreeSpaceCheckConfig {
    fn default() -> Self {
        Self { radius_m: 8.0, max_height_difference_m: 1.5, max_keyframes: 4, max_points: 400 }
    }
}

/// Result of comparing the points of a scan with the range images of the nearest keyframes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FreeSpaceCheck {
    /// Points on a surface that a keyframe saw as well.
    pub consistent: usize,
    /// Points where at least one keyframe saw free space and none saw a surface.
    pub violations: usize,
}

impl FreeSpaceCheck {
    /// Points that the keyframes can decide on. Points that none of them sees are in neither count.
    pub fn decided(&self) -> usize {
        self.consistent + self.violations
    }

    /// Share of violations among the points that the keyframes can decide on; 0 if there are none (equation 4).
    pub fn violation_share(&self) -> f64 {
        self.violations as f64 / self.decided().max(1) as f64
    }
}

/// A known map.
#[derive(Debug)]
pub struct LocalisationMap {
    config: LocalisationMapConfig,
    surfaces: TiledSurfaces,
    keyframes: Keyframes,
}

impl LocalisationMap {
    /// A map of these keyframes with default parameters, see [`Self::with_config`].
    pub fn new(keyframes: Vec<(Isometry, KeyframeDescriptor)>) -> Self {
        Self::with_config(LocalisationMapConfig::default(), keyframes)
    }

    /// A map of these keyframes, each with its pose in the map. Linear in their points, some 2 ns each, because surfaces are built only when they are
    /// first looked up.
    pub fn with_config(
        config: LocalisationMapConfig,
        keyframes: Vec<(Isometry, KeyframeDescriptor)>,
    ) -> Self {
        let keyframes = Keyframes::from(keyframes);
        Self {
            config,
            surfaces: TiledSurfaces::new(config.surfaces, Keyframes::clone(&keyframes)),
            keyframes,
        }
    }

    /// Its surfaces.
    pub fn surfaces(&self) -> &TiledSurfaces {
        &self.surfaces
    }

    /// Its keyframes, each with its pose in the map.
    pub fn keyframes(&self) -> &[(Isometry, KeyframeDescriptor)] {
        &self.keyframes
    }

    /// Compares a scan's points (base frame, metres) with the range images of the nearest keyframes. The search for those is linear in the keyframes.
    pub fn check_free_space(&self, map_from_base: &Isometry, points: &[[f32; 3]]) -> FreeSpaceCheck {
        let views: Vec<_> = self
            .nearest_keyframes(map_from_base)
            .into_iter()
            .map(|keyframe| {
                let (map_from_keyframe, descriptor) = &self.keyframes[keyframe];
                let keyframe_from_base = map_from_keyframe.inverse() * map_from_base;
                (keyframe_from_base.cast::<f32>(), descriptor.view())
            })
            .collect();
        let mut check = FreeSpaceCheck::default();
        for point in points.iter().step_by(points.len().div_ceil(self.config.free_space.max_points).max(1)) {
            let at = Point3::from(*point);
            let sights = || {
                views
                    .iter()
                    .map(|(keyframe_from_base, view)| view.classify(&(keyframe_from_base * at).into()))
            };
            if sights().any(|sight| sight == Occupancy::Occupied) {
                check.consistent += 1;
            } else if sights().any(|sight| sight == Occupancy::Free) {
                check.violations += 1;
            }
        }
        check
    }

    /// Indices of the keyframes nearest to the robot, the nearest first.
    fn nearest_keyframes(&self, map_from_base: &Isometry) -> Vec<usize> {
        let config = &self.config.free_space;
        let offsets =
            self.keyframes.iter().map(|(pose, _)| pose.translation.vector - map_from_base.translation.vector);
        let mut near: Vec<(f64, usize)> = offsets
            .enumerate()
            .filter(|(_, offset)| {
                offset.norm() <= config.radius_m && offset.z.abs() <= config.max_height_difference_m
            })
            .map(|(keyframe, offset)| (offset.norm(), keyframe))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.truncate(config.max_keyframes);
        near.into_iter().map(|(_, keyframe)| keyframe).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{at, room_keyframe, rooms};

    /// A ring of points around the LiDAR, at its height.
    fn ring(radius_m: f32) -> Vec<[f32; 3]> {
        (0..400_u16)
            .map(|step| {
                let (sin, cos) = (f32::from(step) * std::f32::consts::TAU / 400.0).sin_cos();
                [radius_m * cos, radius_m * sin, 0.0]
            })
            .collect()
    }

    #[test]
    fn points_on_walls_are_consistent_and_points_before_them_violate_free_space() {
        let map = LocalisationMap::new(vec![room_keyframe(&rooms(), 4.0, 5.0, 0.0)]);
        let pose = at(4.0, 5.0, 0.0);
        let own: Vec<[f32; 3]> = map.keyframes()[0].1.points().collect();
        let same = map.check_free_space(&pose, &own);
        assert!(same.violation_share() < 0.02 && same.consistent > 100, "{same:?}");
        let obstacle = map.check_free_space(&pose, &ring(1.0));
        assert!(obstacle.violation_share() > 0.8 && obstacle.violations > 100, "{obstacle:?}");
    }

    #[test]
    fn keyframes_far_away_or_on_another_storey_decide_nothing() {
        let map = LocalisationMap::new(vec![room_keyframe(&rooms(), 4.0, 5.0, 0.0)]);
        let mut above = at(4.0, 5.0, 0.0);
        above.translation.vector.z = 1.6;
        for pose in [at(12.1, 5.0, 0.0), above] {
            assert_eq!(map.check_free_space(&pose, &ring(1.0)), FreeSpaceCheck::default());
        }
        assert_eq!(FreeSpaceCheck::default().violation_share(), 0.0);
    }
}
