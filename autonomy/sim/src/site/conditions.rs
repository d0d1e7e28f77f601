//! Changes of the condition of a site: doors at other angles, leaks, gauges that drift or are stuck, lamps that are out.

use vocab::Vec3;

/// A change of the condition of something that a site has. Positions are in the site frame, metres.
#[derive(Clone, Debug, PartialEq)]
pub enum ConditionChange {
    /// A door stands at another angle than usual.
    DoorTurned {
        /// A point on its hinge, as `SimulatedSite::door_hinges` says.
        hinge: Vec3,
        /// Angle from where it usually stands, counter-clockwise seen from above, radians.
        turn_rad: f64,
    },
    /// Something leaks.
    Leak(Leak),
    /// What a gauge shows moves away from the true value.
    GaugeDrifts {
        /// Its tag.
        tag: String,
        /// Shown value less true value, per day since the drift began, in the unit of the gauge.
        per_day: f64,
        /// Time from the beginning of the drift to the start of the simulation, days.
        begun_days_ago: f64,
    },
    /// A gauge always shows the same.
    GaugeStuck {
        /// Its tag.
        tag: String,
        /// What it shows, in its unit.
        value: f64,
    },
    /// A lamp gives no light.
    LampOut {
        /// The lamp.
        lamp: Vec3,
    },
}

/// A leak: a puddle on the floor, or a spot of any surface that only thermal cameras see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leak {
    /// Its middle, site frame, metres.
    pub place: Vec3,
    /// Nothing is changed farther away than this, metres.
    pub radius_m: f64,
    /// What lies on the floor. Without a liquid, as where steam escapes, nothing is seen in visible light, and the spot may be on any surface.
    pub liquid: Option<Liquid>,
    /// By how much its middle is warmer than usual, kelvin; negative is colder.
    pub warmer_k: f64,
}

/// What lies on the floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Liquid {
    /// A glossy patch that is darker than the floor.
    Water,
    /// A very dark, glossy patch.
    Oil,
}

/// Greatest distance from a point that names a door to its hinge, metres.
pub(crate) const HINGE_WITHIN_M: f64 = 0.5;
