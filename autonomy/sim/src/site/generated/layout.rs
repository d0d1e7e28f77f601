//! The plan of a generated building: its corridors, rooms, doors and stairs.
//!
//! The building is a rectangle from the origin of the site. Corridors lie at the same place on both floors. Strips of rooms lie along them, and
//! the stairs take a slot of the northern strip.

use super::choice::{chance, pick};
use geometry::Rng;

/// A rectangle along the axes of the site, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rect {
    pub(crate) min: [f64; 2],
    pub(crate) max: [f64; 2],
}

impl Rect {
    pub(crate) fn new(x: [f64; 2], y: [f64; 2]) -> Self {
        Self { min: [x[0], y[0]], max: [x[1], y[1]] }
    }

    /// Extent along an axis, metres.
    pub(crate) fn size(&self, axis: usize) -> f64 {
        self.max[axis] - self.min[axis]
    }

    pub(crate) fn center(&self) -> [f64; 2] {
        [0, 1].map(|axis| (self.min[axis] + self.max[axis]) / 2.0)
    }

    /// The rectangle without a margin on all sides.
    pub(crate) fn inset(&self, margin: f64) -> Self {
        Self { min: self.min.map(|c| c + margin), max: self.max.map(|c| c - margin) }
    }

    pub(crate) fn contains(&self, point: [f64; 2]) -> bool {
        (0..2).all(|axis| (self.min[axis]..=self.max[axis]).contains(&point[axis]))
    }

    pub(crate) fn contains_rect(&self, other: &Self) -> bool {
        self.contains(other.min) && self.contains(other.max)
    }

    /// Whether both share more than an edge.
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.min[axis] < other.max[axis] - 1e-9 && other.min[axis] < self.max[axis] - 1e-9)
    }

    /// Distance from a point to the rectangle; 0 inside it, metres.
    pub(crate) fn distance(&self, point: [f64; 2]) -> f64 {
        let gap = |axis: usize| (self.min[axis] - point[axis]).max(point[axis] - self.max[axis]).max(0.0);
        gap(0).hypot(gap(1))
    }
}

/// What a room is for. It decides on furniture, floor and windows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RoomUse {
    Office,
    Meeting,
    Laboratory,
    Workshop,
    Store,
    PlantRoom,
    Kitchen,
    Archive,
    Hall,
}

/// Uses of rooms on the ground floor. A use that stands twice is twice as frequent.
const GROUND_USES: [RoomUse; 8] = [
    RoomUse::Workshop,
    RoomUse::Workshop,
    RoomUse::Store,
    RoomUse::PlantRoom,
    RoomUse::Laboratory,
    RoomUse::Office,
    RoomUse::Archive,
    RoomUse::Kitchen,
];

/// Uses of rooms on the upper floor.
const UPPER_USES: [RoomUse; 8] = [
    RoomUse::Office,
    RoomUse::Office,
    RoomUse::Office,
    RoomUse::Meeting,
    RoomUse::Laboratory,
    RoomUse::Archive,
    RoomUse::Kitchen,
    RoomUse::PlantRoom,
];

/// The door of a room to its corridor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Doorway {
    /// Middle of the opening, on the axis of the wall.
    pub(crate) at: [f64; 2],
    /// Unit vector into the room.
    pub(crate) inward: [f64; 2],
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) has_leaf: bool,
}

/// A room.
#[derive(Clone, Debug)]
pub(crate) struct Room {
    /// 0 is the ground floor, 1 the upper floor.
    pub(crate) storey: usize,
    /// Between the axes of its walls.
    pub(crate) rect: Rect,
    pub(crate) usage: RoomUse,
    pub(crate) door: Doorway,
    /// Whether its furniture is that of all rooms of this kind, as in offices that were fitted out together.
    pub(crate) is_standard: bool,
    /// Whether it has a charging dock.
    pub(crate) has_dock: bool,
}

impl Room {
    /// Index of the axis across the door wall, and the axis along it.
    pub(crate) fn axes(&self) -> (usize, usize) {
        if self.door.inward[0].abs() > 0.5 { (0, 1) } else { (1, 0) }
    }

    /// The point that is `depth` metres into the room and has the coordinate `lateral` along the door wall.
    pub(crate) fn point(&self, depth: f64, lateral: f64) -> [f64; 2] {
        let (across, along) = self.axes();
        let mut point = [0.0; 2];
        point[across] = self.door.at[across] + self.door.inward[across] * depth;
        point[along] = lateral;
        point
    }
}

/// The axes of the corridors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Corridors {
    /// One corridor along x at that y.
    Spine { y: f64, west: f64, east: f64 },
    /// A ring of four corridors.
    Ring { south: f64, north: f64, west: f64, east: f64 },
}

/// The plan of a building, metres.
#[derive(Clone, Debug)]
pub(crate) struct BuildingLayout {
    /// Extent along x, between the inner faces of the outer walls.
    pub(crate) length: f64,
    /// Extent along y.
    pub(crate) width: f64,
    /// Height from floor to floor.
    pub(crate) storey_height: f64,
    /// Clear height of the upper floor.
    pub(crate) upper_height: f64,
    pub(crate) steps_per_flight: usize,
    pub(crate) corridor_width: f64,
    pub(crate) corridors: Corridors,
    pub(crate) rooms: Vec<Room>,
    pub(crate) stairs: Rect,
    /// Whether the hall takes both floors.
    pub(crate) hall_is_double: bool,
}

/// Width of the stairwell: two flights of 1.35 m side by side, metres.
pub(crate) const STAIRWELL_WIDTH: f64 = 3.0;
/// x of the middle of the lower flight, from the west wall of the stairwell, metres.
pub(crate) const LOWER_FLIGHT: f64 = 0.8;
/// x of the middle of the upper flight, metres.
pub(crate) const UPPER_FLIGHT: f64 = 2.25;
/// Distance from the corridor to the lowest step, metres.
pub(crate) const STAIRS_APPROACH: f64 = 1.5;
/// Depth of a step, metres.
pub(crate) const STEP_RUN: f64 = 0.28;
/// Least depth of the landing, metres.
const MIN_LANDING: f64 = 1.7;
/// Thickness of the upper floor, metres.
pub(crate) const SLAB: f64 = 0.25;
/// Least width of a room, metres.
const MIN_ROOM_WIDTH: f64 = 3.4;
/// Greatest width of a room outside halls, metres.
const MAX_ROOM_WIDTH: f64 = 9.0;
/// Least distance from the middle of a door to the next wall across, metres.
const DOOR_MARGIN: f64 = 1.1;

impl BuildingLayout {
    /// Height of the floor of a storey, metres.
    pub(crate) fn floor(&self, storey: usize) -> f64 {
        self.storey_height * storey as f64
    }

    /// Height of the roof's underside, metres.
    pub(crate) fn roof(&self) -> f64 {
        self.storey_height + self.upper_height
    }

    /// Height of a room's ceiling, metres.
    pub(crate) fn ceiling(&self, room: &Room) -> f64 {
        let is_tall = room.storey == 1 || (room.usage == RoomUse::Hall && self.hall_is_double);
        if is_tall { self.roof() } else { self.storey_height - SLAB }
    }

    /// Height of a step, metres.
    pub(crate) fn rise(&self) -> f64 {
        self.storey_height / (2 * self.steps_per_flight) as f64
    }

    /// y at which the lower flight ends and the landing begins, metres.
    pub(crate) fn landing(&self) -> f64 {
        self.stairs.min[1] + STAIRS_APPROACH + STEP_RUN * self.steps_per_flight as f64
    }

    /// The hall of the ground floor.
    pub(crate) fn hall(&self) -> Option<&Room> {
        self.rooms.iter().find(|room| room.usage == RoomUse::Hall && room.storey == 0)
    }

    /// Areas of the corridors of a floor.
    pub(crate) fn corridor_areas(&self) -> Vec<Rect> {
        let half = self.corridor_width / 2.0;
        match self.corridors {
            Corridors::Spine { y, west, east } => vec![Rect::new([west, east], [y - half, y + half])],
            Corridors::Ring { south, north, west, east } => {
                let x = [west - half, east + half];
                let between = [south + half, north - half];
                vec![
                    Rect::new(x, [south - half, south + half]),
                    Rect::new(x, [north - half, north + half]),
                    Rect::new([west - half, west + half], between),
                    Rect::new([east - half, east + half], between),
                ]
            }
        }
    }
}

/// A strip of rooms along a corridor.
struct Strip {
    /// Extent along x.
    x: [f64; 2],
    /// Extent along y.
    y: [f64; 2],
    /// 1 if the rooms lie north of their corridor, -1 if they lie south of it.
    side: f64,
}

/// Draws a building.
pub(super) fn draw(rng: &mut Rng) -> BuildingLayout {
    let steps_per_flight = 10 + (rng.bits() % 3) as usize;
    let storey_height = rng.range(0.165, 0.172) * (2 * steps_per_flight) as f64;
    let upper_height = rng.range(2.9, 3.8);
    let corridor_width = rng.range(1.9, 2.8);
    let stairs_depth = STAIRS_APPROACH + STEP_RUN * steps_per_flight as f64 + MIN_LANDING;
    let north_depth = stairs_depth + rng.range(0.0, 1.2);
    let south_depth = rng.range(4.4, 7.4);
    let is_ring = chance(rng, 0.4);
    let rooms_length = if is_ring { rng.range(17.0, 23.0) } else { rng.range(19.0, 29.0) };
    let has_hall = !is_ring && chance(rng, 0.75);
    let hall_length = if has_hall { rng.range(9.0, 15.0) } else { 0.0 };
    let hall_is_double = has_hall && chance(rng, 0.6);
    let core_depth = if is_ring { rng.range(4.6, 6.4) } else { 0.0 };
    let corridor_count = if is_ring { 2.0 } else { 1.0 };
    let width = south_depth + core_depth + north_depth + corridor_count * corridor_width;
    let (half, x) = (corridor_width / 2.0, [0.0, rooms_length]);
    let corridors = if is_ring {
        Corridors::Ring {
            south: south_depth + half,
            north: width - north_depth - half,
            west: half,
            east: rooms_length - half,
        }
    } else {
        Corridors::Spine { y: south_depth + half, west: 0.0, east: rooms_length }
    };
    let north = [width - north_depth, width];
    let stairs_west = draw_stairs_west(rng, rooms_length);
    let stairs = Rect::new([stairs_west, stairs_west + STAIRWELL_WIDTH], north);
    let mut strips = vec![
        Strip { x, y: [0.0, south_depth], side: -1.0 },
        Strip { x: [0.0, stairs.min[0]], y: north, side: 1.0 },
        Strip { x: [stairs.max[0], rooms_length], y: north, side: 1.0 },
    ];
    if is_ring {
        let y = [south_depth + corridor_width, south_depth + corridor_width + core_depth];
        let side = if chance(rng, 0.5) { 1.0 } else { -1.0 };
        strips.push(Strip { x: [corridor_width, rooms_length - corridor_width], y, side });
    }
    strips.retain(|strip| strip.x[1] - strip.x[0] > 0.1);
    let has_standard_rooms = chance(rng, 0.5);
    let mut rooms: Vec<Room> =
        strips.iter().flat_map(|strip| fill(rng, strip, 0, has_standard_rooms)).collect();
    // Half of the buildings have the same walls and doors on both floors, so that their corridors look alike.
    let upper: Vec<Room> = if chance(rng, 0.5) {
        rooms.iter().map(|room| refit(rng, room, has_standard_rooms)).collect()
    } else {
        strips.iter().flat_map(|strip| fill(rng, strip, 1, has_standard_rooms)).collect()
    };
    rooms.extend(upper);
    let length = rooms_length + hall_length;
    if has_hall {
        let mouth = [rooms_length, south_depth + half];
        let door = Doorway { at: mouth, inward: [1.0, 0.0], width: 1.7, height: 2.4, has_leaf: false };
        let rect = Rect::new([rooms_length, length], [0.0, width]);
        let hall = Room { storey: 0, rect, usage: RoomUse::Hall, door, is_standard: false, has_dock: false };
        if !hall_is_double {
            rooms.push(Room { storey: 1, ..hall.clone() });
        }
        rooms.push(hall);
    }
    set_docks(rng, &mut rooms);
    BuildingLayout {
        length,
        width,
        storey_height,
        upper_height,
        steps_per_flight,
        corridor_width,
        corridors,
        rooms,
        stairs,
        hall_is_double,
    }
}

/// West edge of the stairwell: at one end of the strip or inside it, with room for a room on each side.
fn draw_stairs_west(rng: &mut Rng, length: f64) -> f64 {
    let last = length - STAIRWELL_WIDTH;
    match rng.bits() % 4 {
        0 => 0.0,
        1 => last,
        _ => rng.range(MIN_ROOM_WIDTH, last - MIN_ROOM_WIDTH),
    }
}

/// Divides a strip into rooms: of equal width, or of drawn widths.
fn fill(rng: &mut Rng, strip: &Strip, storey: usize, has_standard_rooms: bool) -> Vec<Room> {
    let length = strip.x[1] - strip.x[0];
    let mut widths = Vec::new();
    if chance(rng, 0.4) {
        let count = (length / rng.range(4.0, 6.4)).floor().max(1.0);
        widths = vec![length / count; count as usize];
    } else {
        let mut left = length;
        while left > MIN_ROOM_WIDTH + MAX_ROOM_WIDTH {
            let width = rng.range(1.2 * MIN_ROOM_WIDTH, MAX_ROOM_WIDTH);
            widths.push(width);
            left -= width;
        }
        if left > MAX_ROOM_WIDTH || (left > 2.0 * MIN_ROOM_WIDTH && chance(rng, 0.5)) {
            let width = rng.range(MIN_ROOM_WIDTH, left - MIN_ROOM_WIDTH);
            widths.push(width);
            left -= width;
        }
        widths.push(left);
    }
    let mut west = strip.x[0];
    let last = widths.len() - 1;
    let mut rooms = Vec::new();
    for (index, width) in widths.into_iter().enumerate() {
        let east = if index == last { strip.x[1] } else { west + width };
        rooms.push(draw_room(rng, Rect::new([west, east], strip.y), strip.side, storey, has_standard_rooms));
        west = east;
    }
    rooms
}

fn draw_room(rng: &mut Rng, rect: Rect, side: f64, storey: usize, has_standard_rooms: bool) -> Room {
    let (west, east) = (rect.min[0] + DOOR_MARGIN, rect.max[0] - DOOR_MARGIN);
    let x = match rng.bits() % 3 {
        0 => west,
        1 => east,
        _ => rng.range(west, east),
    };
    let usage = pick(rng, if storey == 0 { &GROUND_USES } else { &UPPER_USES });
    let door = Doorway {
        at: [x, if side > 0.0 { rect.min[1] } else { rect.max[1] }],
        inward: [0.0, side],
        width: rng.range(1.25, 1.5),
        height: 2.1,
        has_leaf: chance(rng, 0.7),
    };
    let is_standard = has_standard_rooms && usage == RoomUse::Office;
    Room { storey, rect, usage, door, is_standard, has_dock: false }
}

/// The room above a room of the ground floor, with another use.
fn refit(rng: &mut Rng, below: &Room, has_standard_rooms: bool) -> Room {
    let usage = pick(rng, &UPPER_USES);
    let is_standard = has_standard_rooms && usage == RoomUse::Office;
    Room { storey: 1, usage, is_standard, ..below.clone() }
}

/// Puts a dock in the hall or in one of the larger rooms of the ground floor, and in half of the buildings one on the upper floor.
fn set_docks(rng: &mut Rng, rooms: &mut [Room]) {
    let area = |room: &Room| room.rect.size(0) * room.rect.size(1);
    let storeys: &[usize] = if chance(rng, 0.5) { &[0, 1] } else { &[0] };
    for &storey in storeys {
        let of_storey = rooms.iter_mut().filter(|room| room.storey == storey);
        if let Some(largest) = of_storey.max_by(|a, b| area(a).total_cmp(&area(b))) {
            largest.has_dock = true;
        }
    }
}
