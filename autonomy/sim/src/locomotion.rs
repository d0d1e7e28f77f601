//! Planar locomotion before filtering: velocity with acceleration limits, walls that stop the robot or make it slide along them, and the
//! ground under the feet.

use crate::ray_packet::{LANES, NO_HIT, RayPacket};
use crate::site::SimulatedSite;
use geometry::Vector3;
use vocab::Twist;

/// Radius of the collision sphere of the body, metres.
const HULL_RADIUS_M: f64 = 0.36;
/// Height of the centre of that sphere above the ground, metres.
const HULL_HEIGHT_M: f64 = 0.60;
/// Radius of the collision sphere of the sensor mast, metres.
const MAST_RADIUS_M: f64 = 0.28;
/// Height of the centre of that sphere above the ground, metres.
const MAST_HEIGHT_M: f64 = 0.85;
/// Highest ledge that the robot steps over, metres.
const MAX_STEP_M: f64 = 0.27;
/// Forward coordinates at which the ground is probed, metres from the middle of the body.
const PROBE_FORWARD_M: [f64; LANES] = [-0.42, -0.30, -0.18, -0.06, 0.06, 0.18, 0.30, 0.42];
/// Distance of the two rows of probes from the middle of the body, metres.
const PROBE_LEFT_M: f64 = 0.18;
/// Start of the downward probes above the last ground height, metres.
const PROBE_HEIGHT_M: f64 = 0.45;
/// Length of a probe, metres.
const PROBE_LENGTH_M: f32 = 1.5;
/// Greatest speed forward, m/s.
const MAX_FORWARD_SPEED_M_S: f64 = 1.2;
/// Greatest speed backward, m/s.
const MAX_BACKWARD_SPEED_M_S: f64 = 0.6;
/// Greatest speed sideways, m/s.
const MAX_SIDEWAYS_SPEED_M_S: f64 = 0.4;
/// Greatest turning rate, rad/s.
const MAX_TURN_RATE_RAD_S: f64 = 1.0;
/// Greatest acceleration in either direction, m/s².
const MAX_ACCELERATION_M_S2: f64 = 1.4;
/// Greatest angular acceleration, rad/s².
const MAX_ANGULAR_ACCELERATION_RAD_S2: f64 = 3.0;
/// Pitch from which on the robot slows down, radians.
const STEEP_PITCH_RAD: f64 = 0.2;
/// Share of the commanded speed on steep ground.
const STEEP_SPEED_SHARE: f64 = 0.45;

/// A plane fitted to the ground under the feet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroundPlane {
    /// Height under the middle of the body, site frame, metres.
    pub(crate) height: f64,
    /// Pitch, radians, positive nose down.
    pub(crate) pitch: f64,
    /// Roll, radians, positive left side up.
    pub(crate) roll: f64,
}

/// Planar pose and velocity of the robot before filtering.
#[derive(Clone, Debug)]
pub(crate) struct Locomotion {
    /// Site frame, metres.
    pub(crate) x: f64,
    /// Site frame, metres.
    pub(crate) y: f64,
    /// Heading, radians, not wrapped.
    pub(crate) yaw: f64,
    pub(crate) ground_plane: GroundPlane,
    /// Velocity in the axes of the body: forward, left (m/s), turning (rad/s).
    velocity: [f64; 3],
    /// Whether a solid stopped it or turned it aside in the last step.
    touches_solid: bool,
}

impl Locomotion {
    /// A robot that stands at `x, y` on the first ground below `z` (site frame, metres).
    pub(crate) fn new(site: &SimulatedSite, x: f64, y: f64, z: f64, yaw: f64) -> Self {
        let height = ground_height(site, x, y, z + 0.5, 20.0).unwrap_or(z);
        let ground_plane = GroundPlane { height, pitch: 0.0, roll: 0.0 };
        let mut locomotion = Self { x, y, yaw, ground_plane, velocity: [0.0; 3], touches_solid: false };
        locomotion.ground_plane = locomotion.fit_ground_plane(site);
        locomotion
    }

    /// Whether a solid stopped it or turned it aside in the last step.
    pub(crate) fn touches_solid(&self) -> bool {
        self.touches_solid
    }

    /// Centres and radii of the spheres that the body consists of, site frame, metres.
    pub(crate) fn spheres(&self) -> [(Vector3, f64); 2] {
        [(HULL_HEIGHT_M, HULL_RADIUS_M), (MAST_HEIGHT_M, MAST_RADIUS_M)]
            .map(|(height, radius)| (Vector3::new(self.x, self.y, self.ground_plane.height + height), radius))
    }

    /// Planar speed (m/s) and turning rate (rad/s).
    pub(crate) fn planar_speed(&self) -> (f64, f64) {
        (self.velocity[0].hypot(self.velocity[1]), self.velocity[2])
    }

    /// Moves for `dt` seconds with the commanded velocity, within the limits of the legs and the walls of the site.
    pub(crate) fn advance(&mut self, site: &SimulatedSite, commanded: &Twist, dt: f64) {
        self.accelerate(commanded, dt);
        let [forward, left, turn] = self.velocity;
        let (sin, cos) = (self.yaw + turn * dt / 2.0).sin_cos();
        let old = (self.x, self.y);
        self.yaw += turn * dt;
        self.x += (forward * cos - left * sin) * dt;
        self.y += (forward * sin + left * cos) * dt;
        let touched = self.resolve_collisions(site);
        self.touches_solid = touched;
        let blocked =
            self.deepest_penetration(site).is_some_and(|(depth, _)| depth > 0.02) || self.is_at_ledge(site);
        if blocked {
            (self.x, self.y) = old;
        }
        if touched || blocked {
            let (vx, vy) = ((self.x - old.0) / dt, (self.y - old.1) / dt);
            let pushed = [vx * cos + vy * sin, vy * cos - vx * sin];
            for i in 0..2 {
                self.velocity[i] = pushed[i].clamp(-self.velocity[i].abs(), self.velocity[i].abs());
            }
        }
        self.ground_plane = self.fit_ground_plane(site);
    }

    fn accelerate(&mut self, commanded: &Twist, dt: f64) {
        // Legged robots walk slowly on slopes.
        let speed_share =
            if self.ground_plane.pitch.abs() > STEEP_PITCH_RAD { STEEP_SPEED_SHARE } else { 1.0 };
        let target = [
            commanded.linear.x.clamp(-MAX_BACKWARD_SPEED_M_S, MAX_FORWARD_SPEED_M_S) * speed_share,
            commanded.linear.y.clamp(-MAX_SIDEWAYS_SPEED_M_S, MAX_SIDEWAYS_SPEED_M_S) * speed_share,
            commanded.angular.z.clamp(-MAX_TURN_RATE_RAD_S, MAX_TURN_RATE_RAD_S),
        ];
        let limit =
            [MAX_ACCELERATION_M_S2 * dt, MAX_ACCELERATION_M_S2 * dt, MAX_ANGULAR_ACCELERATION_RAD_S2 * dt];
        for i in 0..3 {
            let target = if target[i].is_finite() { target[i] } else { 0.0 };
            self.velocity[i] += (target - self.velocity[i]).clamp(-limit[i], limit[i]);
        }
    }

    /// Moves the body horizontally out of the solids that it overlaps; returns whether there were any.
    fn resolve_collisions(&mut self, site: &SimulatedSite) -> bool {
        let mut touched = false;
        for _ in 0..6 {
            let Some((depth, away)) = self.deepest_penetration(site) else { break };
            self.x += away[0] * depth;
            self.y += away[1] * depth;
            touched = true;
        }
        touched
    }

    /// The deepest overlap with a solid: the distance to move (metres) and the horizontal unit direction to move in.
    fn deepest_penetration(&self, site: &SimulatedSite) -> Option<(f64, [f64; 2])> {
        let mut deepest: Option<(f64, [f64; 2])> = None;
        for (center, radius) in self.spheres() {
            site.bvh().near(&center, radius, |solid| {
                let clearance = solid.shape.clearance(&center);
                let level = clearance.outward.x.hypot(clearance.outward.y);
                let depth = radius - clearance.distance;
                // Floors and ceilings do not stop horizontal motion.
                if depth <= 1e-6 || level < 0.3 {
                    return;
                }
                let shift = depth / level;
                if deepest.is_none_or(|(most, _)| shift > most) {
                    deepest = Some((shift, [clearance.outward.x / level, clearance.outward.y / level]));
                }
            });
        }
        deepest
    }

    /// Whether the ground under the middle is too high or too low to step on.
    fn is_at_ledge(&self, site: &SimulatedSite) -> bool {
        let here = self.ground_plane.height;
        ground_height(site, self.x, self.y, here + PROBE_HEIGHT_M, PROBE_LENGTH_M)
            .is_none_or(|height| (height - here).abs() > MAX_STEP_M)
    }

    /// Fits a plane to the ground under the feet.
    fn fit_ground_plane(&self, site: &SimulatedSite) -> GroundPlane {
        let here = self.ground_plane.height;
        let middle =
            ground_height(site, self.x, self.y, here + PROBE_HEIGHT_M, PROBE_LENGTH_M).unwrap_or(here);
        let (sin, cos) = self.yaw.sin_cos();
        let heights = [PROBE_LEFT_M, -PROBE_LEFT_M].map(|left| {
            let x = PROBE_FORWARD_M.map(|forward| (self.x + forward * cos - left * sin) as f32);
            let y = PROBE_FORWARD_M.map(|forward| (self.y + forward * sin + left * cos) as f32);
            let top = here + PROBE_HEIGHT_M;
            let down = [[0.0; LANES], [0.0; LANES], [-1.0; LANES]];
            let mut packet = RayPacket::new([x, y, [top as f32; LANES]], down, PROBE_LENGTH_M);
            site.bvh().cast(&mut packet);
            std::array::from_fn::<f64, LANES, _>(|i| {
                let height = top - f64::from(packet.range[i]);
                // The feet avoid ground that is too high or too low for them. Such probes count as level with the middle.
                let reach = 0.14 + 0.75 * PROBE_FORWARD_M[i].abs();
                if packet.solid[i] == NO_HIT || (height - middle).abs() > reach { middle } else { height }
            })
        });
        let mean = |side: &[f64; LANES]| side.iter().sum::<f64>() / LANES as f64;
        let moment: f64 = PROBE_FORWARD_M.iter().map(|f| f * f).sum::<f64>() * 2.0;
        let slope =
            (0..LANES).map(|i| (heights[0][i] + heights[1][i]) * PROBE_FORWARD_M[i]).sum::<f64>() / moment;
        let tilt = (mean(&heights[0]) - mean(&heights[1])) / (2.0 * PROBE_LEFT_M);
        GroundPlane {
            height: (mean(&heights[0]) + mean(&heights[1])) / 2.0,
            pitch: -slope.atan(),
            roll: tilt.atan(),
        }
    }
}

/// Height of the first surface at most `length` metres below `top`, site frame, metres.
fn ground_height(site: &SimulatedSite, x: f64, y: f64, top: f64, length: f32) -> Option<f64> {
    let mut packet = RayPacket::single(&Vector3::new(x, y, top), &-Vector3::z(), length);
    site.bvh().cast(&mut packet);
    (packet.solid[0] != NO_HIT).then(|| top - f64::from(packet.range[0]))
}
