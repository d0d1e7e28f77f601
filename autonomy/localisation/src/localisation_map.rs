//! A known map as the tracker uses it.

use crate::tiled_surfaces::{Keyframes, TiledSurfaces};
use geometry::Isometry;
use mapping::KeyframeDescriptor;
use mapping::range_image::Occupancy;
use nalgebra::Point3;
use points::GaussianMapConfig;

/// Keyframes so near to the robot, metres, so many at most, are asked what they saw, and vertically so near.
const ASKED_WITHIN: f64 = 8.0;
const ASKED: usize = 4;
const LEVEL: f64 = 1.5;
/// Points asked about.
const POINTS: usize = 400;

/// Fewer points of which the keyframes can speak than this say nothing: dense scans hide most of what is behind their nearest points.
const SPOKEN_OF: usize = 20;

/// SurfaceMap and sight of a known map.
#[derive(Debug)]
pub struct LocalisationMap {
    surfaces: TiledSurfaces,
    keyframes: Keyframes,
}

/// What the keyframes about a place saw where a scan's points are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FreeSpaceCheck {
    /// Points on something that they saw.
    pub agreed: usize,
    /// Points where one of them saw through and none saw anything.
    pub through: usize,
}

impl FreeSpaceCheck {
    /// Share of the points of which the keyframes can speak that stand where they saw through.
    pub fn share(&self) -> f64 {
        self.through as f64 / (self.agreed + self.through).max(1) as f64
    }

    /// The same, if those points are enough to say anything.
    pub fn contradicted(&self) -> Option<f64> {
        (self.agreed + self.through >= SPOKEN_OF).then(|| self.share())
    }
}

impl LocalisationMap {
    /// Of keyframes, each with its pose in the map. Linear in their points, some 2 ns each: surfaces are made where they are first looked
    /// at.
    pub fn new(keyframes: Vec<(Isometry, KeyframeDescriptor)>) -> Self {
        let config = GaussianMapConfig { min_points: 6, ..GaussianMapConfig::default() };
        let keyframes = Keyframes::from(keyframes);
        Self { surfaces: TiledSurfaces::new(config, Keyframes::clone(&keyframes)), keyframes }
    }

    /// Its surfaces.
    pub fn surfaces(&self) -> &TiledSurfaces {
        &self.surfaces
    }

    /// Its keyframes.
    pub fn keyframes(&self) -> &[(Isometry, KeyframeDescriptor)] {
        &self.keyframes
    }

    /// What the nearest keyframes saw where points (base frame, metres) are. Linear in the keyframes, for finding those.
    pub fn sightings(&self, map_from_base: &Isometry, points: &[[f32; 3]]) -> FreeSpaceCheck {
        let views: Vec<_> = self
            .nearest(map_from_base)
            .into_iter()
            .map(|keyframe| {
                let (map_from_keyframe, place) = &self.keyframes[keyframe];
                let keyframe_from_base = map_from_keyframe.inverse() * map_from_base;
                (keyframe_from_base.cast::<f32>(), place.view())
            })
            .collect();
        let mut sightings = FreeSpaceCheck::default();
        for point in points.iter().step_by(points.len().div_ceil(POINTS).max(1)) {
            let at = Point3::from(*point);
            let looks = || views.iter().map(|(turn, view)| view.classify(&(turn * at).into()));
            if looks().any(|sight| sight == Occupancy::Occupied) {
                sightings.agreed += 1;
            } else if looks().any(|sight| sight == Occupancy::Free) {
                sightings.through += 1;
            }
        }
        sightings
    }

    /// The keyframes nearest to the robot.
    fn nearest(&self, map_from_base: &Isometry) -> Vec<usize> {
        let offsets =
            self.keyframes.iter().map(|(pose, _)| pose.translation.vector - map_from_base.translation.vector);
        let mut near: Vec<(f64, usize)> = offsets
            .enumerate()
            .filter(|(_, offset)| offset.norm() <= ASKED_WITHIN && offset.z.abs() <= LEVEL)
            .map(|(keyframe, offset)| (offset.norm(), keyframe))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.truncate(ASKED);
        near.into_iter().map(|(_, keyframe)| keyframe).collect()
    }
}
