//! Leg odometry: body velocity from the feet on the ground, with noise, a drifting scale and slips, and the pose integrated from it.

use crate::body::STANDING_HEIGHT;
use crate::timing::BLOCK_SECONDS;
use geometry::{Isometry, Rng, Vector3, so3};
use messages::LegOdometry;
use nalgebra::Translation3;
use vocab::{Stamp, Twist};

/// Standard deviation of the linear velocity in x, y and z, m/s.
const LINEAR_NOISE_M_S: [f64; 3] = [0.02, 0.02, 0.03];
/// Standard deviation of each angular velocity, rad/s.
const ANGULAR_NOISE_RAD_S: f64 = 0.004;
/// Standard deviation of the linear velocity of a robot that stands, m/s.
const STANDING_LINEAR_NOISE_M_S: f64 = 0.002;
/// Standard deviation of the angular velocity of a robot that stands, rad/s.
const STANDING_ANGULAR_NOISE_RAD_S: f64 = 0.001;
/// Mean share by which the legs overestimate distance (foot radius, compliance).
const SCALE_ERROR: f64 = 0.012;
/// Standard deviation of that share from one simulation to another.
const SCALE_ERROR_DEVIATION: f64 = 0.006;
/// Random walk of that share, 1/√s.
const SCALE_WALK_PER_SQRT_S: f64 = 4e-4;
/// Standard deviation of the heading drift of the integrated pose, rad/s.
const HEADING_DRIFT_RAD_S: f64 = 3e-4;
/// Slips per second of walking, Hz.
const SLIP_RATE_HZ: f64 = 1.0 / 25.0;
/// Shortest slip, seconds.
const MIN_SLIP_DURATION_S: f64 = 0.12;
/// Longest slip, seconds.
const MAX_SLIP_DURATION_S: f64 = 0.5;
/// Standard deviation of the velocity of a slip, m/s.
const SLIP_SPEED_M_S: f64 = 0.22;
/// Share of that deviation in the vertical.
const SLIP_VERTICAL_SHARE: f64 = 0.2;

/// The leg odometry.
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
    /// Velocity error of the present slip, base frame, m/s.
    slip_velocity: Vector3,
    /// Time that the present slip still lasts, seconds.
    slip_left_s: f64,
}

impl Legs {
    /// Odometry that starts at the origin; without `rng` it makes no errors.
    pub(crate) fn new(rng: Option<Rng>) -> Self {
        let errors = rng.map(|mut rng| Errors {
            scale: 1.0 + SCALE_ERROR + SCALE_ERROR_DEVIATION * rng.normal(),
            heading_drift: HEADING_DRIFT_RAD_S * rng.normal(),
            slip_velocity: Vector3::zeros(),
            slip_left_s: 0.0,
            rng,
        });
        let start = Translation3::new(0.0, 0.0, STANDING_HEIGHT);
        Self { odom_from_base: Isometry::from_parts(start, geometry::Rotation::identity()), errors }
    }

    /// The message of one block. `truth` is the velocity of the base in its own frame; `forced_slip` is the additional error of a fault,
    /// base frame, m/s.
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
            // The feet stand on the ground, so the encoders measure almost no motion.
            *linear += Vector3::new(rng.normal(), rng.normal(), rng.normal()) * STANDING_LINEAR_NOISE_M_S;
            *angular += Vector3::new(rng.normal(), rng.normal(), rng.normal()) * STANDING_ANGULAR_NOISE_RAD_S;
            return;
        }
        self.scale += SCALE_WALK_PER_SQRT_S * BLOCK_SECONDS.sqrt() * rng.normal();
        let (slip, left) = (&mut self.slip_velocity, &mut self.slip_left_s);
        *left -= BLOCK_SECONDS;
        if *left <= 0.0 {
            *slip = Vector3::zeros();
            if rng.uniform() < SLIP_RATE_HZ * BLOCK_SECONDS {
                *slip = Vector3::new(rng.normal(), rng.normal(), SLIP_VERTICAL_SHARE * rng.normal())
                    * SLIP_SPEED_M_S;
                *left = rng.range(MIN_SLIP_DURATION_S, MAX_SLIP_DURATION_S);
            }
        }
        let noise = Vector3::from_fn(|i, _| LINEAR_NOISE_M_S[i] * rng.normal());
        *linear = *linear * self.scale + *slip + noise;
        *angular += Vector3::from_fn(|_, _| ANGULAR_NOISE_RAD_S * rng.normal());
        angular.z += self.heading_drift;
    }
}
