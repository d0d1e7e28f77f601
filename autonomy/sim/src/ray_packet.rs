//! Packets of eight rays and their intersection with solids, in f32, laid out so that the compiler vectorises the loops.
//!
//! Eight rays of one LiDAR ring in neighbouring columns have nearly the same origin and direction, so one traversal of the tree and
//! one test per solid serve all eight. Every test is branch-free per lane, and inlined into the traversal, which is compiled for two sets of instructions. Directions have unit length, so the
//! ray parameter is the range in metres.

use crate::shape::{Shape, Solid};
use geometry::Vector3;

/// Rays in a packet.
pub const LANES: usize = 8;
/// One number per ray.
pub type Lane = [f32; LANES];
/// Value of [`RayPacket::solid`] for a ray that has hit nothing.
pub const NO_HIT: u32 = u32::MAX;

/// [`RayPacket::range`] of a ray that has ended.
pub(crate) const ENDED: f32 = -1.0;

/// Eight rays with their nearest hits so far.
#[derive(Clone, Debug)]
pub struct RayPacket {
    pub(crate) origin: [Lane; 3],
    pub(crate) direction: [Lane; 3],
    inverse: [Lane; 3],
    /// Range of the nearest hit so far, metres. A ray of a negative range has ended: it enters no box and hits nothing.
    pub range: Lane,
    /// Index of that solid in the order of the tree, or [`NO_HIT`].
    pub solid: [u32; LANES],
}

impl RayPacket {
    /// Rays from `origin` along the unit vectors `direction` (both axis by axis), at most `max_range` metres long.
    pub fn new(origin: [Lane; 3], direction: [Lane; 3], max_range: f32) -> Self {
        let mut inverse = [[0.0; LANES]; 3];
        for axis in 0..3 {
            for lane in 0..LANES {
                let d = direction[axis][lane];
                // The component is never zero, because an infinite inverse times a zero offset would be NaN.
                inverse[axis][lane] = 1.0 / if d.abs() < 1e-9 { 1e-9_f32.copysign(d) } else { d };
            }
        }
        Self { origin, direction, inverse, range: [max_range; LANES], solid: [NO_HIT; LANES] }
    }

    /// The same ray in every lane.
    pub fn single(origin: &Vector3, direction: &Vector3, max_range: f32) -> Self {
        let spread = |v: &Vector3| [[v.x as f32; LANES], [v.y as f32; LANES], [v.z as f32; LANES]];
        Self::new(spread(origin), spread(direction), max_range)
    }

    /// Ends the rays that have hit something, so that they hit nothing more. Returns whether any ray is left.
    #[inline(always)]
    pub(crate) fn end_hits(&mut self) -> bool {
        let mut any = false;
        for lane in 0..LANES {
            self.range[lane] = if self.solid[lane] == NO_HIT { self.range[lane] } else { ENDED };
            any |= self.range[lane] > 0.0;
        }
        any
    }

    /// End point of ray `lane` at its range, in the frame of the packet.
    pub fn end(&self, lane: usize) -> [f32; 3] {
        [0, 1, 2].map(|axis| self.origin[axis][lane] + self.direction[axis][lane] * self.range[lane])
    }

    /// Whether any ray enters the box before its nearest hit.
    #[inline(always)]
    pub(crate) fn intersects_box(&self, min: &[f32; 3], max: &[f32; 3]) -> bool {
        let mut slack = [0.0_f32; LANES];
        for lane in 0..LANES {
            let (near, far) = self.slab(lane, min, max);
            slack[lane] = smaller(far, self.range[lane]) - larger(near, 0.0);
        }
        let mut any = false;
        for lane in 0..LANES {
            any |= slack[lane] >= 0.0;
        }
        any
    }

    /// The ray parameters at which ray `lane` enters and leaves the box. Entry is greater than exit if the ray misses it.
    #[inline(always)]
    fn slab(&self, lane: usize, min: &[f32; 3], max: &[f32; 3]) -> (f32, f32) {
        let ax = (min[0] - self.origin[0][lane]) * self.inverse[0][lane];
        let bx = (max[0] - self.origin[0][lane]) * self.inverse[0][lane];
        let ay = (min[1] - self.origin[1][lane]) * self.inverse[1][lane];
        let by = (max[1] - self.origin[1][lane]) * self.inverse[1][lane];
        let az = (min[2] - self.origin[2][lane]) * self.inverse[2][lane];
        let bz = (max[2] - self.origin[2][lane]) * self.inverse[2][lane];
        let near = larger(larger(smaller(ax, bx), smaller(ay, by)), smaller(az, bz));
        let far = smaller(smaller(larger(ax, bx), larger(ay, by)), larger(az, bz));
        (near, far)
    }

    #[inline(always)]
    fn record_hit(&mut self, lane: usize, hit: bool, range: f32, solid: u32) {
        let nearer = hit & (range > 0.0) & (range < self.range[lane]);
        self.range[lane] = if nearer { range } else { self.range[lane] };
        self.solid[lane] = if nearer { solid } else { self.solid[lane] };
    }
}

/// The instruction `minps`; unlike `f32::min` it does not handle NaN.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The instruction `maxps`, as [`smaller`].
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A solid in the form that the ray tests use: one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) enum PackedShape {
    AlignedBox {
        min: [f32; 3],
        max: [f32; 3],
    },
    /// `axes[i]` is the box's axis i in the site frame.
    OrientedBox {
        center: [f32; 3],
        half: [f32; 3],
        axes: [[f32; 3]; 3],
    },
    Cylinder {
        base: [f32; 3],
        axis: [f32; 3],
        length: f32,
        radius: f32,
    },
    Sphere {
        center: [f32; 3],
        radius: f32,
    },
    Triangle {
        corner: [f32; 3],
        edges: [[f32; 3]; 2],
    },
}

fn narrow(v: &Vector3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

impl From<&Solid> for PackedShape {
    fn from(solid: &Solid) -> Self {
        match &solid.shape {
            Shape::AlignedBox { min, max } => Self::AlignedBox { min: narrow(min), max: narrow(max) },
            Shape::OrientedBox { center, half, site_from_box } => {
                let rotation = site_from_box.to_rotation_matrix().into_inner();
                let axes = [0, 1, 2].map(|i| narrow(&rotation.column(i).into_owned()));
                Self::OrientedBox { center: narrow(center), half: narrow(half), axes }
            }
            Shape::Cylinder { from, to, radius } => Self::Cylinder {
                base: narrow(from),
                axis: narrow(&(to - from).normalize()),
                length: (to - from).norm() as f32,
                radius: *radius as f32,
            },
            Shape::Sphere { center, radius } => {
                Self::Sphere { center: narrow(center), radius: *radius as f32 }
            }
            Shape::Triangle([a, b, c]) => {
                Self::Triangle { corner: narrow(a), edges: [narrow(&(b - a)), narrow(&(c - a))] }
            }
        }
    }
}

impl PackedShape {
    /// Intersects the rays of `packet` with this solid and records hits under `id`. Rays that start inside the solid do not hit it.
    #[inline(always)]
    pub(crate) fn intersect(&self, packet: &mut RayPacket, id: u32) {
        match self {
            Self::AlignedBox { min, max } => {
                for lane in 0..LANES {
                    let (near, far) = packet.slab(lane, min, max);
                    packet.record_hit(lane, near <= far, near, id);
                }
            }
            Self::OrientedBox { center, half, axes } => {
                intersect_oriented_box(packet, id, *center, half, axes)
            }
            Self::Cylinder { base, axis, length, radius } => {
                intersect_cylinder(packet, id, *base, *axis, *length, *radius)
            }
            Self::Sphere { center, radius } => intersect_sphere(packet, id, *center, *radius),
            Self::Triangle { corner, edges } => intersect_triangle(packet, id, *corner, edges),
        }
    }

    /// Outward unit normal at a point of the surface; for a triangle, either direction.
    pub(crate) fn normal(&self, point: [f32; 3]) -> [f32; 3] {
        let from = |origin: [f32; 3]| [0, 1, 2].map(|i| point[i] - origin[i]);
        match self {
            Self::AlignedBox { min, max } => {
                let (center, half) =
                    ([0, 1, 2].map(|i| (min[i] + max[i]) * 0.5), [0, 1, 2].map(|i| (max[i] - min[i]) * 0.5));
                let (axis, sign) = face(from(center), &half);
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                normal
            }
            Self::OrientedBox { center, half, axes } => {
                let offset = from(*center);
                let (axis, sign) = face(axes.map(|a| dot(a, offset)), half);
                axes[axis].map(|c| c * sign)
            }
            Self::Cylinder { base, axis, length, radius } => {
                let offset = from(*base);
                let along = dot(offset, *axis);
                let across = [0, 1, 2].map(|i| offset[i] - axis[i] * along);
                let reach = dot(across, across).sqrt();
                let overhang = (along - length).max(-along);
                if overhang > reach - radius { *axis } else { across.map(|c| c / reach.max(1e-9)) }
            }
            Self::Sphere { center, radius } => from(*center).map(|c| c / radius),
            Self::Triangle { edges, .. } => {
                let normal = cross(edges[0], edges[1]);
                let length = dot(normal, normal).sqrt().max(1e-12);
                normal.map(|c| c / length)
            }
        }
    }
}

/// The face (axis and side) of a box on which a surface point, relative to the box's middle, lies.
fn face(offset: [f32; 3], half: &[f32; 3]) -> (usize, f32) {
    let excess = [0, 1, 2].map(|i| offset[i].abs() - half[i]);
    let axis = if excess[0] >= excess[1] && excess[0] >= excess[2] {
        0
    } else if excess[1] >= excess[2] {
        1
    } else {
        2
    };
    (axis, 1.0_f32.copysign(offset[axis]))
}

#[inline(always)]
fn intersect_oriented_box(
    packet: &mut RayPacket,
    id: u32,
    center: [f32; 3],
    half: &[f32; 3],
    axes: &[[f32; 3]; 3],
) {
    for lane in 0..LANES {
        let direction = [0, 1, 2].map(|i| packet.direction[i][lane]);
        let offset = [0, 1, 2].map(|i| packet.origin[i][lane] - center[i]);
        let (mut near, mut far) = (f32::MIN, f32::MAX);
        for i in 0..3 {
            let d = dot(axes[i], direction);
            // The small number keeps the division by zero finite. In other cases rounding removes it.
            let inverse = 1.0 / (d + 1e-20);
            let o = dot(axes[i], offset);
            let (a, b) = ((-half[i] - o) * inverse, (half[i] - o) * inverse);
            near = larger(near, smaller(a, b));
            far = smaller(far, larger(a, b));
        }
        packet.record_hit(lane, near <= far, near, id);
    }
}

#[inline(always)]
fn intersect_cylinder(
    packet: &mut RayPacket,
    id: u32,
    base: [f32; 3],
    axis: [f32; 3],
    length: f32,
    radius: f32,
) {
    for lane in 0..LANES {
        let direction = [0, 1, 2].map(|i| packet.direction[i][lane]);
        let offset = [0, 1, 2].map(|i| packet.origin[i][lane] - base[i]);
        let (rise, height) = (dot(direction, axis), dot(offset, axis));
        let across = [0, 1, 2].map(|i| offset[i] - axis[i] * height);
        let drift = [0, 1, 2].map(|i| direction[i] - axis[i] * rise);
        // Projected along the axis, this is a line and a circle. Computing from the line's nearest point keeps precision at long range.
        let speed_squared = dot(drift, drift) + 1e-12;
        let middle = -dot(across, drift) / speed_squared;
        let miss = [0, 1, 2].map(|i| across[i] + drift[i] * middle);
        let inside = radius * radius - dot(miss, miss);
        let side = middle - (larger(inside, 0.0) / speed_squared).sqrt();
        let side_height = height + rise * side;
        let side_hit = (inside >= 0.0) & (side_height >= 0.0) & (side_height <= length);
        let cap = (if rise > 0.0 { 0.0 } else { length } - height) / (rise + 1e-20);
        let cap_point = [0, 1, 2].map(|i| across[i] + drift[i] * cap);
        let cap_hit = dot(cap_point, cap_point) <= radius * radius;
        packet.record_hit(lane, side_hit | cap_hit, if side_hit { side } else { cap }, id);
    }
}

#[inline(always)]
fn intersect_sphere(packet: &mut RayPacket, id: u32, center: [f32; 3], radius: f32) {
    for lane in 0..LANES {
        let direction = [0, 1, 2].map(|i| packet.direction[i][lane]);
        let offset = [0, 1, 2].map(|i| packet.origin[i][lane] - center[i]);
        let middle = -dot(offset, direction);
        let miss = [0, 1, 2].map(|i| offset[i] + direction[i] * middle);
        let inside = radius * radius - dot(miss, miss);
        packet.record_hit(lane, inside >= 0.0, middle - larger(inside, 0.0).sqrt(), id);
    }
}

/// Source: Möller, Trumbore, *Fast, minimum storage ray-triangle intersection*, 1997.
#[inline(always)]
fn intersect_triangle(packet: &mut RayPacket, id: u32, corner: [f32; 3], edges: &[[f32; 3]; 2]) {
    for lane in 0..LANES {
        let direction = [0, 1, 2].map(|i| packet.direction[i][lane]);
        let offset = [0, 1, 2].map(|i| packet.origin[i][lane] - corner[i]);
        let p = cross(direction, edges[1]);
        let determinant = dot(edges[0], p);
        let inverse = 1.0 / (determinant + 1e-20);
        let u = dot(offset, p) * inverse;
        let q = cross(offset, edges[0]);
        let v = dot(direction, q) * inverse;
        let hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (determinant.abs() > 1e-12);
        packet.record_hit(lane, hit, dot(edges[1], q) * inverse, id);
    }
}
