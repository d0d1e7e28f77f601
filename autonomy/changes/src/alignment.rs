//! Views of one visit are aligned with the surfaces of the other one before they are compared, and what is left of the errors of their poses is measured place by place.

use crate::join::Join;
use crate::{AlignmentConfig, SensorView, Visit};
use geometry::{Isometry, Matrix6, Vector3, Vector6, se3};
use nalgebra::Point3;
use points::hash::{CellKey, CellTable};
use points::{GaussianMap, GaussianMapConfig, Surface};
use registration::{GaussNewtonConfig, gauss_newton, linearise, shrink_eigenvalues};
use std::collections::BTreeMap;

/// A visit, aligned with another one.
pub(crate) struct AlignedVisit {
    /// The visit, its views moved.
    pub(crate) visit: Visit,
    /// How far its surfaces are still from those of the other visit.
    pub(crate) errors: RegionalErrors,
}

/// Aligns the views of a visit, one by one, with the surfaces of a reference. Directions in which a view does not say where it is stay where they are. A view without enough
/// surfaces in the reference stays too. `planes` are those of the reference. Linear in the points (docs/maths/changes.md, equation 5).
pub(crate) fn align(
    reference: &Visit,
    planes: &GaussianMap,
    visit: &Visit,
    join: &impl Join,
    config: &AlignmentConfig,
) -> AlignedVisit {
    let [references, views] = [reference, visit].map(|visit| visit.views.split_at(visit.views.len() / 2));
    let (mut first, second) = join.join(
        || AlignedViews::new(planes, references.0, views.0, config),
        || AlignedViews::new(planes, references.1, views.1, config),
    );
    first.views.extend(second.views);
    first.of_reference.extend(second.of_reference);
    first.residuals.extend(second.residuals);
    let errors = first.residuals.errors_beyond(first.of_reference, config);
    AlignedVisit { visit: Visit { views: first.views }, errors }
}

/// A part of the views of both visits.
struct AlignedViews {
    /// Those of the visit, moved.
    views: Vec<SensorView>,
    residuals: Residuals,
    /// How far the points of the reference are from its own planes: noise, curved surfaces, and errors within it. What the other visit has beyond that is the error of its poses.
    of_reference: Residuals,
}

impl AlignedViews {
    fn new(
        surfaces: &GaussianMap,
        reference: &[SensorView],
        views: &[SensorView],
        config: &AlignmentConfig,
    ) -> Self {
        let (mut of_reference, mut residuals) = (Residuals::default(), Residuals::default());
        for view in reference {
            of_reference.add(surfaces, &sample(view, config), &given_pose(view), config);
        }
        let aligned = |view: &SensorView| {
            let sample = sample(view, config);
            let map_from_sensor = aligned_pose(surfaces, view, &sample, config);
            residuals.add(surfaces, &sample, &map_from_sensor, config);
            moved(view, &map_from_sensor)
        };
        Self { views: views.iter().map(aligned).collect(), residuals, of_reference }
    }
}

/// The planes of a visit. Linear in its points.
pub(crate) fn planes(visit: &Visit, config: &AlignmentConfig) -> GaussianMap {
    let mut surfaces = GaussianMap::new(GaussianMapConfig::default());
    for view in &visit.views {
        let viewpoint = [view.sensor.x, view.sensor.y, view.sensor.z];
        for point in view.points.iter().step_by(config.point_step) {
            surfaces.insert_from_viewpoint(&point.map(f64::from), &viewpoint);
        }
    }
    surfaces
}

/// One point of each cell around the sensor, relative to it, metres: near surfaces have most points of a view, and would count most.
fn sample(view: &SensorView, config: &AlignmentConfig) -> Vec<[f32; 3]> {
    let mut cells = CellTable::default();
    let mut sample: Vec<[f32; 3]> = Vec::new();
    for point in view.points.iter().step_by(config.point_step) {
        let offset = Vector3::from(point.map(f64::from)) - view.sensor;
        let local: [f32; 3] = offset.map(|at| at as f32).into();
        let key = CellKey::of_point(&local, 1.0 / config.sample_cell_m as f32);
        if cells.get_or_insert(key, sample.len() as u32).1 {
            sample.push(local);
        }
    }
    sample
}

/// The pose of the sensor at which its points lie on the surfaces. Its axes differ from those of the map by the error of the given pose.
fn aligned_pose(
    surfaces: &GaussianMap,
    view: &SensorView,
    sample: &[[f32; 3]],
    config: &AlignmentConfig,
) -> Isometry {
    let given = given_pose(view);
    let prior = prior_information(config);
    let iteration = GaussNewtonConfig {
        max_iterations: config.max_iterations,
        initial_width: config.initial_width,
        ..GaussNewtonConfig::default()
    };
    let found = gauss_newton(given, &config.matching, &iteration, |pose, matching| {
        let equations = linearise(surfaces, sample, pose, matching);
        if equations.inliers < config.min_inliers {
            return None;
        }
        let lever_arm_m = config.lever_arm_m;
        let shrunk = shrink_eigenvalues(
            &equations.information,
            &equations.gradient,
            lever_arm_m,
            config.eigenvalue_shrinkage,
        );
        let information = shrunk.information / config.correlated_points + prior;
        let gradient = shrunk.gradient / config.correlated_points + prior * se3::local(&given, pose);
        let step = iteration.solve(&information, &gradient)?;
        Some((se3::retract(pose, &step), step.norm()))
    });
    let error = se3::local(&given, &found);
    let (turn_rad, shift_m) = (error.fixed_rows::<3>(0).norm(), error.fixed_rows::<3>(3).norm());
    let is_plausible = shift_m <= config.max_deviations * config.translation_m
        && turn_rad <= config.max_deviations * config.rotation_rad;
    if is_plausible { found } else { given }
}

/// The pose of the sensor of a view, with the axes of the map.
fn given_pose(view: &SensorView) -> Isometry {
    Isometry::translation(view.sensor.x, view.sensor.y, view.sensor.z)
}

/// The information of the given pose, order `[rotation; translation]`.
fn prior_information(config: &AlignmentConfig) -> Matrix6 {
    let [rotation, translation] = [config.rotation_rad, config.translation_m].map(|sigma| sigma.powi(-2));
    Matrix6::from_diagonal(&Vector6::new(rotation, rotation, rotation, translation, translation, translation))
}

/// A view whose sensor has another pose.
fn moved(view: &SensorView, map_from_sensor: &Isometry) -> SensorView {
    let rotation = map_from_sensor.rotation.to_rotation_matrix();
    let sensor = map_from_sensor.translation.vector;
    let at = |point: &[f32; 3]| {
        let offset = Vector3::from(point.map(f64::from)) - view.sensor;
        (rotation * offset + sensor).map(|at| at as f32).into()
    };
    SensorView { sensor, points: view.points.iter().map(at).collect() }
}

/// Distances of points of aligned views from the surfaces of the reference, by region: those that lie on level and on upright surfaces. A floor tells nothing of an error along it.
#[derive(Default)]
struct Residuals {
    of_regions: BTreeMap<CellKey, [Vec<f32>; 2]>,
}

impl Residuals {
    fn add(
        &mut self,
        surfaces: &GaussianMap,
        sample: &[[f32; 3]],
        map_from_sensor: &Isometry,
        config: &AlignmentConfig,
    ) {
        for point in sample {
            let at = (map_from_sensor * Point3::from(point.map(f64::from))).coords;
            let surface = surfaces.find_surface(at.as_ref(), config.matching.gate_m);
            if let Some(Surface::Plane { normal, distance, .. }) = surface {
                let region = CellKey::of_point(&at.map(|at| at as f32).into(), 1.0 / config.region_m as f32);
                let is_upright = normal[2].abs() < std::f32::consts::FRAC_1_SQRT_2;
                self.of_regions.entry(region).or_default()[usize::from(is_upright)].push(distance.abs());
            }
        }
    }

    fn extend(&mut self, other: Self) {
        for (region, [level, upright]) in other.of_regions {
            let of_region = self.of_regions.entry(region).or_default();
            of_region[0].extend(level);
            of_region[1].extend(upright);
        }
    }

    /// What these residuals have beyond those of the reference itself (docs/maths/changes.md, equation 6).
    fn errors_beyond(self, own: Self, config: &AlignmentConfig) -> RegionalErrors {
        let (all, of_reference) = (self.of_all(config), own.of_all(config));
        let mut own = own.of_regions;
        let deviations_m = self.of_regions.into_iter().map(|(region, kinds)| {
            let found = deviations(kinds, all, config);
            let expected = deviations(own.remove(&region).unwrap_or_default(), of_reference, config);
            (region, beyond(found, expected))
        });
        RegionalErrors {
            region_m: config.region_m,
            deviations_m: deviations_m.collect(),
            elsewhere_m: beyond(all, of_reference),
        }
    }

    /// Standard deviations over all regions, of level and of upright surfaces.
    fn of_all(&self, config: &AlignmentConfig) -> [f64; 2] {
        [0, 1].map(|kind| {
            let all = self.of_regions.values().flat_map(|kinds| &kinds[kind]).copied().collect();
            deviation(all, config.min_region_points).unwrap_or(0.0)
        })
    }
}

/// Standard deviations of residuals on level and on upright surfaces; those of all where there are too few.
fn deviations(kinds: [Vec<f32>; 2], of_all: [f64; 2], config: &AlignmentConfig) -> [f64; 2] {
    let [level, upright] = kinds.map(|residuals| deviation(residuals, config.min_region_points));
    [level.unwrap_or(of_all[0]), upright.unwrap_or(of_all[1])]
}

/// The standard deviation that explains the residuals together with those of the reference itself: of the kind of surfaces for which it is larger.
fn beyond(found: [f64; 2], expected: [f64; 2]) -> f64 {
    let of_kind = |kind: usize| (found[kind].powi(2) - expected[kind].powi(2)).max(0.0).sqrt();
    of_kind(0).max(of_kind(1))
}

/// Standard deviation of a normal distribution with the median of these distances; none with fewer than this number of them.
fn deviation(mut distances_m: Vec<f32>, min_points: usize) -> Option<f64> {
    distances_m.sort_by(f32::total_cmp);
    let median = distances_m.get(distances_m.len() / 2).filter(|_| distances_m.len() >= min_points)?;
    Some(f64::from(*median) / 0.6745)
}

/// How far the surfaces of two visits are from each other where nothing has changed, by region.
#[derive(Clone, Debug)]
pub(crate) struct RegionalErrors {
    region_m: f64,
    /// Standard deviation of all, metres.
    elsewhere_m: f64,
    deviations_m: BTreeMap<CellKey, f64>,
}

impl RegionalErrors {
    /// Standard deviation of the distance between surfaces that are the same, metres.
    pub(crate) fn deviation_m(&self, place: &[f32; 3]) -> f64 {
        let region = CellKey::of_point(place, 1.0 / self.region_m as f32);
        self.deviations_m.get(&region).copied().unwrap_or(self.elsewhere_m)
    }

    /// The largest of them.
    pub(crate) fn largest_m(&self) -> f64 {
        self.deviations_m.values().copied().fold(self.elsewhere_m, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::room::{at, visit};
    use crate::{ChangesConfig, InTurn, detect_changes};
    use geometry::{RngTree, so3};

    fn aligned(reference: &Visit, visit: &Visit, config: &AlignmentConfig) -> AlignedVisit {
        align(reference, &planes(reference, config), visit, &InTurn, config)
    }

    /// Poses of views that are wrong by some centimetres and half a degree.
    fn with_pose_errors(visit: &Visit) -> Visit {
        let mut rng = RngTree::new(7).child("pose errors").rng();
        let mut error = |sigma: f64| Vector3::new(rng.normal(), rng.normal(), rng.normal()) * sigma;
        let of_view = |view: &SensorView| {
            let turn = so3::exp(&error(0.008));
            moved(view, &Isometry::from_parts((view.sensor + error(0.04)).into(), turn))
        };
        Visit { views: visit.views.iter().map(of_view).collect() }
    }

    #[test]
    fn views_are_moved_onto_the_surfaces_of_the_other_visit_though_some_of_them_have_changed() {
        let (stays, gone, new) = (
            at(-2.0, 1.0, [0.5, 0.5, 0.9], 0.4),
            at(0.5, 0.5, [0.8, 0.5, 0.6], 0.2),
            at(3.0, 0.0, [0.4; 3], 0.7),
        );
        let (before, after) = (visit(&[stays, gone], 5.0), visit(&[stays, new], 5.0));
        let wrong = with_pose_errors(&after);
        let moved = aligned(&before, &wrong, &AlignmentConfig::default());
        let errors_m = |visit: &Visit| -> Vec<f64> {
            let pairs = visit.views.iter().zip(&after.views);
            pairs.map(|(view, truth)| (view.sensor - truth.sensor).norm()).collect()
        };
        assert!(errors_m(&wrong).iter().sum::<f64>() > 0.3, "{:?}", errors_m(&wrong));
        assert!(errors_m(&moved.visit).iter().all(|error_m| *error_m < 0.01), "{:?}", errors_m(&moved.visit));
        assert!(moved.errors.largest_m() < 0.01, "{:?}", moved.errors);
        let found = detect_changes(&before, &wrong, &ChangesConfig::default());
        assert_eq!(found.objects.len(), 2, "{:?}", found.objects);
    }

    #[test]
    fn what_is_left_of_the_errors_is_told_where_it_is() {
        let before = visit(&[], 5.0);
        // Nothing may be moved: the errors stay.
        let stiff = AlignmentConfig { max_deviations: 0.0, ..AlignmentConfig::default() };
        let mut after = before.clone();
        for point in after.views.iter_mut().flat_map(|view| &mut view.points) {
            point[1] += if point[0] > 3.0 { 0.05 } else { 0.0 };
        }
        let errors = aligned(&before, &after, &stiff).errors;
        let (moved_m, still_m) =
            (errors.deviation_m(&[5.0, 4.05, 1.0]), errors.deviation_m(&[-2.0, 3.9, 1.0]));
        assert!(moved_m > 0.02 && still_m < 0.01, "{moved_m} {still_m}");
    }

    #[test]
    fn a_visit_elsewhere_and_an_empty_one_stay_as_they_are() {
        let (here, empty) = (visit(&[], 0.0), Visit::default());
        let mut elsewhere = here.clone();
        for view in &mut elsewhere.views {
            view.sensor.x += 100.0;
            view.points.iter_mut().for_each(|point| point[0] += 100.0);
        }
        let config = AlignmentConfig::default();
        let moved = aligned(&here, &elsewhere, &config);
        let shift_m = |pair: (&SensorView, &SensorView)| (pair.0.sensor - pair.1.sensor).norm();
        assert!(moved.visit.views.iter().zip(&elsewhere.views).all(|pair| shift_m(pair) == 0.0));
        assert_eq!(aligned(&empty, &here, &config).visit.len(), here.len());
        assert_eq!(aligned(&here, &empty, &config).errors.largest_m(), 0.0);
    }
}
