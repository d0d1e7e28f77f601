//! Equipment and furniture of industrial sites, composed of the parts in `parts`.

use super::parts::{Builder, at};
use super::plan::{DoorLeaf, SimulatedDock};
use crate::shape::Material;
use geometry::Vector3;

impl Builder {
    /// Pallet racking along x (or y if `turned`) from its corner `foot`: uprights, beams, decks and stored goods.
    pub(super) fn rack(&mut self, foot: Vector3, length: f64, levels: usize, turned: bool) {
        let depth = 1.1;
        let place = |along: f64, across: f64, up: f64| {
            foot + if turned { at(across, along, up) } else { at(along, across, up) }
        };
        let bays = (length / 2.7).round().max(1.0) as usize;
        let bay = length / bays as f64;
        let height = levels as f64 * 1.6 + 0.3;
        for frame in 0..=bays {
            let along = frame as f64 * bay;
            for across in [0.05, depth - 0.05] {
                self.beam(
                    place(along, across, 0.0),
                    place(along, across, height),
                    0.09,
                    0.08,
                    Material::BluePaint,
                );
            }
            for brace in 0..levels * 2 {
                let (low, high) = (0.8 * brace as f64, 0.8 * (brace + 1) as f64);
                let (a, b) = if brace % 2 == 0 { (0.05, depth - 0.05) } else { (depth - 0.05, 0.05) };
                self.cylinder(place(along, a, low), place(along, b, high), 0.018, Material::Galvanised);
            }
        }
        for level in 1..=levels {
            let up = level as f64 * 1.6;
            for across in [0.05, depth - 0.05] {
                self.beam(
                    place(0.0, across, up),
                    place(length, across, up),
                    0.05,
                    0.12,
                    Material::YellowPaint,
                );
            }
            self.aligned_box(
                place(0.0, 0.05, up + 0.06),
                place(length, depth - 0.05, up + 0.08),
                Material::Wood,
            );
        }
        for bay_number in 0..bays {
            for level in 0..levels {
                let up = if level == 0 { 0.0 } else { level as f64 * 1.6 + 0.08 };
                for slot in 0..2 {
                    let along = (bay_number as f64 + 0.27 + 0.46 * f64::from(slot)) * bay;
                    if self.rng.uniform() < 0.78 {
                        self.pallet(place(along, depth / 2.0, up), turned, 1.25);
                    }
                }
            }
        }
    }

    /// A pallet with goods, its middle at `foot`, at most `height` high.
    pub(super) fn pallet(&mut self, foot: Vector3, turned: bool, height: f64) {
        self.movable(|b| b.put_pallet(foot, turned, height));
    }

    fn put_pallet(&mut self, foot: Vector3, turned: bool, height: f64) {
        let yaw = if turned { std::f64::consts::FRAC_PI_2 } else { 0.0 } + self.rng.range(-0.05, 0.05);
        self.oriented_box(foot, at(1.1, 0.9, 0.14), yaw, Material::Wood);
        let foot = foot + Vector3::z() * 0.14;
        let room = height - 0.14;
        match self.rng.bits() % 4 {
            0 => {
                let size =
                    at(self.rng.range(0.8, 1.05), self.rng.range(0.7, 0.9), room * self.rng.range(0.4, 0.95));
                self.oriented_box(foot, size, yaw, Material::Cardboard);
            }
            1 => {
                let layer = room * self.rng.range(0.28, 0.42);
                for (dx, dy, dz) in [
                    (-0.26, -0.2, 0.0),
                    (0.27, -0.2, 0.0),
                    (-0.26, 0.21, 0.0),
                    (0.27, 0.21, 0.0),
                    (-0.2, 0.0, 1.0),
                ] {
                    let offset =
                        nalgebra::Rotation3::from_euler_angles(0.0, 0.0, yaw) * at(dx, dy, dz * layer);
                    let turn = yaw + self.rng.range(-0.08, 0.08);
                    self.oriented_box(foot + offset, at(0.48, 0.36, layer), turn, Material::Cardboard);
                }
            }
            2 => {
                for (dx, dy) in [(-0.27, -0.2), (0.27, -0.2), (-0.27, 0.22), (0.27, 0.22)] {
                    let offset = nalgebra::Rotation3::from_euler_angles(0.0, 0.0, yaw) * at(dx, dy, 0.0);
                    self.drum(foot + offset, 0.21, room.min(0.62));
                }
            }
            _ => {
                let size = at(1.0, 0.8, room * self.rng.range(0.35, 0.7));
                self.oriented_box(foot, size, yaw, Material::WhiteSheet);
                self.cylinder(
                    foot + Vector3::z() * size.z,
                    foot + Vector3::z() * (size.z + 0.15),
                    0.12,
                    Material::Rubber,
                );
            }
        }
    }

    /// A drum with its rims.
    pub(super) fn drum(&mut self, foot: Vector3, radius: f64, height: f64) {
        self.movable(|b| b.put_drum(foot, radius, height));
    }

    fn put_drum(&mut self, foot: Vector3, radius: f64, height: f64) {
        self.cylinder(foot, foot + Vector3::z() * height, radius, Material::BluePaint);
        for ring in [0.33, 0.66] {
            let middle = foot + Vector3::z() * (height * ring);
            self.cylinder(middle, middle + Vector3::z() * 0.025, radius + 0.012, Material::BluePaint);
        }
    }

    /// A standing tank with a domed top on a plinth, with manhole, gauge pipe and ladder.
    pub(super) fn tank(&mut self, foot: Vector3, radius: f64, height: f64) {
        self.cylinder(foot, foot + Vector3::z() * 0.15, radius + 0.2, Material::Concrete);
        let shell = foot + Vector3::z() * 0.15;
        self.cylinder(shell, shell + Vector3::z() * height, radius, Material::WhiteSheet);
        for ring in 0..5 {
            let (low, share) = (height + 0.12 * radius * f64::from(ring), f64::from(ring + 1) / 5.5);
            let low = shell + Vector3::z() * low;
            self.cylinder(
                low,
                low + Vector3::z() * (0.12 * radius),
                radius * (1.0 - share * share).sqrt(),
                Material::WhiteSheet,
            );
        }
        for band in 1..(height / 1.2) as usize {
            let middle = shell + Vector3::z() * (1.2 * band as f64);
            self.cylinder(middle, middle + Vector3::z() * 0.06, radius + 0.025, Material::Galvanised);
        }
        let out = at(0.0, -1.0, 0.0);
        let manhole = shell + Vector3::z() * 0.9;
        self.cylinder(manhole + out * radius * 0.9, manhole + out * (radius + 0.18), 0.3, Material::Steel);
        self.ladder(foot + at(radius + 0.12, 0.0, 0.0), height + 0.15, Vector3::y());
        let gauge = at(-0.75, -0.75, 0.0) * radius;
        self.pipe(
            &[shell + gauge + Vector3::z() * 0.3, shell + gauge + Vector3::z() * (height * 0.9)],
            0.03,
            Material::Steel,
        );
    }

    /// A lying vessel on two saddles; `along` is its unit axis.
    pub(super) fn vessel(&mut self, middle: Vector3, along: Vector3, length: f64, radius: f64) {
        let (a, b) = (middle - along * (length / 2.0), middle + along * (length / 2.0));
        self.cylinder(a, b, radius, Material::Galvanised);
        self.sphere(a, radius, Material::Galvanised);
        self.sphere(b, radius, Material::Galvanised);
        let side = Vector3::z().cross(&along);
        for share in [-0.3, 0.3] {
            let saddle = middle + along * (length * share);
            let foot = Vector3::new(saddle.x, saddle.y, saddle.z - radius - 0.5);
            let half = along.abs() * 0.12 + side.abs() * (radius * 0.85);
            self.aligned_box(
                foot - half,
                foot + half + Vector3::z() * (0.5 + radius * 0.4),
                Material::Concrete,
            );
            let neck = saddle + Vector3::z() * radius;
            self.cylinder(neck, neck + Vector3::z() * 0.35, 0.12, Material::Steel);
            self.cylinder(neck + Vector3::z() * 0.3, neck + Vector3::z() * 0.36, 0.2, Material::Steel);
        }
    }

    /// A pump set on a plinth, its motor shaft along x (or y if `turned`).
    pub(super) fn pump(&mut self, foot: Vector3, turned: bool) {
        let yaw: f64 = if turned { std::f64::consts::FRAC_PI_2 } else { 0.0 };
        let forward = at(yaw.cos(), yaw.sin(), 0.0);
        self.oriented_box(foot, at(2.0, 0.9, 0.18), yaw, Material::Concrete);
        let shaft = foot + Vector3::z() * 0.55;
        self.cylinder(shaft - forward * 0.85, shaft - forward * 0.1, 0.24, Material::BluePaint);
        for fin in 0..6 {
            let middle = shaft - forward * (0.8 - 0.11 * f64::from(fin));
            self.cylinder(middle, middle + forward * 0.02, 0.275, Material::BluePaint);
        }
        self.oriented_box(
            foot + Vector3::z() * 0.18 - forward * 0.45,
            at(0.7, 0.4, 0.16),
            yaw,
            Material::DarkPaint,
        );
        self.oriented_box(
            shaft + Vector3::z() * 0.22 - forward * 0.5,
            at(0.26, 0.24, 0.14),
            yaw,
            Material::BluePaint,
        );
        self.cylinder(shaft - forward * 0.1, shaft + forward * 0.35, 0.05, Material::Steel);
        self.cylinder(shaft + forward * 0.35, shaft + forward * 0.62, 0.3, Material::DarkPaint);
        self.pipe(
            &[shaft + forward * 0.62, shaft + forward * 1.1, shaft + forward * 1.1 + Vector3::z() * 2.2],
            0.085,
            Material::Galvanised,
        );
        let riser = shaft + forward * 0.48;
        self.pipe(&[riser, riser + Vector3::z() * 2.2], 0.07, Material::Galvanised);
        self.valve(riser + Vector3::z() * 0.9, Vector3::z().cross(&forward));
    }

    /// A hand wheel on a stem along the unit vector `out`.
    pub(super) fn valve(&mut self, middle: Vector3, out: Vector3) {
        let side = Vector3::z().cross(&out).try_normalize(1e-6).unwrap_or_else(Vector3::x);
        let up = out.cross(&side);
        self.sphere(middle, 0.14, Material::Steel);
        let hub = middle + out * 0.35;
        self.cylinder(middle, hub, 0.025, Material::Steel);
        let rim = |i: usize| {
            let (sin, cos) = (i as f64 * std::f64::consts::TAU / 8.0).sin_cos();
            hub + side * (0.16 * cos) + up * (0.16 * sin)
        };
        for i in 0..8 {
            self.cylinder(rim(i), rim(i + 1), 0.013, Material::YellowPaint);
        }
    }

    /// A machine tool or skid in a cabinet, with control panel, lamp and feet; `size` is its footprint and height.
    pub(super) fn machine(&mut self, foot: Vector3, size: Vector3, yaw: f64) {
        self.movable(|b| b.put_machine(foot, size, yaw));
    }

    fn put_machine(&mut self, foot: Vector3, size: Vector3, yaw: f64) {
        let turn = nalgebra::Rotation3::from_euler_angles(0.0, 0.0, yaw);
        let local = |x: f64, y: f64, z: f64| foot + turn * at(x * size.x, y * size.y, z);
        self.oriented_box(local(0.0, 0.0, 0.0), at(size.x, size.y, 0.12), yaw, Material::DarkPaint);
        self.oriented_box(
            local(0.0, 0.05, 0.12),
            at(size.x * 0.96, size.y * 0.85, size.z * 0.55),
            yaw,
            Material::WhiteSheet,
        );
        let top = 0.12 + size.z * 0.55;
        self.oriented_box(
            local(-0.16, 0.08, top),
            at(size.x * 0.6, size.y * 0.7, size.z * 0.4),
            yaw,
            Material::BluePaint,
        );
        self.oriented_box(
            local(0.33, 0.1, top),
            at(size.x * 0.26, size.y * 0.5, size.z * 0.2),
            yaw,
            Material::DarkPaint,
        );
        self.oriented_box(local(0.42, -0.62, 0.9), at(0.5, 0.1, 0.55), yaw + 0.4, Material::DarkPaint);
        self.cylinder(local(0.42, -0.6, 0.0), local(0.42, -0.6, 0.9), 0.04, Material::Steel);
        let mast = local(-0.4, 0.3, top + size.z * 0.4);
        self.cylinder(mast, mast + Vector3::z() * 0.5, 0.035, Material::YellowPaint);
        self.pipe(
            &[
                local(0.33, 0.2, top + size.z * 0.2),
                local(0.33, 0.2, size.z + 0.9),
                local(-0.1, 0.2, size.z + 0.9),
                local(-0.1, 0.2, size.z * 0.95),
            ],
            0.07,
            Material::Galvanised,
        );
    }

    /// A row of switch cabinets along x (or y if `turned`), doors with handles on their front side.
    pub(super) fn cabinets(&mut self, foot: Vector3, count: usize, turned: bool) {
        self.movable(|b| b.put_cabinets(foot, count, turned));
    }

    fn put_cabinets(&mut self, foot: Vector3, count: usize, turned: bool) {
        for i in 0..count {
            let along = 0.82 * i as f64;
            let (low, size) = if turned {
                (at(0.0, along, 0.0), at(0.6, 0.8, 2.1))
            } else {
                (at(along, 0.0, 0.0), at(0.8, 0.6, 2.1))
            };
            self.aligned_box(foot + low, foot + low + size, Material::WhiteSheet);
            let handle = foot + low + if turned { at(-0.04, 0.7, 1.0) } else { at(0.7, -0.04, 1.0) };
            self.aligned_box(handle, handle + at(0.04, 0.04, 0.25), Material::DarkPaint);
        }
        let length = 0.82 * count as f64;
        let (from, to) = if turned {
            (at(0.3, 0.0, 2.5), at(0.3, length, 2.5))
        } else {
            (at(0.0, 0.3, 2.5), at(length, 0.3, 2.5))
        };
        self.tray(foot + from, foot + to, 0.4);
    }

    /// A ladder-type cable tray with cables, along a level segment.
    pub(super) fn tray(&mut self, from: Vector3, to: Vector3, width: f64) {
        let unit = (to - from).normalize();
        let side = Vector3::z().cross(&unit) * (width / 2.0);
        self.beam(from + side, to + side, 0.02, 0.1, Material::Galvanised);
        self.beam(from - side, to - side, 0.02, 0.1, Material::Galvanised);
        self.beam(from - Vector3::z() * 0.04, to - Vector3::z() * 0.04, width, 0.015, Material::Galvanised);
        for share in [-0.6, 0.1, 0.5] {
            let cable = side * share + Vector3::z() * 0.02;
            self.cylinder(from + cable, to + cable, 0.03, Material::Rubber);
        }
    }

    /// A table with legs and objects on it. `size` is the size of its top.
    pub(super) fn table(&mut self, foot: Vector3, size: [f64; 2], yaw: f64) {
        self.movable(|b| b.put_table(foot, size, yaw));
    }

    fn put_table(&mut self, foot: Vector3, size: [f64; 2], yaw: f64) {
        let turn = nalgebra::Rotation3::from_euler_angles(0.0, 0.0, yaw);
        let local = |x: f64, y: f64, z: f64| foot + turn * at(x * size[0], y * size[1], z);
        self.oriented_box(local(0.0, 0.0, 0.72), at(size[0], size[1], 0.04), yaw, Material::Wood);
        for (x, y) in [(-0.46, -0.44), (0.46, -0.44), (0.46, 0.44), (-0.46, 0.44)] {
            self.cylinder(local(x, y, 0.0), local(x, y, 0.72), 0.03, Material::Steel);
        }
        for _ in 0..3 {
            let (x, y) = (self.rng.range(-0.38, 0.38), self.rng.range(-0.3, 0.3));
            let goods = at(self.rng.range(0.15, 0.4), self.rng.range(0.1, 0.3), self.rng.range(0.08, 0.4));
            let turned = yaw + self.rng.range(-0.5, 0.5);
            self.oriented_box(local(x, y, 0.76), goods, turned, Material::DarkPaint);
        }
    }

    /// An office chair.
    pub(super) fn chair(&mut self, foot: Vector3, yaw: f64) {
        self.movable(|b| b.put_chair(foot, yaw));
    }

    fn put_chair(&mut self, foot: Vector3, yaw: f64) {
        let back = at(-0.22 * yaw.cos(), -0.22 * yaw.sin(), 0.0);
        self.oriented_box(foot + Vector3::z() * 0.44, at(0.46, 0.46, 0.08), yaw, Material::Cloth);
        self.oriented_box(foot + back + Vector3::z() * 0.55, at(0.06, 0.42, 0.5), yaw, Material::Cloth);
        self.cylinder(foot + Vector3::z() * 0.06, foot + Vector3::z() * 0.44, 0.03, Material::Steel);
        self.cylinder(foot, foot + Vector3::z() * 0.06, 0.26, Material::DarkPaint);
    }

    /// An open door leaf: a point on its hinge, its direction (radians), width and height (metres).
    pub(super) fn leaf(&mut self, hinge: Vector3, yaw: f64, width: f64, height: f64, material: Material) {
        let first = self.plan.solids.len();
        let along = at(yaw.cos(), yaw.sin(), 0.0);
        let middle = hinge + along * (width / 2.0);
        self.oriented_box(middle + Vector3::z() * 0.01, at(width, 0.045, height), yaw, material);
        let handle = hinge + along * (width * 0.9) + Vector3::z() * 1.05;
        let out = Vector3::z().cross(&along) * 0.08;
        self.cylinder(handle - out, handle + out, 0.012, Material::Steel);
        let solids = first..self.plan.solids.len();
        self.plan.door_leaves.push(DoorLeaf { solids, hinge });
    }

    /// A fire extinguisher on its hook, with a reflecting sign above; `out` is the unit vector away from the wall.
    pub(super) fn extinguisher(&mut self, wall: Vector3, out: Vector3) {
        let bottle = wall + out * 0.12;
        self.cylinder(bottle + Vector3::z() * 0.4, bottle + Vector3::z() * 0.95, 0.08, Material::BluePaint);
        self.cylinder(bottle + Vector3::z() * 0.95, bottle + Vector3::z() * 1.05, 0.03, Material::DarkPaint);
        self.sign(wall + Vector3::z() * 1.7, out, 0.3);
    }

    /// A square reflecting sign flat on a wall.
    pub(super) fn sign(&mut self, middle: Vector3, out: Vector3, size: f64) {
        let side = Vector3::z().cross(&out).abs() * (size / 2.0);
        let half = side + Vector3::z() * (size / 2.0) + out.abs() * 0.01;
        self.aligned_box(middle + out * 0.02 - half, middle + out * 0.02 + half, Material::Reflector);
    }

    /// A ventilation duct of rectangular section with seams, along a level segment.
    pub(super) fn duct(&mut self, from: Vector3, to: Vector3, width: f64, height: f64) {
        self.beam(from, to, width, height, Material::Galvanised);
        let unit = (to - from).normalize();
        for seam in 0..((to - from).norm() / 1.5) as usize {
            let middle = from + unit * (0.75 + 1.5 * seam as f64);
            self.beam(middle, middle + unit * 0.04, width + 0.06, height + 0.06, Material::Galvanised);
        }
    }

    /// A charging dock behind a robot that looks along `yaw`. Its solids follow from its pose.
    pub(super) fn dock(&mut self, foot: Vector3, yaw: f64) {
        self.plan.docks.push(SimulatedDock { position: geometry::vec_to_plain(&foot), yaw });
    }
}
