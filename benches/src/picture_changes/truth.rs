//! The true mapping between two pictures, for scoring only: what a pixel of one sees is projected into the other.

use super::visits::{GaugePoint, Visit};
use geometry::Vector3;
use nalgebra::Point3;
use picture_changes::{Homography, PosedCamera};
use sim::{Face, SimulatedSite};

/// Errors of a mapping, pixels: the root of the mean square.
#[derive(Clone, Copy, Debug)]
pub struct MappingError {
    /// On the plate of the gauge.
    pub plate_px: f64,
    /// In the middle of the picture, six tenths of its width, whatever is there.
    pub middle_px: f64,
}

/// Places on a plate or in a picture, along each side.
const GRID: usize = 24;
/// Half of the side of the middle of a picture, as a share of its width.
const MIDDLE_SHARE: f64 = 0.3;
/// A place is seen from both cameras if rays end within this distance of it, metres.
const SAME_PLACE_M: f64 = 0.01;

/// The error of a mapping between two visits.
pub fn mapping_error(
    site: &SimulatedSite,
    point: &GaugePoint,
    visits: [&Visit; 2],
    homography: &Homography,
) -> MappingError {
    let [before, after] = visits.map(|visit| &visit.truth);
    let shares = || {
        (0..GRID * GRID)
            .map(|at| [at % GRID, at / GRID].map(|at| (at as f64 + 0.5) / GRID as f64 * 2.0 - 1.0))
    };
    let half_m = point.fixture.face.half_m();
    let on_plate = shares().map(|[x, y]| {
        (point.fixture.site_from_plate * Point3::new(x * half_m[0], y * half_m[1], 0.0)).coords
    });
    let [width, height] = visits[0].picture.size_px().map(|side| side as f64);
    let centre = [0.5 * (width - 1.0), 0.5 * (height - 1.0)];
    let in_middle = shares().filter_map(|[x, y]| {
        let px = [centre[0] + x * MIDDLE_SHARE * width, centre[1] + y * MIDDLE_SHARE * width];
        let point = seen(site, before, px).filter(|_| px[1] >= 0.0 && px[1] <= height - 1.0)?;
        let back = project(after, &point).and_then(|px| seen(site, after, px))?;
        ((back - point).norm() < SAME_PLACE_M).then_some(point)
    });
    let error = |points: &mut dyn Iterator<Item = Vector3>| {
        let squares: Vec<f64> = points
            .filter_map(|point| {
                let [from, to] = [before, after].map(|camera| project(camera, &point));
                let (mapped, to) = (homography.map(from?)?, to?);
                Some((mapped[0] - to[0]).powi(2) + (mapped[1] - to[1]).powi(2))
            })
            .collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    MappingError { plate_px: error(&mut on_plate.into_iter()), middle_px: error(&mut in_middle.into_iter()) }
}

/// What a pixel sees, site frame, metres.
fn seen(site: &SimulatedSite, camera: &PosedCamera, px: [f64; 2]) -> Option<Vector3> {
    let [x, y] = [0, 1].map(|axis| (px[axis] - camera.centre_px[axis]) / camera.focal_px);
    let direction = camera.map_from_camera.rotation * Vector3::new(x, y, 1.0).normalize();
    let eye = camera.map_from_camera.translation.vector;
    site.cast_ray(&eye, &direction, 100.0).map(|(range, _)| eye + direction * range)
}

/// Where a point of the site is in a picture, pixels; none behind the camera.
pub fn project(camera: &PosedCamera, point: &Vector3) -> Option<[f64; 2]> {
    let local = camera.map_from_camera.inverse_transform_point(&Point3::from(*point));
    (local.z > 1e-6)
        .then(|| [0, 1].map(|axis| camera.focal_px * local[axis] / local.z + camera.centre_px[axis]))
}

/// Range of a gauge's scale.
pub fn range(point: &GaugePoint) -> [f64; 2] {
    match point.fixture.face {
        Face::Gauge { min, max, .. } => [min, max],
        _ => [0.0, 0.0],
    }
}
