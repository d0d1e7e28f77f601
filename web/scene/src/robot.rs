//! The robot: its state, and a small mesh of a four-legged body.

use bytemuck::{Pod, Zeroable};
use glam::{DQuat, DVec3, Mat3, Quat, Vec3};

/// Height of the base frame above the feet of the mesh, m. A robot that stands higher is drawn larger.
const MESH_STANDING_HEIGHT_M: f64 = 0.5;
/// Radius of the smallest ring round a robot of that height, m: its hull.
const MESH_RING_RADIUS_M: f64 = 0.62;
/// Largest ring, m.
const MAX_RING_RADIUS_M: f64 = 20.0;

/// Pose and state of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotState {
    /// Origin of the base frame, m, map frame.
    pub position: DVec3,
    /// Orientation of the base frame in the map.
    pub orientation: DQuat,
    /// Whether it needs no attention; otherwise it is drawn in [`crate::Palette::bad`] with a dashed ring.
    pub ok: bool,
    /// Whether the operator selected it.
    pub selected: bool,
    /// Standard deviation of the position, m: the radius of the ring around the robot, which is never smaller than the robot.
    pub accuracy: f64,
    /// Height of the base over the ground while the robot stands, m; positive.
    pub standing_height_m: f64,
}

impl RobotState {
    /// Whether position and orientation are finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.position.is_finite() && self.orientation.is_finite() && self.standing_height_m.is_finite()
    }

    /// Horizontal unit vector of its heading; along x when it faces straight up.
    pub(crate) fn ahead(&self) -> DVec3 {
        let facing = self.orientation * DVec3::X;
        DVec3::new(facing.x, facing.y, 0.0).try_normalize().unwrap_or(DVec3::X)
    }

    /// The point on the ground below the base.
    pub(crate) fn feet(&self) -> DVec3 {
        self.position - DVec3::Z * self.standing_height_m
    }

    /// Factor by which the mesh is drawn larger than it is.
    pub(crate) fn scale(&self) -> f64 {
        self.standing_height_m / MESH_STANDING_HEIGHT_M
    }

    pub(crate) fn ring_radius(&self) -> f64 {
        let least = MESH_RING_RADIUS_M * self.scale();
        if self.accuracy.is_finite() {
            self.accuracy.clamp(least, MAX_RING_RADIUS_M.max(least))
        } else {
            least
        }
    }
}

/// A vertex of the mesh, base frame (x ahead, z up), m.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Vertex {
    pub(crate) position: [f32; 3],
    pub(crate) normal: [f32; 3],
    /// An opacity of one half is replaced by the theme's colour of the robot.
    pub(crate) colour: [u8; 4],
}

/// Colour of the body: an opacity of one half, so the theme's colour replaces it.
const BODY: [u8; 4] = [255, 255, 255, 128];
const DARK: [u8; 4] = [44, 49, 58, 255];
const DARKER: [u8; 4] = [28, 32, 39, 255];
const GLASS: [u8; 4] = [88, 166, 255, 255];

/// Triangles of the mesh.
pub(crate) fn mesh() -> Vec<Vertex> {
    let mut mesh = Mesh::default();
    // Torso, its dark belly, shoulders, and a sensor on the back.
    mesh.slab(Vec3::new(0.0, 0.0, 0.03), Vec3::new(0.37, 0.12, 0.07), 0.045, BODY);
    mesh.slab(Vec3::new(0.0, 0.0, -0.05), Vec3::new(0.33, 0.10, 0.05), 0.03, DARK);
    mesh.slab(Vec3::new(0.0, 0.0, 0.105), Vec3::new(0.16, 0.075, 0.02), 0.015, DARK);
    mesh.limb(Vec3::new(0.08, 0.0, 0.11), Vec3::new(0.08, 0.0, 0.21), [0.055, 0.055], DARKER);
    mesh.limb(Vec3::new(0.08, 0.0, 0.15), Vec3::new(0.08, 0.0, 0.185), [0.058, 0.058], GLASS);
    // Head with a visor.
    mesh.slab(Vec3::new(0.42, 0.0, 0.05), Vec3::new(0.085, 0.10, 0.06), 0.035, BODY);
    mesh.slab(Vec3::new(0.49, 0.0, 0.055), Vec3::new(0.025, 0.075, 0.03), 0.012, DARKER);
    for (x, y) in [(0.29, 0.15), (0.29, -0.15), (-0.29, 0.15), (-0.29, -0.15)] {
        mesh.leg(x, y);
    }
    mesh.vertices
}

#[derive(Default)]
struct Mesh {
    vertices: Vec<Vertex>,
}

impl Mesh {
    /// Hip, thigh back to the knee, shank forward to the foot.
    fn leg(&mut self, x: f32, y: f32) {
        let side = y.signum();
        let hip = Vec3::new(x, y, 0.0);
        let thigh = hip + Vec3::new(0.0, 0.05 * side, 0.0);
        let knee = thigh + Vec3::new(-0.13, 0.01 * side, -0.24);
        let foot = Vec3::new(x - 0.01, thigh.y + 0.01 * side, -MESH_STANDING_HEIGHT_M as f32 + 0.025);
        self.limb(hip - Vec3::Y * 0.05 * side, thigh + Vec3::Y * 0.03 * side, [0.058, 0.058], DARK);
        self.limb(thigh, knee, [0.055, 0.036], BODY);
        self.limb(knee, foot, [0.032, 0.02], DARK);
        self.limb(foot, foot - Vec3::Z * 0.02, [0.03, 0.028], DARKER);
    }

    /// A box with half extents and bevelled edges.
    fn slab(&mut self, centre: Vec3, half: Vec3, bevel: f32, colour: [u8; 4]) {
        let inner = half - Vec3::splat(bevel);
        let corner = |sign: Vec3, axis: usize| {
            let mut at = inner * sign;
            at[axis] = half[axis] * sign[axis];
            centre + at
        };
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for side in [-1.0, 1.0] {
                let face = |a: f32, b: f32| {
                    let mut sign = Vec3::ZERO;
                    (sign[axis], sign[u], sign[v]) = (side, a, b);
                    corner(sign, axis)
                };
                self.quad(
                    [face(-1.0, -1.0), face(1.0, -1.0), face(1.0, 1.0), face(-1.0, 1.0)],
                    centre,
                    colour,
                );
                // The bevel between this face and the next axis' face.
                for other in [-1.0, 1.0] {
                    let edge = |along: f32, on: usize| {
                        let mut sign = Vec3::ZERO;
                        (sign[axis], sign[u], sign[v]) = (side, other, along);
                        corner(sign, on)
                    };
                    let bevel = [edge(-1.0, axis), edge(1.0, axis), edge(1.0, u), edge(-1.0, u)];
                    self.quad(bevel, centre, colour);
                }
            }
        }
        for i in 0..8 {
            let sign = Vec3::from_array([0, 1, 2].map(|bit| if i >> bit & 1 == 1 { 1.0 } else { -1.0 }));
            let [a, b, c] = [0, 1, 2].map(|axis| corner(sign, axis));
            self.triangle([a, b, c], flat_normal([a, b, c], centre), colour);
        }
    }

    /// A round bar between two points with a radius at each, capped.
    fn limb(&mut self, from: Vec3, to: Vec3, radii: [f32; 2], colour: [u8; 4]) {
        const SIDES: u32 = 14;
        let axis = (to - from).try_normalize().unwrap_or(Vec3::Z);
        let turn = Mat3::from_quat(Quat::from_rotation_arc(Vec3::Z, axis));
        let around =
            |i: u32| turn * Mat3::from_rotation_z(i as f32 / SIDES as f32 * std::f32::consts::TAU).x_axis;
        for i in 0..SIDES {
            let (a, b) = (around(i), around(i + 1));
            let ring = [from + a * radii[0], from + b * radii[0], to + b * radii[1], to + a * radii[1]];
            let normals = [a, b, b, a];
            for corner in [0, 1, 2, 0, 2, 3] {
                self.vertices.push(Vertex {
                    position: ring[corner].to_array(),
                    normal: normals[corner].to_array(),
                    colour,
                });
            }
            self.triangle([from, ring[1], ring[0]], -axis, colour);
            self.triangle([to, ring[3], ring[2]], axis, colour);
        }
    }

    /// A flat face whose normal points away from `inside`.
    fn quad(&mut self, [a, b, c, d]: [Vec3; 4], inside: Vec3, colour: [u8; 4]) {
        let normal = flat_normal([a, b, c], inside);
        self.triangle([a, b, c], normal, colour);
        self.triangle([a, c, d], normal, colour);
    }

    fn triangle(&mut self, corners: [Vec3; 3], normal: Vec3, colour: [u8; 4]) {
        let vertex = |at: Vec3| Vertex { position: at.to_array(), normal: normal.to_array(), colour };
        self.vertices.extend(corners.map(vertex));
    }
}

fn flat_normal([a, b, c]: [Vec3; 3], inside: Vec3) -> Vec3 {
    let normal = (b - a).cross(c - a).try_normalize().unwrap_or(Vec3::Z);
    if normal.dot(a - inside) < 0.0 { -normal } else { normal }
}
