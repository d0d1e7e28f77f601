//! Furniture of generated buildings. A piece is put where it fits: inside its room, clear of the routes and of the pieces before it.

use super::choice::{chance, pick};
use super::layout::{BuildingLayout, Corridors, Doorway, Rect, Room, RoomUse};
use super::walk::Walks;
use crate::shape::{Material, Solid};
use crate::site::parts::{Builder, at};
use geometry::{RngTree, Vector3};
use std::f64::consts::FRAC_PI_2;

/// Least distance of furniture from a route, metres. The robot is 0.9 m wide with its clearance, and keeps within 0.15 m of its route.
const ROUTE_CLEARANCE_M: f64 = 0.68;
/// Distance between the points of the route that are checked, metres.
const ROUTE_STEP_M: f64 = 0.1;
/// A solid that begins above this height does not obstruct a walk, metres above the floor.
const HEAD_HEIGHT_M: f64 = 1.6;
/// Distance between pieces, metres.
const GAP_M: f64 = 0.04;
/// Greatest thickness of an inner wall from its axis, metres.
const WALL_HALF_M: f64 = 0.12;

/// Furnishes all rooms and corridors.
pub(super) fn furnish(b: &mut Builder, layout: &BuildingLayout, walks: &Walks, tree: &RngTree) {
    let route: Vec<Vec<[f64; 2]>> = [0, 1].map(|storey| route_points(walks, storey)).into();
    for (index, room) in layout.rooms.iter().enumerate() {
        // Standard rooms share their random numbers, so rooms of the same size and door are furnished alike.
        let name = if room.is_standard { "standard office".to_owned() } else { format!("room {index}") };
        b.rng = tree.child(&name).rng();
        let mut space = Space::new(b, layout, room.storey, room.rect.inset(WALL_HALF_M), &route[room.storey]);
        space.room(room, layout.ceiling(room));
    }
    for storey in [0, 1] {
        for (index, area) in layout.corridor_areas().iter().enumerate() {
            b.rng = tree.child(&format!("corridor {storey} {index}")).rng();
            let mut space = Space::new(b, layout, storey, area.inset(WALL_HALF_M), &route[storey]);
            space.corridor(&corridor_openings(layout, storey));
        }
    }
}

/// Middles and widths of the openings in the walls of a storey's corridors: doors, stairs and other corridors.
fn corridor_openings(layout: &BuildingLayout, storey: usize) -> Vec<([f64; 2], f64)> {
    let rooms = layout.rooms.iter().filter(|room| room.storey == storey);
    let mut openings: Vec<_> = rooms.map(|room| (room.door.at, room.door.width)).collect();
    openings.push(([layout.stairs.center()[0], layout.stairs.min[1]], layout.stairs.size(0)));
    if let Corridors::Ring { south, north, west, east } = layout.corridors {
        let corners = [[west, south], [east, south], [west, north], [east, north]];
        openings.extend(corners.map(|corner| (corner, 2.0 * layout.corridor_width)));
    }
    openings
}

/// Points along the round on a storey.
fn route_points(walks: &Walks, storey: usize) -> Vec<[f64; 2]> {
    let start = walks.docks.first().map(|(position, _)| [position.x, position.y]);
    let mut points: Vec<[f64; 2]> = Vec::new();
    let mut last = start.filter(|_| storey == 0);
    for corner in &walks.round {
        if corner.storey != Some(storey) {
            last = None;
            continue;
        }
        let from = last.unwrap_or(corner.at);
        let steps = ((corner.at[0] - from[0]).hypot(corner.at[1] - from[1]) / ROUTE_STEP_M).ceil().max(1.0);
        points.extend((0..=steps as usize).map(|step| {
            [0, 1].map(|axis| from[axis] + (corner.at[axis] - from[axis]) * step as f64 / steps)
        }));
        last = Some(corner.at);
    }
    // Docks lie on the walks through their rooms, with the standing robot behind the last corner.
    let docks = walks.docks.iter().filter(|(position, _)| (position.z > 1.0) == (storey == 1));
    points.extend(docks.flat_map(|(position, yaw)| {
        [-0.6, -0.3, 0.0, 0.5].map(|back| [position.x + back * yaw.cos(), position.y + back * yaw.sin()])
    }));
    points
}

/// A place at a wall.
#[derive(Clone, Copy)]
struct WallPlace {
    /// Point on the face of the wall, on the floor.
    foot: Vector3,
    /// Unit vector along the wall, with the room on its left.
    along: Vector3,
    /// Unit vector into the room.
    inward: Vector3,
}

impl WallPlace {
    /// The point that is that far from the wall, on the floor.
    fn off(&self, distance: f64) -> Vector3 {
        self.foot + self.inward * distance
    }

    /// Heading of a piece whose width lies along the wall and whose front looks into the room.
    fn yaw(&self) -> f64 {
        self.along.y.atan2(self.along.x)
    }

    /// Whether the wall runs along y.
    fn is_turned(&self) -> bool {
        self.along.y.abs() > 0.5
    }
}

/// The free floor of a room or corridor while it is furnished.
struct Space<'a> {
    b: &'a mut Builder,
    rect: Rect,
    floor: f64,
    /// Points of the route in and around the rectangle.
    route: Vec<[f64; 2]>,
    placed: Vec<Rect>,
}

impl<'a> Space<'a> {
    fn new(
        b: &'a mut Builder,
        layout: &BuildingLayout,
        storey: usize,
        rect: Rect,
        route: &[[f64; 2]],
    ) -> Self {
        let route = route.iter().copied().filter(|point| rect.distance(*point) < 2.0).collect();
        Self { b, rect, floor: layout.floor(storey), route, placed: Vec::new() }
    }

    /// Keeps the solids that `put` adds if they fit; otherwise removes them. Returns whether they fit.
    fn place(&mut self, put: impl FnOnce(&mut Builder)) -> bool {
        let plan = &self.b.plan;
        let before = (plan.solids.len(), plan.furniture.len(), plan.door_leaves.len());
        put(self.b);
        let added = &self.b.plan.solids[before.0..];
        let footprint = added.iter().map(footprint).reduce(|a, b| Rect {
            min: [0, 1].map(|axis| a.min[axis].min(b.min[axis])),
            max: [0, 1].map(|axis| a.max[axis].max(b.max[axis])),
        });
        let fits = footprint.is_some_and(|footprint| {
            let grown = footprint.inset(-GAP_M);
            self.rect.contains_rect(&footprint)
                && !self.placed.iter().any(|other| other.overlaps(&grown))
                && added.iter().all(|solid| self.leaves_route_free(solid))
        });
        if fits {
            self.placed.extend(footprint);
        } else {
            let plan = &mut self.b.plan;
            plan.solids.truncate(before.0);
            plan.furniture.truncate(before.1);
            plan.door_leaves.truncate(before.2);
        }
        fits
    }

    fn leaves_route_free(&self, solid: &Solid) -> bool {
        let rect = footprint(solid);
        solid.shape.bounds().0.z > self.floor + HEAD_HEIGHT_M
            || self.route.iter().all(|point| rect.distance(*point) >= ROUTE_CLEARANCE_M)
    }

    /// Places along all walls, from corner to corner, at drawn distances. `put` returns the width that it took, or `None` if nothing fitted.
    fn along_walls(&mut self, mut put: impl FnMut(&mut Self, WallPlace) -> Option<f64>) {
        let [x, y] = [[self.rect.min[0], self.rect.max[0]], [self.rect.min[1], self.rect.max[1]]];
        let floor = self.floor;
        let walls = [
            (at(x[0], y[0], floor), Vector3::x(), x[1] - x[0]),
            (at(x[1], y[0], floor), Vector3::y(), y[1] - y[0]),
            (at(x[1], y[1], floor), -Vector3::x(), x[1] - x[0]),
            (at(x[0], y[1], floor), -Vector3::y(), y[1] - y[0]),
        ];
        for (corner, along, length) in walls {
            let inward = Vector3::z().cross(&along);
            let mut done = self.b.rng.range(0.05, 0.6);
            while done < length {
                let place = WallPlace { foot: corner + along * done, along, inward };
                let width = put(self, place);
                done += width.map_or(0.35, |width| width + self.b.rng.range(0.05, 1.1));
            }
        }
    }

    /// Tries a piece in the middle of the room and then at random places.
    fn somewhere(&mut self, tries: usize, mut put: impl FnMut(&mut Builder, Vector3)) -> bool {
        for attempt in 0..tries {
            let [x, y] = if attempt == 0 {
                self.rect.center()
            } else {
                [0, 1].map(|axis| self.b.rng.range(self.rect.min[axis], self.rect.max[axis]))
            };
            let foot = at(x, y, self.floor);
            if self.place(|b| put(b, foot)) {
                return true;
            }
        }
        false
    }

    fn room(&mut self, room: &Room, ceiling: f64) {
        self.door_leaf(&room.door);
        match room.usage {
            RoomUse::Office | RoomUse::Meeting => self.table_group(room.usage == RoomUse::Meeting),
            RoomUse::Laboratory | RoomUse::Kitchen => {
                self.somewhere(3, |b, foot| b.table(foot, [1.8, 0.9], 0.0));
            }
            RoomUse::Workshop => {
                for _ in 0..2 {
                    let yaw = pick(&mut self.b.rng, &[0.0, FRAC_PI_2]) + self.b.rng.range(-0.04, 0.04);
                    let size = at(self.b.rng.range(1.2, 2.4), self.b.rng.range(0.8, 1.3), 1.8);
                    self.somewhere(6, |b, foot| b.machine(foot, size, yaw));
                }
            }
            RoomUse::PlantRoom => {
                for _ in 0..2 {
                    let turned = chance(&mut self.b.rng, 0.5);
                    self.somewhere(6, |b, foot| b.pump(foot, turned));
                }
            }
            RoomUse::Store | RoomUse::Archive => {}
            RoomUse::Hall => self.hall(ceiling - self.floor),
        }
        self.along_walls(|space, place| space.wall_piece(room.usage, place));
        if matches!(room.usage, RoomUse::Store | RoomUse::Workshop | RoomUse::Hall) {
            for _ in 0..6 {
                let (turned, is_drum) = (chance(&mut self.b.rng, 0.5), chance(&mut self.b.rng, 0.4));
                self.somewhere(
                    2,
                    |b, foot| {
                        if is_drum { b.drum(foot, 0.3, 0.9) } else { b.pallet(foot, turned, 1.3) }
                    },
                );
            }
        }
    }

    /// A leaf that is open by 100 to 170 degrees, hinged at one side of the opening.
    fn door_leaf(&mut self, door: &Doorway) {
        if !door.has_leaf {
            return;
        }
        let [dx, dy] = door.inward;
        let inward = at(dx, dy, 0.0);
        let left = Vector3::z().cross(&inward);
        let side = if chance(&mut self.b.rng, 0.5) { 1.0 } else { -1.0 };
        let (open, wood) = (self.b.rng.range(1.75, 2.95), chance(&mut self.b.rng, 0.7));
        let material = if wood { Material::Wood } else { Material::Galvanised };
        let hinge = at(door.at[0], door.at[1], self.floor)
            + left * (side * door.width / 2.0)
            + inward * (WALL_HALF_M + 0.1);
        // A closed leaf lies along the wall, from the hinge to the other side. It turns into the room.
        let closed = left * -side;
        let yaw = closed.y.atan2(closed.x) + open * closed.cross(&inward).z.signum();
        let (width, height) = ((door.width - 0.05).min(1.0), door.height - 0.06);
        self.place(|b| b.leaf(hinge, yaw, width, height, material));
    }

    /// A table in the middle, with chairs round it.
    fn table_group(&mut self, is_meeting: bool) {
        let length = if is_meeting { self.b.rng.range(1.8, 3.2) } else { 1.4 };
        let chairs = if is_meeting { (length / 0.75) as usize } else { 1 };
        let put = self.somewhere(4, |b, foot| b.table(foot, [length, 0.9], 0.0));
        let Some(table) = self.placed.last().copied().filter(|_| put) else { return };
        for i in 0..chairs {
            let x = table.min[0] + (i as f64 + 0.5) * table.size(0) / chairs as f64;
            for (y, yaw) in [(table.min[1] - 0.35, FRAC_PI_2), (table.max[1] + 0.35, -FRAC_PI_2)] {
                let yaw = yaw + self.b.rng.range(-0.4, 0.4);
                let foot = at(x, y, self.floor);
                self.place(|b| b.chair(foot, yaw));
            }
        }
    }

    /// Racks, tanks and machines of a hall of that height, where its walk leaves room.
    fn hall(&mut self, height: f64) {
        let levels = if height > 5.5 { 3 } else { 1 };
        let with_racks = chance(&mut self.b.rng, 0.6);
        for _ in 0..8 {
            let kind = self.b.rng.bits() % if with_racks { 6 } else { 3 };
            let turned = chance(&mut self.b.rng, 0.5);
            let (radius, length) = (self.b.rng.range(0.5, 1.0), self.b.rng.range(2.7, 6.0));
            self.somewhere(12, |b, foot| match kind {
                0 => b.tank(foot, radius, (height - 1.4).min(2.0 + 2.0 * radius)),
                1 => b.machine(foot, at(length.min(3.4), 1.6, 2.0), if turned { FRAC_PI_2 } else { 0.0 }),
                2 => b.vessel(
                    foot + Vector3::z() * (radius * 0.6 + 0.5),
                    if turned { Vector3::y() } else { Vector3::x() },
                    length.min(3.0),
                    radius * 0.6,
                ),
                _ => b.rack(foot, length, levels, turned),
            });
        }
        // Columns along the long walls.
        let spacing = self.b.rng.range(4.0, 6.0);
        let turned = self.rect.size(1) > self.rect.size(0);
        let axis = usize::from(turned);
        for i in 1..(self.rect.size(axis) / spacing).ceil() as usize {
            for across in [self.rect.min[1 - axis] + 0.23, self.rect.max[1 - axis] - 0.23] {
                let along = self.rect.min[axis] + spacing * i as f64;
                let foot = if turned { at(across, along, self.floor) } else { at(along, across, self.floor) };
                self.place(|b| b.column(foot, height, turned, Material::BluePaint));
            }
        }
    }

    /// One piece at a wall; returns its width.
    fn wall_piece(&mut self, usage: RoomUse, place: WallPlace) -> Option<f64> {
        let kind = self.b.rng.uniform();
        let size = |low: f64, high: f64, share: f64| low + (high - low) * share;
        let share = self.b.rng.uniform();
        match usage {
            RoomUse::Office | RoomUse::Meeting => match kind {
                0.0..0.4 => self.desk(place, size(1.3, 1.8, share)),
                0.4..0.75 => self.cupboard(place, size(0.8, 1.8, share), 0.45, Material::Wood),
                0.75..0.85 => self.plant(place),
                _ => self.board(place, size(1.0, 2.0, share)),
            },
            RoomUse::Laboratory => match kind {
                0.0..0.5 => self.bench(place, size(1.6, 2.8, share)),
                0.5..0.7 => self.cabinets(place, 2 + (share * 3.0) as usize),
                _ => self.cupboard(place, size(0.8, 1.4, share), 0.5, Material::WhiteSheet),
            },
            RoomUse::Workshop | RoomUse::Hall => match kind {
                0.0..0.3 => self.bench(place, size(1.6, 2.6, share)),
                0.3..0.5 => self.cabinets(place, 2 + (share * 4.0) as usize),
                0.5..0.7 => self.rack(place, 2.7, 1),
                0.7..0.85 => self.cupboard(place, size(0.9, 1.6, share), 0.5, Material::DarkPaint),
                _ => self.drum(place),
            },
            RoomUse::Store => match kind {
                0.0..0.5 => self.rack(place, if share < 0.5 { 2.7 } else { 5.4 }, 1),
                0.5..0.8 => self.shelves(place, size(0.9, 2.0, share)),
                _ => self.drum(place),
            },
            RoomUse::Archive => match kind {
                0.0..0.8 => self.shelves(place, size(0.9, 2.4, share)),
                _ => self.cupboard(place, size(0.8, 1.2, share), 0.4, Material::Galvanised),
            },
            RoomUse::PlantRoom => match kind {
                0.0..0.45 => self.cabinets(place, 1 + (share * 4.0) as usize),
                0.45..0.7 => self.riser(place, share),
                _ => self.boiler(place, size(0.35, 0.6, share)),
            },
            RoomUse::Kitchen => match kind {
                0.0..0.5 => self.counter(place, size(1.2, 2.6, share)),
                0.5..0.8 => self.cupboard(place, size(0.6, 1.2, share), 0.6, Material::WhiteSheet),
                _ => self.plant(place),
            },
        }
    }

    /// A box of that width at a wall, from height `low` to `high`.
    fn wall_box(b: &mut Builder, place: &WallPlace, size: Vector3, low: f64, material: Material) {
        let foot = place.off(size.y / 2.0 + 0.01) + place.along * (size.x / 2.0) + Vector3::z() * low;
        b.oriented_box(foot, size, place.yaw(), material);
    }

    fn desk(&mut self, place: WallPlace, width: f64) -> Option<f64> {
        let fits = self.place(|b| {
            b.movable(|b| {
                let middle = place.off(0.42) + place.along * (width / 2.0);
                b.oriented_box(
                    middle + Vector3::z() * 0.72,
                    at(width, 0.8, 0.04),
                    place.yaw(),
                    Material::Wood,
                );
                for end in [0.03, width - 0.03] {
                    let leg = place.off(0.42) + place.along * end;
                    b.oriented_box(leg, at(0.04, 0.7, 0.72), place.yaw(), Material::Galvanised);
                }
                let screen = place.off(0.2) + place.along * (width * 0.5) + Vector3::z() * 0.78;
                b.oriented_box(screen, at(0.55, 0.05, 0.38), place.yaw(), Material::DarkPaint);
                b.oriented_box(middle, at(0.4, 0.5, 0.6), place.yaw(), Material::WhiteSheet);
            });
        });
        let yaw = place.yaw() - FRAC_PI_2 + self.b.rng.range(-0.5, 0.5);
        let seat = place.off(1.15) + place.along * (width * 0.5);
        if fits {
            self.place(|b| b.chair(seat, yaw));
        }
        fits.then_some(width)
    }

    fn cupboard(&mut self, place: WallPlace, width: f64, depth: f64, material: Material) -> Option<f64> {
        let height = pick(&mut self.b.rng, &[0.8, 1.2, 1.9, 2.1]);
        let fits = self.place(|b| {
            b.movable(|b| {
                Self::wall_box(b, &place, at(width, depth, height), 0.0, material);
                let doors = (width / 0.5).round().max(1.0) as usize;
                for door in 0..doors {
                    let along = place.along * (width * (door as f64 + 0.85) / doors as f64);
                    let handle = place.off(depth + 0.02) + along + Vector3::z() * (height * 0.55);
                    b.oriented_box(handle, at(0.03, 0.03, 0.15), place.yaw(), Material::Steel);
                }
            });
        });
        fits.then_some(width)
    }

    /// Open shelves with boxes.
    fn shelves(&mut self, place: WallPlace, width: f64) -> Option<f64> {
        let fits = self.place(|b| {
            b.movable(|b| {
                for end in [0.02, width - 0.02] {
                    let side = place.off(0.21) + place.along * end;
                    b.oriented_box(side, at(0.03, 0.4, 2.0), place.yaw(), Material::Galvanised);
                }
                for shelf in 0..5 {
                    let z = 0.08 + 0.46 * f64::from(shelf);
                    let middle = place.off(0.21) + place.along * (width / 2.0) + Vector3::z() * z;
                    b.oriented_box(middle, at(width, 0.4, 0.03), place.yaw(), Material::Galvanised);
                    let mut along = 0.06;
                    while shelf < 4 && along < width - 0.35 {
                        let box_width = b.rng.range(0.15, 0.3);
                        let height = b.rng.range(0.15, 0.38);
                        if chance(&mut b.rng, 0.75) {
                            let foot = place.off(0.2) + place.along * (along + box_width / 2.0);
                            let size = at(box_width, b.rng.range(0.22, 0.34), height);
                            let foot = foot + Vector3::z() * (z + 0.03);
                            b.oriented_box(foot, size, place.yaw(), Material::Cardboard);
                        }
                        along += box_width + b.rng.range(0.02, 0.2);
                    }
                }
            });
        });
        fits.then_some(width)
    }

    /// A workbench with a tool board and things on it.
    fn bench(&mut self, place: WallPlace, width: f64) -> Option<f64> {
        let fits = self.place(|b| {
            let middle = place.off(0.36) + place.along * (width / 2.0);
            b.table(middle, [width, 0.68], place.yaw());
            Self::wall_box(b, &place, at(width * 0.9, 0.03, 0.7), 1.1, Material::DarkPaint);
        });
        fits.then_some(width)
    }

    fn counter(&mut self, place: WallPlace, width: f64) -> Option<f64> {
        let fits = self.place(|b| {
            Self::wall_box(b, &place, at(width, 0.6, 0.88), 0.0, Material::WhiteSheet);
            Self::wall_box(b, &place, at(width, 0.63, 0.04), 0.88, Material::Wood);
            Self::wall_box(b, &place, at(width * 0.8, 0.35, 0.6), 1.45, Material::WhiteSheet);
        });
        fits.then_some(width)
    }

    fn cabinets(&mut self, place: WallPlace, count: usize) -> Option<f64> {
        let (width, turned) = (0.82 * count as f64, place.is_turned());
        // The row begins at its corner with the least coordinates. Handles are on its side of least y (x if turned).
        let (a, c) = (place.off(0.02), place.off(0.62) + place.along * width);
        let foot = a.inf(&c);
        self.place(|b| b.cabinets(foot, count, turned)).then_some(width)
    }

    fn rack(&mut self, place: WallPlace, length: f64, levels: usize) -> Option<f64> {
        let (a, c) = (place.off(0.1), place.off(1.2) + place.along * length);
        let (foot, turned) = (a.inf(&c), place.is_turned());
        self.place(|b| b.rack(foot, length, levels, turned)).then_some(length + 0.1)
    }

    fn drum(&mut self, place: WallPlace) -> Option<f64> {
        let foot = place.off(0.4) + place.along * 0.4;
        self.place(|b| b.drum(foot, 0.3, 0.9)).then_some(0.8)
    }

    /// A standing vessel with pipes to the ceiling.
    fn boiler(&mut self, place: WallPlace, radius: f64) -> Option<f64> {
        let foot = place.off(radius + 0.2) + place.along * (radius + 0.1);
        let height = self.b.rng.range(1.3, 1.9);
        let fits = self.place(|b| {
            b.cylinder(foot, foot + Vector3::z() * 0.1, radius + 0.05, Material::Concrete);
            b.cylinder(foot, foot + Vector3::z() * height, radius, Material::WhiteSheet);
            for (offset, size) in [(0.15, 0.05), (-0.15, 0.04)] {
                let pipe = foot + place.along * offset;
                b.pipe(
                    &[pipe + Vector3::z() * height, pipe + Vector3::z() * 2.4],
                    size,
                    Material::Galvanised,
                );
            }
            b.valve(foot + place.inward * radius + Vector3::z() * 0.6, place.inward);
        });
        fits.then_some(2.0 * radius + 0.2)
    }

    /// Pipes along a wall from the floor upwards.
    fn riser(&mut self, place: WallPlace, share: f64) -> Option<f64> {
        let count = 2 + (share * 3.0) as usize;
        let fits = self.place(|b| {
            for i in 0..count {
                let radius = b.rng.range(0.03, 0.09);
                let foot = place.off(0.15) + place.along * (0.15 + 0.25 * i as f64);
                b.pipe(&[foot, foot + Vector3::z() * 2.5], radius, Material::Galvanised);
            }
        });
        fits.then_some(0.25 * count as f64 + 0.1)
    }

    /// A pot plant.
    fn plant(&mut self, place: WallPlace) -> Option<f64> {
        let foot = place.off(0.3) + place.along * 0.3;
        let fits = self.place(|b| {
            b.movable(|b| {
                b.cylinder(foot, foot + Vector3::z() * 0.35, 0.17, Material::DarkPaint);
                for _ in 0..6 {
                    let offset =
                        at(b.rng.range(-0.12, 0.12), b.rng.range(-0.12, 0.12), b.rng.range(0.5, 1.3));
                    let radius = b.rng.range(0.08, 0.16);
                    b.sphere(foot + offset, radius, Material::Foliage);
                }
            });
        });
        fits.then_some(0.6)
    }

    /// A board on the wall.
    fn board(&mut self, place: WallPlace, width: f64) -> Option<f64> {
        let material = pick(&mut self.b.rng, &[Material::WhiteSheet, Material::DarkPaint, Material::Cloth]);
        self.place(|b| Self::wall_box(b, &place, at(width, 0.04, 1.0), 0.9, material)).then_some(width)
    }

    /// What stands along the long walls of a corridor, between its openings (middle and width).
    fn corridor(&mut self, openings: &[([f64; 2], f64)]) {
        let is_turned = self.rect.size(1) > self.rect.size(0);
        let is_clear = |place: &WallPlace| {
            let middle = place.foot + place.along * 0.5;
            let is_far = |(at, width): &([f64; 2], f64)| {
                (at[0] - middle.x).hypot(at[1] - middle.y) > width / 2.0 + 0.8
            };
            place.is_turned() == is_turned && openings.iter().all(is_far)
        };
        self.along_walls(|space, place| {
            let (kind, share) = (space.b.rng.uniform(), space.b.rng.uniform());
            if !is_clear(&place) {
                return None;
            }
            match kind {
                0.0..0.12 => space.cupboard(place, 0.8 + 0.8 * share, 0.35, Material::WhiteSheet),
                0.12..0.22 => {
                    let foot = place.off(0.03) + place.along * 0.3;
                    space.place(|b| b.extinguisher(foot, place.inward)).then_some(0.6)
                }
                0.22..0.36 => space.board(place, 0.6 + share),
                0.36..0.42 => space.plant(place),
                _ => Some(1.0 + 2.0 * share),
            }
        });
    }
}

/// Ground area of a solid.
fn footprint(solid: &Solid) -> Rect {
    let (least, most) = solid.shape.bounds();
    Rect { min: [least.x, least.y], max: [most.x, most.y] }
}
