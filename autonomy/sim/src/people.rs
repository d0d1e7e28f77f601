//! People who walk on set closed paths, with swinging arms and legs. They wait when the robot is in their way.

use crate::ray_packet::{PackedShape, RayPacket};
use crate::shape::{Material, Shape, Solid};
use crate::site::SimulatedSite;
use geometry::{Rng, RngTree, Vector3};

/// Set in [`RayPacket::solid`] for the parts of people; the other bits are person × [`PARTS`] + part.
pub(crate) const PERSON_BIT: u32 = 1 << 30;
/// Greatest number of parts of a person.
const PARTS: u32 = 16;
/// A person stops when the robot is ahead and nearer than this, metres.
const STOP_DISTANCE_M: f64 = 1.1;
/// No part of a person is farther from the line through their feet than this, metres.
const REACH_M: f64 = 0.8;
/// A person who has waited for this time turns back, seconds.
const WAIT_LIMIT_S: f64 = 4.0;

/// The people on the site.
#[derive(Clone, Debug, Default)]
pub(crate) struct People(Vec<Person>);

#[derive(Clone, Debug)]
struct Person {
    rng: Rng,
    /// Corners of the closed path, at the feet, site frame, metres.
    path: Vec<Vector3>,
    /// Index of the corner that the person walks to.
    next: usize,
    forwards: bool,
    /// Position of the feet, site frame, metres.
    position: Vector3,
    /// Walking direction, a horizontal unit vector.
    heading: Vector3,
    /// Walking speed, m/s.
    speed: f64,
    /// Time for which the person still stands at a corner, seconds.
    pause_left_s: f64,
    /// Time for which the person has waited for the robot, seconds.
    waited_s: f64,
    /// Phase of the stride, radians.
    phase: f64,
    clothes: Material,
    parts: Vec<(PackedShape, Material)>,
    /// The shapes of the parts.
    shapes: Vec<Shape>,
    /// Least corner of the box round the parts.
    bounds_min: [f32; 3],
    /// Greatest corner of that box.
    bounds_max: [f32; 3],
}

impl People {
    /// `count` people, distributed over the pedestrian paths of the site.
    pub(crate) fn new(site: &SimulatedSite, count: u32, rng: RngTree) -> Self {
        let paths = site.pedestrian_paths();
        let person = |number: u32| {
            let path = paths.get(number as usize % paths.len().max(1))?;
            Some(Person::new(path.clone(), rng.child(&format!("person {number}")).rng()))
        };
        Self((0..count).map_while(person).collect())
    }

    /// Positions of all people, at the feet, site frame, metres.
    pub(crate) fn positions(&self) -> Vec<Vector3> {
        self.0.iter().map(|person| person.position).collect()
    }

    /// The people whom any of these spheres (centre and radius, site frame, metres) touches: number and position of the feet.
    pub(crate) fn touched_by<'a>(
        &'a self,
        spheres: &'a [(Vector3, f64)],
    ) -> impl Iterator<Item = (u32, Vector3)> + 'a {
        let is_touched = |person: &Person| {
            spheres.iter().any(|(centre, radius)| {
                let is_near = (centre - person.position).xy().norm() <= radius + REACH_M;
                is_near && person.shapes.iter().any(|shape| shape.clearance(centre).distance <= *radius)
            })
        };
        let people = (0..).zip(&self.0);
        people.filter(move |(_, person)| is_touched(person)).map(|(number, person)| (number, person.position))
    }

    /// Lets all people walk for `seconds`; `robot` is the position of the base, site frame, metres.
    pub(crate) fn advance(&mut self, seconds: f64, robot: &Vector3) {
        for person in &mut self.0 {
            person.advance(seconds, robot);
            person.update_parts();
        }
    }

    /// Shortens every ray of the packet to the nearest person, if that is nearer than the present hit.
    pub(crate) fn cast(&self, packet: &mut RayPacket) {
        for (number, person) in self.0.iter().enumerate() {
            if !packet.intersects_box(&person.bounds_min, &person.bounds_max) {
                continue;
            }
            for (part, (packed, _)) in person.parts.iter().enumerate() {
                packed.intersect(packet, PERSON_BIT | (number as u32 * PARTS + part as u32));
            }
        }
    }

    /// Normal and material of the part that was hit at `point`.
    pub(crate) fn surface(&self, solid: u32, point: [f32; 3]) -> ([f32; 3], Material) {
        let number = solid & !PERSON_BIT;
        let (packed, material) = &self.0[(number / PARTS) as usize].parts[(number % PARTS) as usize];
        (packed.normal(point), *material)
    }
}

impl Person {
    fn new(path: Vec<Vector3>, mut rng: Rng) -> Self {
        let next = (rng.uniform() * path.len() as f64) as usize % path.len();
        let clothes =
            [Material::Cloth, Material::BluePaint, Material::YellowPaint][(rng.bits() % 3) as usize];
        let mut person = Self {
            position: path[next],
            next,
            forwards: rng.uniform() < 0.5,
            heading: Vector3::x(),
            speed: rng.range(0.9, 1.4),
            pause_left_s: rng.range(0.0, 3.0),
            waited_s: 0.0,
            phase: rng.range(0.0, 6.0),
            clothes,
            parts: Vec::new(),
            shapes: Vec::new(),
            bounds_min: [0.0; 3],
            bounds_max: [0.0; 3],
            path,
            rng,
        };
        person.update_parts();
        person
    }

    fn advance(&mut self, seconds: f64, robot: &Vector3) {
        if self.pause_left_s > 0.0 {
            self.pause_left_s -= seconds;
            return;
        }
        let to_next = self.path[self.next] - self.position;
        let step = self.speed * seconds;
        if to_next.norm() <= step {
            self.position = self.path[self.next];
            self.choose_next_corner();
            if self.rng.uniform() < 0.35 {
                self.pause_left_s = self.rng.range(1.0, 6.0);
            }
            return;
        }
        let direction = to_next.normalize();
        self.heading =
            Vector3::new(direction.x, direction.y, 0.0).try_normalize(1e-6).unwrap_or(self.heading);
        let to_robot = robot - self.position;
        let level = to_robot.xy().norm();
        if level < STOP_DISTANCE_M && to_robot.z.abs() < 1.5 && to_robot.dot(&self.heading) > 0.0 {
            self.waited_s += seconds;
            if self.waited_s > WAIT_LIMIT_S {
                self.waited_s = 0.0;
                self.forwards = !self.forwards;
                self.choose_next_corner();
            }
            return;
        }
        self.waited_s = 0.0;
        self.position += direction * step;
        self.phase += step * 4.4;
    }

    fn choose_next_corner(&mut self) {
        let count = self.path.len();
        self.next = (self.next + if self.forwards { 1 } else { count - 1 }) % count;
    }

    /// Places torso, head, arms and legs according to the phase of the stride.
    fn update_parts(&mut self) {
        let left = Vector3::new(-self.heading.y, self.heading.x, 0.0);
        let position = self.position;
        let at = |forward: f64, sideways: f64, up: f64| {
            position + self.heading * forward + left * sideways + Vector3::z() * up
        };
        let swing =
            if self.pause_left_s > 0.0 || self.waited_s > 0.0 { 0.0 } else { 0.38 * self.phase.sin() };
        let limb = |from, to, radius| Shape::Cylinder { from, to, radius };
        let mut shapes: Vec<(Shape, Material)> = vec![
            (limb(at(0.0, 0.0, 0.88), at(0.03, 0.0, 1.45), 0.17), self.clothes),
            (Shape::Sphere { center: at(0.0, 0.0, 0.90), radius: 0.17 }, Material::DarkPaint),
            (Shape::Sphere { center: at(0.03, 0.0, 1.43), radius: 0.17 }, self.clothes),
            (Shape::Sphere { center: at(0.05, 0.0, 1.67), radius: 0.11 }, Material::Skin),
        ];
        for (side, swing) in [(0.1, swing), (-0.1, -swing)] {
            let (hip, foot) = (at(0.0, side, 0.88), at(0.8 * swing, side, 0.06));
            let knee = (hip + foot) / 2.0 + self.heading * 0.05;
            shapes.push((limb(hip, knee, 0.085), Material::DarkPaint));
            shapes.push((limb(knee, foot, 0.06), Material::DarkPaint));
            shapes.push((
                Shape::Sphere { center: foot + self.heading * 0.06, radius: 0.075 },
                Material::Rubber,
            ));
            let shoulder = at(0.03, side * 2.1, 1.42);
            shapes.push((limb(shoulder, at(-0.7 * swing, side * 2.4, 0.85), 0.05), self.clothes));
        }
        (self.bounds_min, self.bounds_max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for (shape, _) in &shapes {
            let (min, max) = shape.bounds();
            for axis in 0..3 {
                self.bounds_min[axis] = self.bounds_min[axis].min(min[axis] as f32);
                self.bounds_max[axis] = self.bounds_max[axis].max(max[axis] as f32);
            }
        }
        self.shapes = shapes.iter().map(|(shape, _)| *shape).collect();
        let pack = |(shape, material)| (PackedShape::from(&Solid { shape, material }), material);
        self.parts = shapes.into_iter().map(pack).collect();
    }
}
