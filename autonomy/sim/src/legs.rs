//! Leg odometry: body velocity from the feet on the ground, with noise, a drifting scale, slips, and the pose that the robot
//! integrates from it.

use crate::{BLOCK_SECONDS, body::STANDING_HEIGHT};
use geometry::{Isometry, Rng, Vector3, so3};
use messages::LegOdometry;
use nalgebra::Translation3;
use vocab::{Stamp, Twist};

/// Standard deviation of each velocity, m/s and rad/s.
const LINEAR_NOISE: [f64; 3] = [0.02, 0.02, 0.03];
const ANGULAR_NOISE: f64 = 0.004;
/// Share by which the legs overestimate distance (foot radius, compliance): mean, and its random walk per √s.
const SCALE_ERROR: f64 = 0.012;
const SCALE_WALK: f64 = 4e-4;
/// Heading drift of the integrated pose: standard deviation, rad/s.
const HEADING_DRIFT: f64 = 3e-4;
/// Slips per second of walking, how long one lasts (seconds), and its size (m/s, standard deviation).
const SLIP_RATE: f64 = 1.0 / 25.0;
const SLIP_SECONDS: (f64, f64) = (0.12, 0.5);
const SLIP_SPEED: f64 = 0.22;

/// The odometry of the legs.
#[derive(Clone, Debug)]
pub(crate) struct Legs {
    odom_from_base: Isometry,
    errors: Option<Errors>,
}

#[derive(Clone, Debug)]
struct Errors {
    rng: Rng,
    scale: f64,
    heading_drift: f64,
    /// Velocity error of the present slip and the seconds it goes on.
    slip: (Vector3, f64),
}

impl Legs {
    /// Odometry that starts at the origin; without `rng` it makes no errors.
    pub(crate) fn new(rng: Option<Rng>) -> Self {
        let errors = rng.map(|mut rng| Errors {
            scale: 1.0 + SCALE_ERROR + 0.006 * rng.normal(),
            heading_drift: HEADING_DRIFT * rng.normal(),
            slip: (Vector3::zeros(), 0.0),
            rng,
        });
        let start = Translation3::new(0.0, 0.0, STANDING_HEIGHT);
        Self { odom_from_base: Isometry::from_parts(start, geometry::Rotation::identity()), errors }
    }

    /// The message of one block: `truth` is the base's velocity in its own frame, `forced_slip` an extra error from a
    /// fault, m/s in the base frame.
    pub(crate) fn sample(
        &mut self,
        stamp: Stamp,
        truth: &Twist,
        walking: bool,
        forced_slip: Vector3,
    ) -> LegOdometry {
        let mut linear = geometry::vec_from_plain(truth.linear) + forced_slip;
        let mut angular = geometry::vec_from_plain(truth.angular);
        if let Some(errors) = &mut self.errors {
            errors.corrupt(&mut linear, &mut angular, walking);
        }
        let step = Translation3::from(linear * BLOCK_SECONDS);
        let turn = so3::exp(&(angular * BLOCK_SECONDS));
        self.odom_from_base *= Isometry::from_parts(step, turn);
        LegOdometry {
            stamp,
            base_velocity: Twist {
                linear: geometry::vec_to_plain(&linear),
                angular: geometry::vec_to_plain(&angular),
            },
            odom_from_base: geometry::pose_from_isometry(&self.odom_from_base),
        }
    }
}

impl Errors {
    fn corrupt(&mut self, linear: &mut Vector3, angular: &mut Vector3, walking: bool) {
        let rng = &mut self.rng;
        if !walking {
            // Feet planted: the encoders see next to nothing.
            *linear += Vector3::new(rng.normal(), rng.normal(), rng.normal()) * 0.002;
            *angular += Vector3::new(rng.normal(), rng.normal(), rng.normal()) * 0.001;
            return;
        }
        self.scale += SCALE_WALK * BLOCK_SECONDS.sqrt() * rng.normal();
        let (slip, left) = &mut self.slip;
        *left -= BLOCK_SECONDS;
        if *left <= 0.0 {
            *slip = Vector3::zeros();
            if rng.uniform() < SLIP_RATE * BLOCK_SECONDS {
                *slip = Vector3::new(rng.normal(), rng.normal(), 0.2 * rng.normal()) * SLIP_SPEED;
                *left = rng.range(SLIP_SECONDS.0, SLIP_SECONDS.1);
            }
        }
        let noise = Vector3::from_fn(|i, _| LINEAR_NOISE[i] * rng.normal());
        *linear = *linear * self.scale + *slip + noise;
        *angular += Vector3::from_fn(|_, _| ANGULAR_NOISE * rng.normal());
        angular.z += self.heading_drift;
    }
}
