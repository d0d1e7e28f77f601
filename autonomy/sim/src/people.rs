//! People who walk about the site on set rounds, with swinging arms and legs, and wait when the robot is in their way.

use crate::packed::{Packed, Packet};
use crate::shape::{Material, Shape, Solid};
use crate::site::Site;
use geometry::{Rng, RngTree, Vector3};

/// Set in [`Packet::solid`] for parts of people; the rest is person times [`PARTS`] plus part.
pub(crate) const PERSON_BIT: u32 = 1 << 30;
const PARTS: u32 = 16;
/// A person stops when the robot is closer than this ahead, metres.
const PERSONAL_SPACE: f64 = 1.1;
/// Seconds of waiting after which a person turns back.
const PATIENCE: f64 = 4.0;

/// Everybody on the site.
#[derive(Clone, Debug, Default)]
pub(crate) struct People(Vec<Person>);

#[derive(Clone, Debug)]
struct Person {
    rng: Rng,
    round: Vec<Vector3>,
    /// Walking to `round[next]`.
    next: usize,
    forwards: bool,
    place: Vector3,
    /// Unit vector, horizontal.
    heading: Vector3,
    speed: f64,
    /// Seconds left of standing about.
    pause: f64,
    waited: f64,
    /// Radians of the stride.
    phase: f64,
    clothes: Material,
    parts: Vec<(Packed, Material)>,
    /// Corners of the box round the parts.
    bounds: ([f32; 3], [f32; 3]),
}

impl People {
    /// So many people, spread over the rounds of the site.
    pub(crate) fn new(site: &Site, count: u32, rng: RngTree) -> Self {
        let rounds = site.rounds();
        let person = |number: u32| {
            let round = rounds.get(number as usize % rounds.len().max(1))?;
            Some(Person::new(round.clone(), rng.child(&format!("person {number}")).rng()))
        };
        Self((0..count).map_while(person).collect())
    }

    /// Where everybody stands, site frame, at the feet.
    pub(crate) fn places(&self) -> Vec<Vector3> {
        self.0.iter().map(|person| person.place).collect()
    }

    /// Lets everybody walk for `seconds`; `robot` is the middle of the robot.
    pub(crate) fn advance(&mut self, seconds: f64, robot: &Vector3) {
        for person in &mut self.0 {
            person.advance(seconds, robot);
            person.pose();
        }
    }

    /// Lets the rays of a packet meet people.
    pub(crate) fn cast(&self, packet: &mut Packet) {
        for (number, person) in self.0.iter().enumerate() {
            if !packet.enters(&person.bounds.0, &person.bounds.1) {
                continue;
            }
            for (part, (packed, _)) in person.parts.iter().enumerate() {
                packed.meet(packet, PERSON_BIT | (number as u32 * PARTS + part as u32));
            }
        }
    }

    /// Normal and material of a part met at `point`.
    pub(crate) fn surface(&self, solid: u32, point: [f32; 3]) -> ([f32; 3], Material) {
        let number = solid & !PERSON_BIT;
        let (packed, material) = &self.0[(number / PARTS) as usize].parts[(number % PARTS) as usize];
        (packed.normal(point), *material)
    }
}

impl Person {
    fn new(round: Vec<Vector3>, mut rng: Rng) -> Self {
        let next = (rng.uniform() * round.len() as f64) as usize % round.len();
        let clothes =
            [Material::Cloth, Material::BluePaint, Material::YellowPaint][(rng.bits() % 3) as usize];
        let mut person = Self {
            place: round[next],
            next,
            forwards: rng.uniform() < 0.5,
            heading: Vector3::x(),
            speed: rng.range(0.9, 1.4),
            pause: rng.range(0.0, 3.0),
            waited: 0.0,
            phase: rng.range(0.0, 6.0),
            clothes,
            parts: Vec::new(),
            bounds: ([0.0; 3], [0.0; 3]),
            round,
            rng,
        };
        person.pose();
        person
    }

    fn advance(&mut self, seconds: f64, robot: &Vector3) {
        if self.pause > 0.0 {
            self.pause -= seconds;
            return;
        }
        let to_next = self.round[self.next] - self.place;
        let step = self.speed * seconds;
        if to_next.norm() <= step {
            self.place = self.round[self.next];
            self.turn_to_following();
            if self.rng.uniform() < 0.35 {
                self.pause = self.rng.range(1.0, 6.0);
            }
            return;
        }
        let direction = to_next.normalize();
        self.heading =
            Vector3::new(direction.x, direction.y, 0.0).try_normalize(1e-6).unwrap_or(self.heading);
        let to_robot = robot - self.place;
        let level = to_robot.xy().norm();
        if level < PERSONAL_SPACE && to_robot.z.abs() < 1.5 && to_robot.dot(&self.heading) > 0.0 {
            self.waited += seconds;
            if self.waited > PATIENCE {
                self.waited = 0.0;
                self.forwards = !self.forwards;
                self.turn_to_following();
            }
            return;
        }
        self.waited = 0.0;
        self.place += direction * step;
        self.phase += step * 4.4;
    }

    fn turn_to_following(&mut self) {
        let count = self.round.len();
        self.next = (self.next + if self.forwards { 1 } else { count - 1 }) % count;
    }

    /// Puts torso, head, arms and legs where the stride has them.
    fn pose(&mut self) {
        let left = Vector3::new(-self.heading.y, self.heading.x, 0.0);
        let place = self.place;
        let at = |forward: f64, sideways: f64, up: f64| {
            place + self.heading * forward + left * sideways + Vector3::z() * up
        };
        let swing = if self.pause > 0.0 || self.waited > 0.0 { 0.0 } else { 0.38 * self.phase.sin() };
        let limb = |from, to, radius| Shape::Rod { from, to, radius };
        let mut shapes: Vec<(Shape, Material)> = vec![
            (limb(at(0.0, 0.0, 0.88), at(0.03, 0.0, 1.45), 0.17), self.clothes),
            (Shape::Ball { center: at(0.0, 0.0, 0.90), radius: 0.17 }, Material::DarkPaint),
            (Shape::Ball { center: at(0.03, 0.0, 1.43), radius: 0.17 }, self.clothes),
            (Shape::Ball { center: at(0.05, 0.0, 1.67), radius: 0.11 }, Material::Skin),
        ];
        for (side, swing) in [(0.1, swing), (-0.1, -swing)] {
            let (hip, foot) = (at(0.0, side, 0.88), at(0.8 * swing, side, 0.06));
            let knee = (hip + foot) / 2.0 + self.heading * 0.05;
            shapes.push((limb(hip, knee, 0.085), Material::DarkPaint));
            shapes.push((limb(knee, foot, 0.06), Material::DarkPaint));
            shapes
                .push((Shape::Ball { center: foot + self.heading * 0.06, radius: 0.075 }, Material::Rubber));
            let shoulder = at(0.03, side * 2.1, 1.42);
            shapes.push((limb(shoulder, at(-0.7 * swing, side * 2.4, 0.85), 0.05), self.clothes));
        }
        self.bounds = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for (shape, _) in &shapes {
            let (min, max) = shape.bounds();
            for axis in 0..3 {
                self.bounds.0[axis] = self.bounds.0[axis].min(min[axis] as f32);
                self.bounds.1[axis] = self.bounds.1[axis].max(max[axis] as f32);
            }
        }
        let pack = |(shape, material)| (Packed::from(&Solid { shape, material }), material);
        self.parts = shapes.into_iter().map(pack).collect();
    }
}
