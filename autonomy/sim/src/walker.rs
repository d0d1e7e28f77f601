//! Where the legs want the body: velocity with acceleration limits, walls that stop and turn it, and the ground under it.

use crate::packed::{LANES, NOTHING, Packet};
use crate::site::Site;
use geometry::Vector3;
use vocab::Twist;

/// The body keeps a sphere of this radius (metres) clear, centred [`HULL_HEIGHT`] over the ground.
pub(crate) const HULL_RADIUS: f64 = 0.36;
const HULL_HEIGHT: f64 = 0.60;
/// A smaller sphere for the sensor mast.
const MAST_RADIUS: f64 = 0.28;
const MAST_HEIGHT: f64 = 0.85;
/// Highest ledge that the legs take in one go, metres.
const STEP_MAX: f64 = 0.27;
/// Along the body, metres from its middle: where the ground is felt.
const PROBES_FORWARD: [f64; LANES] = [-0.42, -0.30, -0.18, -0.06, 0.06, 0.18, 0.30, 0.42];
const PROBE_LEFT: f64 = 0.18;
/// Limits of the velocity: forward, backward, sideways (m/s), turning (rad/s).
const FORWARD_MAX: f64 = 1.2;
const BACKWARD_MAX: f64 = 0.6;
const SIDEWAYS_MAX: f64 = 0.4;
const TURN_MAX: f64 = 1.0;
/// Limits of the change of velocity: m/s² and rad/s².
const ACCELERATION_MAX: f64 = 1.4;
const TURN_ACCELERATION_MAX: f64 = 3.0;

/// The ground under the body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footing {
    /// Of the fitted plane under the middle, site frame, metres.
    pub(crate) height: f64,
    /// Radians, positive nose down.
    pub(crate) pitch: f64,
    /// Radians, positive left side up.
    pub(crate) roll: f64,
}

/// The path before smoothing.
#[derive(Clone, Debug)]
pub(crate) struct Walker {
    /// Site frame, metres.
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// Radians, not wrapped.
    pub(crate) yaw: f64,
    pub(crate) footing: Footing,
    /// In the body's own axes: forward, left (m/s), turning (rad/s).
    velocity: [f64; 3],
}

impl Walker {
    /// Stands at `x, y` on the first ground below `z`.
    pub(crate) fn new(site: &Site, x: f64, y: f64, z: f64, yaw: f64) -> Self {
        let height = ground(site, x, y, z + 0.5, 20.0).unwrap_or(z);
        let footing = Footing { height, pitch: 0.0, roll: 0.0 };
        let mut walker = Self { x, y, yaw, footing, velocity: [0.0; 3] };
        walker.footing = walker.feel(site);
        walker
    }

    /// Path speed, m/s, and turning rate, rad/s.
    pub(crate) fn pace(&self) -> (f64, f64) {
        (self.velocity[0].hypot(self.velocity[1]), self.velocity[2])
    }

    /// Moves for `dt` seconds towards the wanted velocity as far as legs and walls allow.
    pub(crate) fn step(&mut self, site: &Site, wanted: &Twist, dt: f64) {
        self.accelerate(wanted, dt);
        let [forward, left, turn] = self.velocity;
        let (sin, cos) = (self.yaw + turn * dt / 2.0).sin_cos();
        let old = (self.x, self.y);
        self.yaw += turn * dt;
        self.x += (forward * cos - left * sin) * dt;
        self.y += (forward * sin + left * cos) * dt;
        let touched = self.slide(site);
        let blocked = self.penetration(site).is_some_and(|(depth, _)| depth > 0.02) || self.at_ledge(site);
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
        self.footing = self.feel(site);
    }

    fn accelerate(&mut self, wanted: &Twist, dt: f64) {
        // Careful on slopes, as legged robots are.
        let ease = if self.footing.pitch.abs() > 0.2 { 0.45 } else { 1.0 };
        let target = [
            wanted.linear.x.clamp(-BACKWARD_MAX, FORWARD_MAX) * ease,
            wanted.linear.y.clamp(-SIDEWAYS_MAX, SIDEWAYS_MAX) * ease,
            wanted.angular.z.clamp(-TURN_MAX, TURN_MAX),
        ];
        let limit = [ACCELERATION_MAX * dt, ACCELERATION_MAX * dt, TURN_ACCELERATION_MAX * dt];
        for i in 0..3 {
            let target = if target[i].is_finite() { target[i] } else { 0.0 };
            self.velocity[i] += (target - self.velocity[i]).clamp(-limit[i], limit[i]);
        }
    }

    /// Pushes the body out of what it touches, horizontally; whether it touched anything.
    fn slide(&mut self, site: &Site) -> bool {
        let mut touched = false;
        for _ in 0..6 {
            let Some((depth, away)) = self.penetration(site) else { break };
            self.x += away[0] * depth;
            self.y += away[1] * depth;
            touched = true;
        }
        touched
    }

    /// Deepest overlap with a solid as the metres to move along a horizontal unit direction.
    fn penetration(&self, site: &Site) -> Option<(f64, [f64; 2])> {
        let mut deepest: Option<(f64, [f64; 2])> = None;
        for (height, radius) in [(HULL_HEIGHT, HULL_RADIUS), (MAST_HEIGHT, MAST_RADIUS)] {
            let center = Vector3::new(self.x, self.y, self.footing.height + height);
            site.bvh().near(&center, radius, |solid| {
                let clearance = solid.shape.clearance(&center);
                let level = clearance.outward.x.hypot(clearance.outward.y);
                let depth = radius - clearance.distance;
                // Floors and ceilings push up or down only.
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

    /// Whether the ground under the middle is out of the legs' reach.
    fn at_ledge(&self, site: &Site) -> bool {
        let here = self.footing.height;
        ground(site, self.x, self.y, here + 0.45, 1.5).is_none_or(|height| (height - here).abs() > STEP_MAX)
    }

    /// Fits a plane to the ground under the feet.
    fn feel(&self, site: &Site) -> Footing {
        let here = self.footing.height;
        let middle = ground(site, self.x, self.y, here + 0.45, 1.5).unwrap_or(here);
        let (sin, cos) = self.yaw.sin_cos();
        let heights = [PROBE_LEFT, -PROBE_LEFT].map(|left| {
            let x = PROBES_FORWARD.map(|forward| (self.x + forward * cos - left * sin) as f32);
            let y = PROBES_FORWARD.map(|forward| (self.y + forward * sin + left * cos) as f32);
            let top = here + 0.45;
            let down = [[0.0; LANES], [0.0; LANES], [-1.0; LANES]];
            let mut packet = Packet::new([x, y, [top as f32; LANES]], down, 1.5);
            site.bvh().cast(&mut packet);
            std::array::from_fn::<f64, LANES, _>(|i| {
                let height = top - f64::from(packet.range[i]);
                // Feet go round what is too high or too deep for them.
                let reach = 0.14 + 0.75 * PROBES_FORWARD[i].abs();
                if packet.solid[i] == NOTHING || (height - middle).abs() > reach { middle } else { height }
            })
        });
        let mean = |side: &[f64; LANES]| side.iter().sum::<f64>() / LANES as f64;
        let moment: f64 = PROBES_FORWARD.iter().map(|f| f * f).sum::<f64>() * 2.0;
        let slope =
            (0..LANES).map(|i| (heights[0][i] + heights[1][i]) * PROBES_FORWARD[i]).sum::<f64>() / moment;
        let tilt = (mean(&heights[0]) - mean(&heights[1])) / (2.0 * PROBE_LEFT);
        Footing {
            height: (mean(&heights[0]) + mean(&heights[1])) / 2.0,
            pitch: -slope.atan(),
            roll: tilt.atan(),
        }
    }
}

/// Height of the first surface below `top`, not further down than `reach` metres.
fn ground(site: &Site, x: f64, y: f64, top: f64, reach: f32) -> Option<f64> {
    let mut packet = Packet::single(&Vector3::new(x, y, top), &-Vector3::z(), reach);
    site.bvh().cast(&mut packet);
    (packet.solid[0] != NOTHING).then(|| top - f64::from(packet.range[0]))
}
