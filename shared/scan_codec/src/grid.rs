//! The grid of directions and ranges on which the stack sees points.
//!
//! Points on the grid can be computed from three integers with the same bits on every computer: only sums and products of floating-point
//! numbers are used, no functions of the system's mathematical library.

use messages::Scan;
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// Step of the range, micrometres: that of a Hesai XT-32, a quarter to a half of the noise of any LiDAR.
pub const RANGE_STEP_UM: u32 = 4_000;
/// Steps of an angle in a turn: 0.001°, in which makers of LiDARs state the directions of beams. At 100 m it is 1.7 mm.
pub(crate) const ANGLE_STEPS: i32 = 360_000;
/// Greatest elevation, steps: one below the vertical, where a point has no azimuth.
pub(crate) const MAX_ELEVATION: i32 = ANGLE_STEPS / 4 - 1;
/// Greatest range, steps: 16 km of the default step.
pub(crate) const MAX_RANGE: u32 = 1 << 22;

/// Steps of the fine table of angles, and the number of entries of the coarse one.
const FINE_STEPS: i32 = 600;
/// Largest tangent of a difference of two angles for which the series of the arc tangent is used.
const SMALL_TANGENT: f64 = 0.01;

/// A point of a sweep as integers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct GridPoint {
    /// Angle in the plane of x and y from the x axis, steps, from 0 to less than [`ANGLE_STEPS`].
    pub azimuth: i32,
    /// Angle above that plane, steps.
    pub elevation: i32,
    /// Distance from the sensor, steps; never 0.
    pub range: u32,
}

/// Sines and cosines of a turn in two levels: 600 coarse angles of 0.6° each, and 600 fine ones of 0.001°.
struct AngleTables {
    coarse: Vec<(f64, f64)>,
    fine: Vec<(f64, f64)>,
}

static ANGLES: LazyLock<AngleTables> = LazyLock::new(|| {
    let table = |unit: i32| {
        let entry = |index: i32| {
            let angle = TAU * f64::from(index * unit) / f64::from(ANGLE_STEPS);
            // The series is most precise near zero.
            sin_cos_series(if angle > PI { angle - TAU } else { angle })
        };
        (0..FINE_STEPS).map(entry).collect()
    };
    AngleTables { coarse: table(FINE_STEPS), fine: table(1) }
});

/// Sine and cosine of an angle from -π to π by their power series.
fn sin_cos_series(angle: f64) -> (f64, f64) {
    let (mut sin, mut cos, mut term) = (0.0, 0.0, 1.0);
    for power in 0..32 {
        match power % 4 {
            0 => cos += term,
            1 => sin += term,
            2 => cos -= term,
            _ => sin -= term,
        }
        term *= angle / f64::from(power + 1);
    }
    (sin, cos)
}

impl AngleTables {
    /// Sine and cosine of an angle in steps.
    fn sin_cos(&self, steps: i32) -> (f64, f64) {
        let steps = steps.rem_euclid(ANGLE_STEPS);
        let (sin_a, cos_a) = self.coarse[(steps / FINE_STEPS) as usize];
        let (sin_b, cos_b) = self.fine[(steps % FINE_STEPS) as usize];
        (sin_a * cos_b + cos_a * sin_b, cos_a * cos_b - sin_a * sin_b)
    }
}

/// The angle of (x, y) in steps, not reduced to one turn. It is fastest near `guess`.
fn angle_steps(angles: &AngleTables, x: f64, y: f64, guess: i32) -> i32 {
    const STEPS_PER_RAD: f64 = ANGLE_STEPS as f64 / TAU;
    let (sin, cos) = angles.sin_cos(guess);
    let (along, across) = (x * cos + y * sin, y * cos - x * sin);
    let tangent = across / along;
    if along > 0.0 && tangent.abs() < SMALL_TANGENT {
        let difference = tangent - tangent * tangent * tangent / 3.0;
        guess + (difference * STEPS_PER_RAD).round() as i32
    } else {
        (y.atan2(x) * STEPS_PER_RAD).round() as i32
    }
}

/// Converts between coordinates and grid points of a sweep.
pub(crate) struct Grid {
    angles: &'static AngleTables,
    range_step_m: f64,
}

impl Grid {
    pub fn new(range_step_um: u32) -> Self {
        Self { angles: &ANGLES, range_step_m: f64::from(range_step_um) * 1e-6 }
    }

    /// The coordinates of a grid point, metres.
    pub fn position(&self, point: GridPoint) -> [f32; 3] {
        let (sin_azimuth, cos_azimuth) = self.angles.sin_cos(point.azimuth);
        let (sin_elevation, cos_elevation) = self.angles.sin_cos(point.elevation);
        let range = f64::from(point.range) * self.range_step_m;
        let level = range * cos_elevation;
        [(level * cos_azimuth) as f32, (level * sin_azimuth) as f32, (range * sin_elevation) as f32]
    }

    /// The grid point nearest to a position, fastest if it lies near the direction of `guess`; `None` if its range is out of bounds.
    pub fn nearest(&self, position: [f32; 3], guess: GridPoint) -> Option<GridPoint> {
        let [x, y, z] = position.map(f64::from);
        let level_squared = x * x + y * y;
        let range = ((level_squared + z * z).sqrt() / self.range_step_m).round();
        // It is false for NaN too.
        let in_bounds = range >= 1.0 && range <= f64::from(MAX_RANGE);
        in_bounds.then(|| GridPoint {
            azimuth: angle_steps(self.angles, x, y, guess.azimuth).rem_euclid(ANGLE_STEPS),
            elevation: angle_steps(self.angles, level_squared.sqrt(), z, guess.elevation)
                .clamp(-MAX_ELEVATION, MAX_ELEVATION),
            range: range as u32,
        })
    }
}

/// The last direction of each channel, as the guess for its next point.
#[derive(Default)]
pub(crate) struct DirectionGuesses {
    elevations: Vec<i32>,
    azimuth: i32,
}

impl DirectionGuesses {
    /// A guess for the next point, which is of this channel.
    pub fn guess(&self, ring: u16) -> GridPoint {
        let elevation = self.elevations.get(usize::from(ring)).copied().unwrap_or_default();
        GridPoint { azimuth: self.azimuth, elevation, range: 0 }
    }

    /// Learns the direction of a point.
    pub fn learn(&mut self, ring: u16, point: GridPoint) {
        let ring = usize::from(ring);
        if self.elevations.len() <= ring {
            self.elevations.resize(ring + 1, 0);
        }
        self.elevations[ring] = point.elevation;
        self.azimuth = point.azimuth;
    }
}

/// Moves every point of a sweep to the nearest grid point; nothing else of it changes. A sweep with a point that has no grid point (nearer than
/// 2 mm, beyond 16 km) stays as it is. A sweep that is on the grid already does not change.
pub fn quantise(scan: &mut Scan) {
    let grid = Grid::new(RANGE_STEP_UM);
    let mut guesses = DirectionGuesses::default();
    let mut moved = Vec::with_capacity(scan.xyz.len());
    for (index, &position) in scan.xyz.iter().enumerate() {
        let ring = scan.ring.get(index).copied().unwrap_or_default();
        let Some(point) = grid.nearest(position, guesses.guess(ring)) else { return };
        guesses.learn(ring, point);
        moved.push(grid.position(point));
    }
    scan.xyz = moved;
}
