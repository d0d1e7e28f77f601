//! Sites as triangles, to be read by other programs and read again.

use super::model::{BuildingModel, Mobility, ModelPart, ModelTriangle};
use super::{SimulatedSite, plan::SitePlan};
use crate::shape::{Shape, Solid};
use geometry::{Isometry, Vector3, vec_to_plain};
use nalgebra::{Point3, Translation3};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Parameters of [`SimulatedSite::to_model`].
#[derive(Clone, Copy, Debug)]
pub struct TessellationConfig {
    /// Greatest distance between the triangles of a curved surface and the surface, to either side, metres. The number of triangles grows with
    /// the inverse of its square root for cylinders, and with its inverse for spheres. Chosen: a fifth of the noise of the LiDAR.
    pub max_deviation_m: f64,
    /// Least number of sides of a cylinder. Chosen: a thin rod stays round enough.
    pub min_sides: usize,
}

impl Default for TessellationConfig {
    fn default() -> Self {
        Self { max_deviation_m: 0.002, min_sides: 6 }
    }
}

impl SimulatedSite {
    /// The site as triangles. Flat surfaces are exact, curved ones within [`TessellationConfig::max_deviation_m`].
    pub fn to_model(&self, config: &TessellationConfig) -> BuildingModel {
        let plan = &self.plan;
        let part = |name: String, mobility, solids: &mut dyn Iterator<Item = &Solid>| {
            let triangles = solids.flat_map(|solid| triangles(solid, config)).collect();
            ModelPart { name, mobility, triangles }
        };
        let fixed = fixed_solids(plan);
        let mut parts = vec![part("building".to_owned(), Mobility::Fixed, &mut fixed.into_iter())];
        for (index, piece) in plan.furniture.iter().enumerate() {
            let mut solids = plan.solids[piece.clone()].iter();
            parts.push(part(format!("furniture {}", index + 1), Mobility::Furniture, &mut solids));
        }
        for (index, leaf) in plan.door_leaves.iter().enumerate() {
            let hinge = vec_to_plain(&leaf.hinge);
            let mut solids = plan.solids[leaf.solids.clone()].iter();
            parts.push(part(format!("door {}", index + 1), Mobility::Door { hinge }, &mut solids));
        }
        let path = |corners: &Vec<Vector3>| corners.iter().map(vec_to_plain).collect();
        BuildingModel {
            name: self.name.clone(),
            parts,
            docks: plan.docks.clone(),
            start: plan.start,
            outline: plan.outline.clone(),
            routes: plan.routes.clone(),
            pedestrian_paths: plan.pedestrian_paths.iter().map(path).collect(),
        }
    }
}

/// The solids that belong neither to furniture nor to a door.
fn fixed_solids(plan: &SitePlan) -> Vec<&Solid> {
    let mut is_fixed = vec![true; plan.solids.len()];
    let doors = plan.door_leaves.iter().map(|leaf| &leaf.solids);
    for range in plan.furniture.iter().chain(doors) {
        is_fixed[Range::clone(range)].fill(false);
    }
    plan.solids.iter().zip(is_fixed).filter(|(_, fixed)| *fixed).map(|(solid, _)| solid).collect()
}

/// The surface of a solid, corners counter-clockwise seen from outside.
fn triangles(solid: &Solid, config: &TessellationConfig) -> Vec<ModelTriangle> {
    let corners = match &solid.shape {
        Shape::AlignedBox { min, max } => {
            let center = Isometry::from_parts(Translation3::from((min + max) / 2.0), Default::default());
            box_triangles(&((max - min) / 2.0), &center)
        }
        Shape::OrientedBox { center, half, site_from_box } => {
            box_triangles(half, &Isometry::from_parts(Translation3::from(*center), *site_from_box))
        }
        Shape::Cylinder { from, to, radius } => cylinder_triangles(from, to, *radius, config),
        Shape::Sphere { center, radius } => sphere_triangles(center, *radius, config),
        Shape::Triangle(corners) => vec![*corners],
    };
    let triangle = |corners: [Vector3; 3]| ModelTriangle {
        corners: corners.map(|corner| [corner.x, corner.y, corner.z]),
        material: solid.material,
    };
    corners.into_iter().map(triangle).collect()
}

fn quad([a, b, c, d]: [Vector3; 4]) -> [[Vector3; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

fn box_triangles(half: &Vector3, site_from_box: &Isometry) -> Vec<[Vector3; 3]> {
    let mut triangles = Vec::with_capacity(12);
    for axis in 0..3 {
        let (left, up) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [-1.0, 1.0] {
            let corner = |l: f64, u: f64| {
                let mut local = Vector3::zeros();
                local[axis] = side * half[axis];
                // The order turns with the side, so that the corners are counter-clockwise from outside.
                local[left] = side * l * half[left];
                local[up] = u * half[up];
                (site_from_box * Point3::from(local)).coords
            };
            triangles.extend(quad([
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ]));
        }
    }
    triangles
}

/// The half angle at the middle of a circle that a chord may have, and the factor by which its ends lie outside the circle, so that it deviates
/// from the circle by the same distance outwards at its ends and inwards at its middle.
fn chord(radius: f64, config: &TessellationConfig) -> (f64, f64) {
    let share = (config.max_deviation_m / radius).min(0.25);
    // With the ends at r (1 + s), the middle is at r (1 + s) cos(a) = r (1 - s).
    (((1.0 - share) / (1.0 + share)).acos(), 1.0 + share)
}

fn cylinder_triangles(
    from: &Vector3,
    to: &Vector3,
    radius: f64,
    config: &TessellationConfig,
) -> Vec<[Vector3; 3]> {
    let (half_angle, _) = chord(radius, config);
    let sides = ((PI / half_angle).ceil() as usize).max(config.min_sides);
    let reach = 2.0 * radius / (1.0 + (PI / sides as f64).cos());
    let axis = (to - from).normalize();
    let least = axis.iamin();
    let across = axis.cross(&Vector3::ith(least, 1.0)).normalize();
    let third = axis.cross(&across);
    let rim = |side: usize| {
        let (sin, cos) = (TAU * (side % sides) as f64 / sides as f64).sin_cos();
        (across * cos + third * sin) * reach
    };
    let mut triangles = Vec::with_capacity(4 * sides);
    for side in 0..sides {
        let (here, next) = (rim(side), rim(side + 1));
        triangles.extend(quad([from + here, from + next, to + next, to + here]));
        triangles.push([*to, to + here, to + next]);
        triangles.push([*from, from + next, from + here]);
    }
    triangles
}

fn sphere_triangles(center: &Vector3, radius: f64, config: &TessellationConfig) -> Vec<[Vector3; 3]> {
    let (half_angle, factor) = chord(radius, config);
    // A triangle is half of a quad. The middle of the quad's diagonal is the farthest from its corners.
    let half_side = half_angle / std::f64::consts::SQRT_2;
    let bands = ((PI / 2.0 / half_side).ceil() as usize).max(3);
    let sides = ((PI / half_side).ceil() as usize).max(config.min_sides);
    let at = |band: usize, side: usize| {
        let (sin, cos) = (PI * band as f64 / bands as f64).sin_cos();
        let (y, x) = (TAU * (side % sides) as f64 / sides as f64).sin_cos();
        center + Vector3::new(sin * x, sin * y, -cos) * (radius * factor)
    };
    let mut triangles = Vec::new();
    for band in 0..bands {
        for side in 0..sides {
            let [first, second] =
                quad([at(band, side), at(band, side + 1), at(band + 1, side + 1), at(band + 1, side)]);
            // At the poles, one of both has no area.
            if band + 1 < bands {
                triangles.push(second);
            }
            if band > 0 {
                triangles.push(first);
            }
        }
    }
    triangles
}
