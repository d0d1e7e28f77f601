//! Building elements of sites: walls, beams, pipes, stairs and railings, added by a [`Builder`].

use super::plan::SitePlan;
use crate::shape::{Material, Shape, Solid};
use geometry::{Rng, RngTree, Rotation, Vector3};

/// Shorthand for a point.
pub(super) const fn at(x: f64, y: f64, z: f64) -> Vector3 {
    Vector3::new(x, y, z)
}

/// A hole in a wall: its start along the wall, its width, and its lower and upper edge above the wall's foot.
#[derive(Clone, Copy)]
pub(super) struct Opening {
    pub(super) along: f64,
    pub(super) width: f64,
    pub(super) sill: f64,
    pub(super) head: f64,
}

/// A doorway 1.4 m wide and 2.2 m high, centred `along` metres from the start of the wall.
pub(super) const fn door(along: f64) -> Opening {
    Opening { along: along - 0.7, width: 1.4, sill: 0.0, head: 2.2 }
}

/// A gate 3.4 m wide and 3.6 m high.
pub(super) const fn gate(along: f64) -> Opening {
    Opening { along: along - 1.7, width: 3.4, sill: 0.0, head: 3.6 }
}

/// A window of that width.
pub(super) const fn window(along: f64, width: f64) -> Opening {
    Opening { along: along - width / 2.0, width, sill: 1.0, head: 2.1 }
}

/// Collects the solids of a site.
pub(super) struct Builder {
    pub(super) plan: SitePlan,
    /// Random numbers for clutter. The seed is the site's name.
    pub(super) rng: Rng,
}

impl Builder {
    pub(super) fn new(name: &str) -> Self {
        Self { plan: SitePlan::default(), rng: RngTree::new(2024).child(name).rng() }
    }

    pub(super) fn add(&mut self, shape: Shape, material: Material) {
        self.plan.solids.push(Solid { shape, material });
    }

    /// The solids that `put` adds form a piece of furniture, which may stand elsewhere on another day.
    pub(super) fn movable(&mut self, put: impl FnOnce(&mut Self)) {
        let first = self.plan.solids.len();
        put(self);
        self.plan.furniture.push(first..self.plan.solids.len());
    }

    /// A box from any two opposite corners.
    pub(super) fn aligned_box(&mut self, a: Vector3, b: Vector3, material: Material) {
        self.add(Shape::AlignedBox { min: a.inf(&b), max: a.sup(&b) }, material);
    }

    /// A box standing on `foot` (the middle of its bottom), turned by `yaw`.
    pub(super) fn oriented_box(&mut self, foot: Vector3, size: Vector3, yaw: f64, material: Material) {
        let center = foot + Vector3::z() * (size.z / 2.0);
        let site_from_box = Rotation::from_euler_angles(0.0, 0.0, yaw);
        self.add(Shape::OrientedBox { center, half: size / 2.0, site_from_box }, material);
    }

    pub(super) fn cylinder(&mut self, from: Vector3, to: Vector3, radius: f64, material: Material) {
        self.add(Shape::Cylinder { from, to, radius }, material);
    }

    pub(super) fn sphere(&mut self, center: Vector3, radius: f64, material: Material) {
        self.add(Shape::Sphere { center, radius }, material);
    }

    /// A four-cornered sheet, as two triangles.
    pub(super) fn quad(&mut self, [a, b, c, d]: [Vector3; 4], material: Material) {
        self.add(Shape::Triangle([a, b, c]), material);
        self.add(Shape::Triangle([a, c, d]), material);
    }

    /// A bar of rectangular section along a segment. `width` is horizontal, `height` is perpendicular to it.
    pub(super) fn beam(&mut self, from: Vector3, to: Vector3, width: f64, height: f64, material: Material) {
        let span = to - from;
        let axes = span.iter().filter(|c| c.abs() > 1e-9).count();
        if axes == 1 {
            let along_z = span.z.abs() > 1e-9;
            let side = if span.x.abs() > 1e-9 { at(0.0, width, height) } else { at(width, 0.0, height) };
            let half = if along_z { at(width, height, 0.0) } else { side } / 2.0;
            self.aligned_box(from.inf(&to) - half, from.sup(&to) + half, material);
            return;
        }
        let forward = span.normalize();
        let left = Vector3::z().cross(&forward).try_normalize(1e-6).unwrap_or_else(Vector3::y);
        let axes = nalgebra::Matrix3::from_columns(&[forward, left, forward.cross(&left)]);
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(axes);
        let half = at(span.norm(), width, height) / 2.0;
        let site_from_box = Rotation::from_rotation_matrix(&rotation);
        self.add(Shape::OrientedBox { center: (from + to) / 2.0, half, site_from_box }, material);
    }

    /// A wall from `from` to `to`, with its foot at height `from.z`. The openings are in order of `along`.
    pub(super) fn wall(
        &mut self,
        from: Vector3,
        to: [f64; 2],
        height: f64,
        thickness: f64,
        openings: &[Opening],
        material: Material,
    ) {
        let span = at(to[0] - from.x, to[1] - from.y, 0.0);
        let (length, unit) = (span.norm(), span.normalize());
        let mut piece = |start: f64, end: f64, low: f64, high: f64| {
            if end - start > 1e-6 && high - low > 1e-6 {
                let middle = from + Vector3::z() * ((low + high) / 2.0);
                self.beam(middle + unit * start, middle + unit * end, thickness, high - low, material);
            }
        };
        let mut done = 0.0;
        for opening in openings {
            piece(done, opening.along, 0.0, height);
            piece(opening.along, opening.along + opening.width, 0.0, opening.sill);
            piece(opening.along, opening.along + opening.width, opening.head, height);
            done = opening.along + opening.width;
        }
        piece(done, length, 0.0, height);
    }

    /// A pipe through corners, with elbows, and flanges every few metres.
    pub(super) fn pipe(&mut self, corners: &[Vector3], radius: f64, material: Material) {
        for leg in corners.windows(2) {
            let (from, to) = (leg[0], leg[1]);
            self.cylinder(from, to, radius, material);
            let length = (to - from).norm();
            let unit = (to - from) / length;
            let flanges = (length / 3.5) as usize;
            for i in 0..flanges {
                let middle = from + unit * ((i as f64 + 0.5) * length / flanges as f64);
                self.cylinder(
                    middle - unit * 0.03,
                    middle + unit * 0.03,
                    radius * 1.35 + 0.01,
                    Material::Steel,
                );
            }
        }
        for corner in &corners[1..corners.len() - 1] {
            self.sphere(*corner, radius * 1.04, material);
        }
    }

    /// An H-section standing at `foot`, flanges facing ±y (±x if `turned`).
    pub(super) fn column(&mut self, foot: Vector3, height: f64, turned: bool, material: Material) {
        let top = foot + Vector3::z() * height;
        let across = if turned { Vector3::x() } else { Vector3::y() };
        let (long, short) = if turned { (0.02, 0.26) } else { (0.26, 0.02) };
        for side in [-0.13, 0.13] {
            self.beam(foot + across * side, top + across * side, long, short, material);
        }
        let (web_x, web_y) = if turned { (0.24, 0.015) } else { (0.015, 0.24) };
        self.beam(foot, top, web_x, web_y, material);
        // Base plate.
        self.aligned_box(foot - at(0.22, 0.22, 0.0), foot + at(0.22, 0.22, 0.03), Material::Steel);
    }

    /// A lattice girder below the segment `from`-`to`: two chords and diagonals.
    pub(super) fn truss(
        &mut self,
        from: Vector3,
        to: Vector3,
        depth: f64,
        panels: usize,
        material: Material,
    ) {
        let down = Vector3::z() * depth;
        self.beam(from, to, 0.14, 0.14, material);
        self.beam(from - down, to - down, 0.14, 0.14, material);
        for panel in 0..panels {
            let node = |i: usize| from + (to - from) * (i as f64 / panels as f64);
            let (a, b) = (node(panel), node(panel + 1));
            let (low, high) = if panel % 2 == 0 { (a - down, b) } else { (b - down, a) };
            self.beam(low, high, 0.07, 0.07, material);
            self.beam(a, a - down, 0.06, 0.06, material);
        }
    }

    /// Posts, hand rail and knee rail along corners on the floor.
    pub(super) fn railing(&mut self, corners: &[Vector3], material: Material) {
        for leg in corners.windows(2) {
            let span = leg[1] - leg[0];
            let posts = (span.norm() / 1.4).ceil() as usize;
            for i in 0..=posts {
                let foot = leg[0] + span * (i as f64 / posts as f64);
                self.cylinder(foot, foot + Vector3::z() * 1.05, 0.024, material);
            }
            for (height, radius) in [(1.06, 0.026), (0.55, 0.018)] {
                let up = Vector3::z() * height;
                self.cylinder(leg[0] + up, leg[1] + up, radius, material);
            }
            let kick = Vector3::z() * 0.08;
            self.beam(leg[0] + kick, leg[1] + kick, 0.01, 0.12, material);
        }
    }

    /// A ladder on a wall, rungs along `side` (a unit vector), with a safety cage above 2.3 m.
    pub(super) fn ladder(&mut self, foot: Vector3, height: f64, side: Vector3) {
        let top = foot + Vector3::z() * height;
        for sign in [-0.24, 0.24] {
            self.cylinder(foot + side * sign, top + side * sign, 0.028, Material::YellowPaint);
        }
        for rung in 1..(height / 0.28) as usize {
            let middle = foot + Vector3::z() * (0.28 * rung as f64);
            self.cylinder(middle - side * 0.24, middle + side * 0.24, 0.014, Material::Steel);
        }
        let out = Vector3::z().cross(&side) * 0.65;
        for hoop in 0..((height - 2.3) / 0.9).max(0.0) as usize {
            let middle = foot + Vector3::z() * (2.3 + 0.9 * hoop as f64);
            let corners = [side * -0.3, side * -0.3 + out * 0.7, out, side * 0.3 + out * 0.7, side * 0.3];
            for pair in corners.windows(2) {
                self.cylinder(middle + pair[0], middle + pair[1], 0.015, Material::YellowPaint);
            }
        }
    }

    /// A straight flight up from `foot` (middle of its lower edge) along unit `forward`, with treads, stringers and
    /// railings. Returns the middle of its upper edge.
    pub(super) fn stairs(
        &mut self,
        foot: Vector3,
        forward: Vector3,
        width: f64,
        steps: usize,
        rise: f64,
        run: f64,
    ) -> Vector3 {
        let left = Vector3::z().cross(&forward);
        for step in 0..steps {
            let front = foot + forward * (run * step as f64) + Vector3::z() * (rise * (step + 1) as f64);
            let tread = [front - left * (width / 2.0) - Vector3::z() * 0.05, front + left * (width / 2.0)];
            self.aligned_box(tread[0], tread[1] + forward * (run + 0.03), Material::Galvanised);
        }
        let up = Vector3::z() * (rise * steps as f64);
        let top = foot + forward * (run * steps as f64) + up;
        for side in [-1.0, 1.0] {
            let edge = left * (side * (width / 2.0 + 0.03));
            self.beam(foot + edge, top + edge, 0.04, 0.26, Material::BluePaint);
            let rail = Vector3::z() * 1.0;
            self.cylinder(foot + edge + rail, top + edge + rail, 0.025, Material::YellowPaint);
            self.cylinder(foot + edge + rail * 0.5, top + edge + rail * 0.5, 0.018, Material::YellowPaint);
            for post in 0..=4 {
                let base = foot + edge + (top - foot) * (f64::from(post) / 4.0);
                self.cylinder(base, base + rail, 0.022, Material::YellowPaint);
            }
        }
        top
    }
}
