//! A simulated room for tests. Rays are cast exactly, so that occlusion is right.

use crate::{SensorView, UprightBox, Visit};
use geometry::Vector3;
use std::f64::consts::{PI, TAU};

const ROOM_M: [f64; 3] = [12.0, 8.0, 3.0];

/// A box on the floor.
pub(crate) fn at(x: f64, y: f64, size_m: [f64; 3], yaw_rad: f64) -> UprightBox {
    UprightBox { centre_m: Vector3::new(x, y, size_m[2] / 2.0), size_m, yaw_rad }
}

/// The distance at which a ray meets the room or a box.
fn range_m(sensor: &Vector3, direction: &Vector3, boxes: &[UprightBox]) -> f64 {
    let room = UprightBox { centre_m: Vector3::new(0.0, 0.0, ROOM_M[2] / 2.0), size_m: ROOM_M, yaw_rad: 0.0 };
    let wall = room.crossed_by(sensor, direction).map_or(f64::INFINITY, |[_, leaves_m]| leaves_m);
    let met = boxes.iter().filter_map(|one| one.crossed_by(sensor, direction)).map(|[enters_m, _]| enters_m);
    met.fold(wall, f64::min)
}

/// The directions of the rays of a sweep.
#[derive(Clone, Copy)]
pub(crate) struct Rays {
    pub(crate) columns: u32,
    /// Azimuth of the first column, radians.
    pub(crate) first_rad: f64,
    /// Lowest and highest row, and the angle between two of them, radians.
    pub(crate) rows: [i32; 2],
    pub(crate) row_rad: f64,
}

/// Rays every 1.5 degrees.
pub(crate) const DENSE: Rays =
    Rays { columns: 240, first_rad: 0.0, rows: [-20, 20], row_rad: 1.5 * PI / 180.0 };

/// Rays every half degree.
pub(crate) const FINE: Rays =
    Rays { columns: 720, first_rad: 0.0, rows: [-60, 60], row_rad: 0.5 * PI / 180.0 };

/// What a sensor sees of the room and the boxes in it.
pub(crate) fn view(sensor: Vector3, rays: &Rays, boxes: &[UprightBox]) -> SensorView {
    let mut points = Vec::new();
    for row in rays.rows[0]..=rays.rows[1] {
        for column in 0..rays.columns {
            let azimuth = rays.first_rad + f64::from(column) / f64::from(rays.columns) * TAU;
            let elevation = f64::from(row) * rays.row_rad;
            let flat = elevation.cos();
            let direction = Vector3::new(flat * azimuth.cos(), flat * azimuth.sin(), elevation.sin());
            let point = sensor + direction * range_m(&sensor, &direction, boxes);
            points.push([point.x, point.y, point.z].map(|at| at as f32));
        }
    }
    SensorView { sensor, points }
}

/// A walk along the room with a view every metre.
pub(crate) fn visit(boxes: &[UprightBox], until_x: f64) -> Visit {
    visit_with_rays(boxes, until_x, &DENSE)
}

/// The same with other rays.
pub(crate) fn visit_with_rays(boxes: &[UprightBox], until_x: f64, rays: &Rays) -> Visit {
    let mut visit = Visit::default();
    let mut x = -5.0;
    while x <= until_x {
        visit.views.push(view(Vector3::new(x, -2.5 + 0.1 * x, 0.7), rays, boxes));
        x += 1.0;
    }
    visit
}
