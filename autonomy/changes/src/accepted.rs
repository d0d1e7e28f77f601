//! Changes that people accept as the new normal: the points that a map loses and gains by them.

use crate::ray_image::RayImage;
use crate::surfaces::{SurfaceTolerance, Surfaces};
use crate::{Change, ChangesConfig, ObservedChange, UprightBox, Visit};
use geometry::Vector3;
use points::hash::{CellKey, CellTable};

/// Parameters of [`AcceptedChanges`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcceptedChangesConfig {
    /// Points this far outside of a box still belong to its object, metres. Boxes leave out the outermost points. Chosen: twice the noise of a range and of a pose together.
    pub margin_m: f64,
    /// Points lower than this above the lower side of a box belong to the ground, metres. Chosen: as the noise of a range.
    pub ground_m: f64,
    /// A point farther than this from everything that the visits saw is gone even if no ray went through it, metres: rays reach only some of the places where the object was.
    /// Chosen: some four times [`ChangesConfig::same_surface_m`].
    pub far_m: f32,
    /// Of the points that are added, one in each cell of this edge is taken, metres. As fine as the clouds of keyframes.
    pub cell_m: f32,
}

impl Default for AcceptedChangesConfig {
    fn default() -> Self {
        Self { margin_m: 0.1, ground_m: 0.03, far_m: 0.3, cell_m: 0.04 }
    }
}

/// Changes that are the new normal, with what the visits saw that found them. Everything is in the frame of the map.
pub struct AcceptedChanges {
    config: AcceptedChangesConfig,
    /// Where objects were.
    left: Vec<UprightBox>,
    /// Where objects were or are. What is seen where one was may be new, too.
    changed: Vec<UprightBox>,
    /// What the visits saw at these places.
    seen: Surfaces,
    /// The same, for the larger distance.
    far: Surfaces,
    /// Where their rays went.
    rays: Vec<RayImage>,
    detection: ChangesConfig,
    /// The points that visits saw where objects are now, and where objects were, in the order of the visits.
    brought: Vec<BroughtPoint>,
}

/// A point that was not there before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BroughtPoint {
    /// Its place, metres.
    pub place: [f32; 3],
    /// Place of the sensor that saw it, metres.
    pub sensor: Vector3,
}

impl AcceptedChanges {
    /// Of changes, and the visits that found them. Linear in the points of the visits times the changes.
    pub fn new(changes: &[ObservedChange], visits: &[Visit], config: AcceptedChangesConfig) -> Self {
        let (mut left, mut changed) = (Vec::new(), Vec::new());
        for change in changes {
            match &change.change {
                Change::Appeared => {}
                Change::Removed => left.push(change.place),
                Change::Moved { from } => {
                    left.push(*from);
                    changed.push(*from);
                }
            }
            changed.push(change.place);
        }
        let detection = ChangesConfig::default();
        let reach_m = config.margin_m + f64::from(config.far_m);
        let mut brought = Vec::new();
        let mut near = Vec::new();
        let mut taken = CellTable::with_capacity(0);
        for view in visits.iter().flat_map(|visit| &visit.views) {
            for &place in &view.points {
                let at = Vector3::from(place.map(f64::from));
                if changed.iter().any(|one| one.holds(&at, reach_m)) {
                    near.push(place);
                }
                if is_in_any(&changed, &at, &config)
                    && taken.get_or_insert(CellKey::of_point(&place, 1.0 / config.cell_m), 0).1
                {
                    brought.push(BroughtPoint { place, sensor: view.sensor });
                }
            }
        }
        let seen =
            Surfaces::new(near.iter().copied(), SurfaceTolerance::uniform(detection.same_surface_m as f32));
        let far = Surfaces::new(near, SurfaceTolerance::uniform(config.far_m));
        let views = visits.iter().flat_map(|visit| &visit.views);
        let rays = views.map(|view| RayImage::new(view, &detection)).collect();
        Self { config, left, changed, seen, far, rays, detection, brought }
    }

    /// Whether a point of the map is gone: it is where an object was, above the ground, no visit has seen a surface there, and rays went through it or it is far from all that is still
    /// there. Linear in the changes, and near a surface in the views.
    pub fn is_gone(&self, place: &[f32; 3]) -> bool {
        let at = Vector3::from(place.map(f64::from));
        is_in_any(&self.left, &at, &self.config)
            && !self.seen.is_near(place)
            && (!self.far.is_near(place) || self.is_seen_through(place))
    }

    /// Whether more rays went through a place than ended there.
    fn is_seen_through(&self, place: &[f32; 3]) -> bool {
        let reach_m = self.detection.ray_reach_m;
        let rays = self.rays.iter().map(|image| image.passing(place, &|| None, reach_m, &self.detection));
        let (through, ended) =
            rays.fold((0, 0), |(through, ended), rays| (through + rays.through, ended + rays.ended));
        through >= self.detection.min_free_rays && through > ended
    }

    /// Whether a point of the map is near a place that changed, so that [`Self::added`] must know it. Linear in the changes.
    pub fn is_near_change(&self, place: &[f32; 3]) -> bool {
        let at = Vector3::from(place.map(f64::from));
        let reach_m = self.config.margin_m + self.detection.same_surface_m;
        self.changed.iter().any(|one| one.holds(&at, reach_m))
    }

    /// The points that are new, without those on a surface that the map has: `known` are its points [near changes](Self::is_near_change). `O(n log n)`.
    pub fn added(&self, known: Vec<[f32; 3]>) -> Vec<BroughtPoint> {
        let known = Surfaces::new(known, SurfaceTolerance::uniform(self.detection.same_surface_m as f32));
        self.brought.iter().filter(|point| !known.is_near(&point.place)).copied().collect()
    }
}

/// Whether a place is in one of the boxes, above the ground.
fn is_in_any(boxes: &[UprightBox], at: &Vector3, config: &AcceptedChangesConfig) -> bool {
    boxes.iter().any(|one| one.holds(at, config.margin_m) && at.z >= one.bottom_m() + config.ground_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SensorView;

    fn cube(x: f64) -> UprightBox {
        UprightBox { centre_m: Vector3::new(x, 0.0, 0.5), size_m: [1.0; 3], yaw_rad: 0.0 }
    }

    /// A wall of points at this distance, 1 m wide and high, and the floor below it.
    fn surface(x: f32) -> Vec<[f32; 3]> {
        let steps = |from: f32| (0..=20).map(move |step| from + step as f32 * 0.05);
        steps(-0.5).flat_map(|y| steps(0.0).map(move |z| [x, y, z])).collect()
    }

    fn visit(points: Vec<[f32; 3]>) -> Visit {
        Visit { views: vec![SensorView { sensor: Vector3::new(-3.0, 0.0, 1.0), points }] }
    }

    #[test]
    fn a_removed_object_leaves_what_is_still_seen_and_the_ground() {
        let removed = ObservedChange { change: Change::Removed, place: cube(0.0) };
        // A wall stands at the back of the box, and was seen through where the box was.
        let accepted =
            AcceptedChanges::new(&[removed], &[visit(surface(0.55))], AcceptedChangesConfig::default());
        assert!(accepted.is_gone(&[-0.5, 0.0, 0.5]) && accepted.is_gone(&[0.0, 0.5, 1.0]));
        assert!(!accepted.is_gone(&[0.55, 0.1, 0.5]), "the wall is still seen");
        assert!(!accepted.is_gone(&[-0.5, 0.0, 0.0]), "the ground");
        assert!(!accepted.is_gone(&[-0.7, 0.0, 0.5]), "outside");
        assert!(accepted.added(surface(0.55)).is_empty(), "the map has the wall");
    }

    #[test]
    fn an_object_that_was_moved_brings_the_points_that_the_map_has_not() {
        let moved = ObservedChange { change: Change::Moved { from: cube(0.0) }, place: cube(0.4) };
        let seen = surface(-0.1);
        let accepted =
            AcceptedChanges::new(&[moved], &[visit(seen.clone())], AcceptedChangesConfig::default());
        // Both boxes overlap. What is seen is not gone, even where the object was.
        assert!(accepted.is_gone(&[-0.5, 0.0, 0.5]) && !accepted.is_gone(&[-0.1, 0.0, 0.5]));
        let added = accepted.added(Vec::new());
        let above_ground = seen.iter().filter(|point| point[2] >= 0.03).count();
        assert_eq!(added.len(), above_ground);
        assert!((added[0].sensor.x + 3.0).abs() < 1e-12);
        // The map already has the lower half.
        let known: Vec<[f32; 3]> = seen.into_iter().filter(|point| point[2] < 0.5).collect();
        assert!(known.iter().all(|point| accepted.is_near_change(point)));
        let rest = accepted.added(known);
        assert!(!rest.is_empty() && rest.iter().all(|point| point.place[2] > 0.54), "{}", rest.len());
    }
}
