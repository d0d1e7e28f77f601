//! The trajectory of the robot's body: the path of the locomotion, low-pass filtered, with the gait added.

use crate::gait::{Gait, PoseOffset};
use crate::locomotion::Locomotion;
use crate::low_pass::LowPassFilter;
use crate::site::SimulatedSite;
use crate::timing::{BLOCK_SECONDS, TICK_SECONDS, TICKS_PER_BLOCK};
use geometry::{Isometry, Rng, Rotation, Vector3, so3};
use nalgebra::Translation3;
use vocab::Twist;

/// Height of the base above the ground when the robot stands, metres.
pub const STANDING_HEIGHT: f64 = 0.52;
/// Number of ticks before the present block for which poses are kept, because sensors look back.
pub(crate) const HISTORY_TICKS: usize = TICKS_PER_BLOCK;

/// Time constant of each filter stage of the planar path, seconds.
const PATH_TIME_CONSTANT_S: f64 = 0.035;
/// Time constant of each filter stage of ground height, pitch and roll, seconds.
const STANCE_TIME_CONSTANT_S: f64 = 0.07;

/// Poses of the base at every tick of one block and of the block before it.
#[derive(Clone, Debug)]
pub(crate) struct MotionHistory {
    /// The `HISTORY_TICKS` ticks before the block, the start of the block, and its `TICKS_PER_BLOCK` ticks.
    site_from_base: Vec<Isometry>,
}

impl MotionHistory {
    fn standing(pose: Isometry) -> Self {
        Self { site_from_base: vec![pose; HISTORY_TICKS + 1 + TICKS_PER_BLOCK] }
    }

    /// Pose at `tick` ticks after the start of the block, from `-HISTORY_TICKS` to `TICKS_PER_BLOCK`.
    pub(crate) fn at(&self, tick: isize) -> &Isometry {
        &self.site_from_base[(tick + HISTORY_TICKS as isize) as usize]
    }

    /// Pose at `seconds` after the start of the block, interpolated between ticks.
    pub(crate) fn interpolate_at(&self, seconds: f64) -> Isometry {
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
pub(crate) struct SimulatedBody {
    locomotion: Locomotion,
    gait: Gait,
    /// Filters of x, y and yaw.
    path: [LowPassFilter; 3],
    /// Filters of ground height, pitch and roll.
    stance: [LowPassFilter; 3],
    motion: MotionHistory,
}

impl SimulatedBody {
    /// A body that stands at `x, y` on the first ground below `z` (site frame, metres).
    pub(crate) fn new(site: &SimulatedSite, x: f64, y: f64, z: f64, yaw: f64, rng: Rng) -> Self {
        let locomotion = Locomotion::new(site, x, y, z, yaw);
        let ground_plane = locomotion.ground_plane;
        let path = [locomotion.x, locomotion.y, locomotion.yaw]
            .map(|value| LowPassFilter::new(value, PATH_TIME_CONSTANT_S));
        let stance = [ground_plane.height, ground_plane.pitch, ground_plane.roll]
            .map(|value| LowPassFilter::new(value, STANCE_TIME_CONSTANT_S));
        let mut body = Self {
            locomotion,
            gait: Gait::new(rng),
            path,
            stance,
            motion: MotionHistory::standing(Isometry::identity()),
        };
        body.motion = MotionHistory::standing(body.pose([0.0; 3], [0.0; 3]));
        body
    }

    /// The motion during the newest block.
    pub(crate) fn motion(&self) -> &MotionHistory {
        &self.motion
    }

    /// Planar speed (m/s) and turning rate (rad/s) of the locomotion.
    pub(crate) fn planar_speed(&self) -> (f64, f64) {
        self.locomotion.planar_speed()
    }

    /// Whether a solid stopped the body or turned it aside in the newest block.
    pub(crate) fn touches_solid(&self) -> bool {
        self.locomotion.touches_solid()
    }

    /// Centres and radii of the spheres that the body consists of, site frame, metres.
    pub(crate) fn spheres(&self) -> [(Vector3, f64); 2] {
        self.locomotion.spheres()
    }

    /// Advances by one block towards the commanded velocity.
    pub(crate) fn advance(&mut self, site: &SimulatedSite, commanded: &Twist) {
        let before = [self.locomotion.x, self.locomotion.y, self.locomotion.yaw];
        self.locomotion.advance(site, commanded, BLOCK_SECONDS);
        self.append_block(before, |_| PoseOffset::default());
    }

    /// Planar pose before filtering: x, y (metres), yaw (radians), site frame.
    pub(crate) fn planar_pose(&self) -> [f64; 3] {
        [self.locomotion.x, self.locomotion.y, self.locomotion.yaw]
    }

    /// Advances by one block while a person carries the robot to that planar pose. `sway` gives the displacement at each tick, 0 being the
    /// start of the block. The ground plane is fitted again when the robot is `put_down`.
    pub(crate) fn carry(
        &mut self,
        site: &SimulatedSite,
        [x, y, yaw]: [f64; 3],
        sway: impl Fn(usize) -> PoseOffset,
        put_down: bool,
    ) {
        let before = self.planar_pose();
        let ground_plane = self.locomotion.ground_plane;
        self.locomotion = Locomotion::new(site, x, y, ground_plane.height, yaw);
        if !put_down {
            self.locomotion.ground_plane = ground_plane;
        }
        self.append_block(before, sway);
    }

    /// Appends one block of poses, from the planar pose `before` to the present one, with the displacement of `sway` at each tick.
    fn append_block(&mut self, before: [f64; 3], sway: impl Fn(usize) -> PoseOffset) {
        let after = [self.locomotion.x, self.locomotion.y, self.locomotion.yaw];
        let ground_plane = self.locomotion.ground_plane;
        let (speed, turning) = self.locomotion.planar_speed();
        self.motion.site_from_base.drain(..TICKS_PER_BLOCK);
        for tick in 1..=TICKS_PER_BLOCK {
            let fraction = tick as f64 / TICKS_PER_BLOCK as f64;
            for i in 0..3 {
                self.path[i].update(before[i] + (after[i] - before[i]) * fraction);
            }
            for (filter, target) in
                self.stance.iter_mut().zip([ground_plane.height, ground_plane.pitch, ground_plane.roll])
            {
                filter.update(target);
            }
            let pose_offset = self.gait.update(speed, turning).plus(&sway(tick));
            self.motion.site_from_base.push(self.pose(pose_offset.translation_m, pose_offset.rotation_rad));
        }
    }

    /// The filtered pose with that displacement: forward, left, up (metres); roll, pitch, yaw (radians).
    fn pose(&self, translation_m: [f64; 3], rotation_rad: [f64; 3]) -> Isometry {
        let [x, y, yaw] = self.path.map(|filter| filter.value());
        let [height, pitch, roll] = self.stance.map(|filter| filter.value());
        let heading = Rotation::from_euler_angles(0.0, 0.0, yaw);
        let rotation = heading
            * Rotation::from_euler_angles(roll + rotation_rad[0], pitch + rotation_rad[1], rotation_rad[2]);
        let foot = Vector3::new(x, y, height + STANDING_HEIGHT);
        Isometry::from_parts(Translation3::from(foot + heading * Vector3::from(translation_m)), rotation)
    }
}
