//! The lowest beams of a scan that met a surface: below them nothing is seen, so that what hangs in the air may stand on the ground.

use geometry::Vector3;

/// Directions in which the lowest beams are kept apart: four in each quadrant.
const SECTORS: usize = 16;

/// The lowest beams that met a surface, by direction in the map. They differ by direction, because a robot that leans sees the ground nearer on one
/// side.
pub(crate) struct LowestBeams {
    sensor: Vector3,
    /// Points nearer than this belong to the robot itself, metres.
    min_range: f64,
    /// Tangent of each sector's lowest beam below the horizontal.
    tangents: [f64; SECTORS],
}

impl LowestBeams {
    pub(crate) fn new(sensor: &Vector3, min_range: f64) -> Self {
        Self { sensor: *sensor, min_range, tangents: [0.0; SECTORS] }
    }

    /// Inserts a point given from the base's `origin` in the map's axes.
    pub(crate) fn insert(&mut self, point: &nalgebra::Vector3<f32>, origin: &Vector3) {
        let offset = point.cast::<f64>() + origin - self.sensor;
        let distance = (offset.x * offset.x + offset.y * offset.y).sqrt();
        if distance > self.min_range {
            let tangent = &mut self.tangents[sector(offset.x, offset.y)];
            *tangent = tangent.min(offset.z / distance);
        }
    }

    /// Height of the lowest beam above a point of the map, metres.
    pub(crate) fn height(&self, x: f64, y: f64) -> f64 {
        let (x, y) = (x - self.sensor.x, y - self.sensor.y);
        self.sensor.z + self.tangents[sector(x, y)] * (x * x + y * y).sqrt()
    }
}

/// The sector of a direction, counted from the negative x axis. Comparisons are used rather than an arctangent, because every point of a scan is
/// sorted.
fn sector(x: f64, y: f64) -> usize {
    /// Tangent of the width of a sector.
    const TANGENT: f64 = std::f64::consts::SQRT_2 - 1.0;
    let (quadrant, along, across) = match (x < 0.0, y < 0.0) {
        (true, true) => (0, -x, -y),
        (false, true) => (1, -y, x),
        (false, false) => (2, x, y),
        (true, false) => (3, y, -x),
    };
    let bounds = [along * TANGENT <= across, along <= across, along <= across * TANGENT];
    4 * quadrant + bounds.into_iter().filter(|is_passed| *is_passed).count()
}
