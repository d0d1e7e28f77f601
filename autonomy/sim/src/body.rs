//! The robot's body as a trajectory: the walker's path made smooth, with the gait on top.

use crate::gait::{Gait, Wobble};
use crate::site::Site;
use crate::smooth::Smooth;
use crate::walker::Walker;
use crate::{BLOCK_SECONDS, TICK_SECONDS, TICKS_PER_BLOCK};
use geometry::{Isometry, Rng, Rotation, Vector3, so3};
use nalgebra::Translation3;
use vocab::Twist;

/// Height of the base over the ground when standing, metres.
pub const STANDING_HEIGHT: f64 = 0.52;
/// How far back (in ticks before the block) and forth the motion is kept for the sensors.
pub(crate) const MEMORY: usize = TICKS_PER_BLOCK;

/// Poses of the base at every tick of one block, and of the block before it.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    /// `MEMORY` ticks before the block, its start, and its `TICKS_PER_BLOCK` ticks.
    site_from_base: Vec<Isometry>,
}

impl Motion {
    fn standing(pose: Isometry) -> Self {
        Self { site_from_base: vec![pose; MEMORY + 1 + TICKS_PER_BLOCK] }
    }

    /// Pose `tick` ticks after the start of the block; from `-MEMORY` to `TICKS_PER_BLOCK`.
    pub(crate) fn at(&self, tick: isize) -> &Isometry {
        &self.site_from_base[(tick + MEMORY as isize) as usize]
    }

    /// Pose between ticks, `seconds` after the start of the block.
    pub(crate) fn between(&self, seconds: f64) -> Isometry {
        let ticks = (seconds / TICK_SECONDS).clamp(0.0, TICKS_PER_BLOCK as f64 - 1e-9);
        let (from, to) = (self.at(ticks as isize), self.at(ticks as isize + 1));
        geometry::se3::interpolate(from, to, ticks.fract())
    }

    /// Velocity of the base in its own frame at a tick, by the three-point backward difference.
    pub(crate) fn velocity(&self, tick: isize) -> Twist {
        let [now, one, two] = [0, 1, 2].map(|back| self.at(tick - back));
        let backward = |a: Vector3, b: Vector3| (a * 4.0 - b) / (2.0 * TICK_SECONDS);
        let path =
            |past: &Isometry| now.rotation.inverse() * (now.translation.vector - past.translation.vector);
        let turn = |past: &Isometry| so3::log(&(past.rotation.inverse() * now.rotation));
        Twist {
            linear: geometry::vec_to_plain(&backward(path(one), path(two))),
            angular: geometry::vec_to_plain(&backward(turn(one), turn(two))),
        }
    }
}

/// The body.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    walker: Walker,
    gait: Gait,
    /// x, y, yaw.
    path: [Smooth; 3],
    /// Ground height, pitch, roll.
    stance: [Smooth; 3],
    motion: Motion,
}

impl Body {
    /// Stands at `x, y` on the first ground below `z`.
    pub(crate) fn new(site: &Site, x: f64, y: f64, z: f64, yaw: f64, rng: Rng) -> Self {
        let walker = Walker::new(site, x, y, z, yaw);
        let footing = walker.footing;
        let path = [walker.x, walker.y, walker.yaw].map(|value| Smooth::new(value, 0.035));
        let stance = [footing.height, footing.pitch, footing.roll].map(|value| Smooth::new(value, 0.07));
        let mut body = Self {
            walker,
            gait: Gait::new(rng),
            path,
            stance,
            motion: Motion::standing(Isometry::identity()),
        };
        body.motion = Motion::standing(body.pose([0.0; 3], [0.0; 3]));
        body
    }

    /// The motion of the newest block.
    pub(crate) fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Path speed the legs intend, m/s, and turning rate, rad/s.
    pub(crate) fn pace(&self) -> (f64, f64) {
        self.walker.pace()
    }

    /// One block of motion towards the wanted velocity.
    pub(crate) fn advance(&mut self, site: &Site, wanted: &Twist) {
        let before = [self.walker.x, self.walker.y, self.walker.yaw];
        self.walker.step(site, wanted, BLOCK_SECONDS);
        self.follow(before, |_| Wobble::default());
    }

    /// Where the walker is: x, y (metres), yaw (radians), site frame.
    pub(crate) fn place(&self) -> [f64; 3] {
        [self.walker.x, self.walker.y, self.walker.yaw]
    }

    /// One block in somebody's arms, to that place, where `sway` moves it at each tick, 0 being the start of the block; the ground is felt
    /// again when it is `put_down`.
    pub(crate) fn carry(
        &mut self,
        site: &Site,
        [x, y, yaw]: [f64; 3],
        sway: impl Fn(usize) -> Wobble,
        put_down: bool,
    ) {
        let before = self.place();
        let footing = self.walker.footing;
        self.walker = Walker::new(site, x, y, footing.height, yaw);
        if !put_down {
            self.walker.footing = footing;
        }
        self.follow(before, sway);
    }

    /// Moves smoothly to where the walker is now from where it was a block ago, with what `sway` adds at each tick.
    fn follow(&mut self, before: [f64; 3], sway: impl Fn(usize) -> Wobble) {
        let after = [self.walker.x, self.walker.y, self.walker.yaw];
        let footing = self.walker.footing;
        let (speed, turning) = self.walker.pace();
        self.motion.site_from_base.drain(..TICKS_PER_BLOCK);
        for tick in 1..=TICKS_PER_BLOCK {
            let fraction = tick as f64 / TICKS_PER_BLOCK as f64;
            for i in 0..3 {
                self.path[i].step(before[i] + (after[i] - before[i]) * fraction);
            }
            for (smooth, target) in self.stance.iter_mut().zip([footing.height, footing.pitch, footing.roll])
            {
                smooth.step(target);
            }
            let wobble = self.gait.step(speed, turning).and(&sway(tick));
            self.motion.site_from_base.push(self.pose(wobble.shift, wobble.lean));
        }
    }

    fn pose(&self, shift: [f64; 3], lean: [f64; 3]) -> Isometry {
        let [x, y, yaw] = self.path.map(|smooth| smooth.value());
        let [height, pitch, roll] = self.stance.map(|smooth| smooth.value());
        let heading = Rotation::from_euler_angles(0.0, 0.0, yaw);
        let rotation = heading * Rotation::from_euler_angles(roll + lean[0], pitch + lean[1], lean[2]);
        let foot = Vector3::new(x, y, height + STANDING_HEIGHT);
        Isometry::from_parts(Translation3::from(foot + heading * Vector3::from(shift)), rotation)
    }
}
