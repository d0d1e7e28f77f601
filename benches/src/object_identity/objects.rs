//! Objects of simulated sites, and boxes of random sizes.

use geometry::{Isometry, RngTree, Rotation, Vector3};
use sim::{Material, Shape, SimulatedSite, SiteName, Solid};
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

/// Lengths and heights of random boxes, metres: those of `sim::LooseObjectsConfig`.
const LENGTH_M: [f64; 2] = [0.3, 1.2];
const HEIGHT_M: [f64; 2] = [0.3, 1.4];
/// Objects with a longer or a shorter longest side than these are left out, metres: nobody moves them, or no LiDAR has 30 points of them.
const SIDES_M: [f64; 2] = [0.2, 3.0];

/// An object that stands on the origin.
#[derive(Clone, Debug)]
pub struct ShapedObject {
    pub solids: Vec<Solid>,
    /// Lengths of the sides of the box along the axes round it, metres.
    pub size_m: [f64; 3],
}

impl ShapedObject {
    /// Solids, moved so that they stand on the origin.
    fn new(solids: &[Solid]) -> Self {
        let bounds = solids.iter().map(|solid| solid.shape.bounds());
        let all = bounds.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)));
        let (low, high) = all.unwrap_or((Vector3::zeros(), Vector3::zeros()));
        let foot = Vector3::new((low.x + high.x) / 2.0, (low.y + high.y) / 2.0, low.z);
        let by = Isometry::from_parts((-foot).into(), Rotation::identity());
        let moved = |solid: &Solid| Solid { shape: solid.shape.transformed(&by), ..*solid };
        Self { solids: solids.iter().map(moved).collect(), size_m: (high - low).into() }
    }

    /// The object, tipped onto one of its sides.
    pub fn tipped(&self, side: usize) -> Self {
        let angles =
            [[FRAC_PI_2, 0.0], [-FRAC_PI_2, 0.0], [0.0, FRAC_PI_2], [2.0 * FRAC_PI_2, 0.0]][side % 4];
        let turn = Rotation::from_euler_angles(angles[0], angles[1], 0.0);
        let by = Isometry::from_parts(Vector3::zeros().into(), turn);
        let turned = |solid: &Solid| Solid { shape: solid.shape.transformed(&by), ..*solid };
        Self::new(&self.solids.iter().map(turned).collect::<Vec<_>>())
    }

    /// What tells makes apart: kinds of solids and their sizes in steps of 2 cm, in any order. Heading does not matter.
    fn make(&self) -> Vec<(u8, [i64; 3])> {
        let steps = |length_m: f64| (length_m / 0.02).round() as i64;
        let of_sides = |sides: Vector3| {
            let mut sides = [sides.x, sides.y, sides.z].map(steps);
            sides.sort_unstable();
            sides
        };
        let of_solid = |solid: &Solid| match &solid.shape {
            Shape::AlignedBox { min, max } => (0, of_sides(max - min)),
            Shape::OrientedBox { half, .. } => (0, of_sides(half * 2.0)),
            Shape::Cylinder { from, to, radius } => (1, [steps((to - from).norm()), steps(*radius), 0]),
            Shape::Sphere { radius, .. } => (2, [steps(*radius), 0, 0]),
            Shape::Triangle([a, b, c]) => {
                (3, of_sides(Vector3::new((a - b).norm(), (b - c).norm(), (c - a).norm())))
            }
        };
        let mut make: Vec<_> = self.solids.iter().map(of_solid).collect();
        make.sort_unstable();
        make
    }
}

/// The furniture of sites, one of each make, in a fixed order.
pub fn furniture(sites: &[SiteName]) -> Vec<ShapedObject> {
    let (mut makes, mut objects) = (BTreeSet::new(), Vec::new());
    for name in sites {
        let site = SimulatedSite::new(*name);
        for object in site.furniture().map(ShapedObject::new) {
            let longest_m = object.size_m.into_iter().fold(0.0, f64::max);
            if (SIDES_M[0]..=SIDES_M[1]).contains(&longest_m) && makes.insert(object.make()) {
                objects.push(object);
            }
        }
    }
    objects
}

/// Boxes of random sizes.
pub fn boxes(seed: u64, count: usize) -> Vec<ShapedObject> {
    let mut rng = RngTree::new(seed).child("boxes").rng();
    let mut one = || {
        let length_m = rng.range(LENGTH_M[0], LENGTH_M[1]);
        let width_m = rng.range(LENGTH_M[0], length_m.max(LENGTH_M[0] + 1e-6));
        let half = Vector3::new(length_m, width_m, rng.range(HEIGHT_M[0], HEIGHT_M[1])) / 2.0;
        let shape = Shape::AlignedBox { min: -half, max: half };
        ShapedObject::new(&[Solid { shape, material: Material::Wood }])
    };
    (0..count).map(|_| one()).collect()
}
