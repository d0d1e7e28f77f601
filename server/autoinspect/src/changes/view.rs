//! A view in the frame of the map.

use changes::SensorView;
use geometry::{Isometry, Vector3};

/// The view from a sensor (metres, in a frame whose pose in the map is given) at points (metres, the same frame).
pub fn view(map_from_frame: &Isometry, sensor: &[f32; 3], points: &[[f32; 3]]) -> SensorView {
    let in_map = |point: &[f32; 3]| map_from_frame * nalgebra::Point3::from(point.map(f64::from));
    let sensor: Vector3 = in_map(sensor).coords;
    let points = points.iter().map(|point| in_map(point).coords.map(|at| at as f32).into()).collect();
    SensorView { sensor, points }
}
