//! The solids that a site consists of, as exact shapes in f64: bounds and signed distances. Ray casting uses the f32 form of
//! `ray_packet`.

use geometry::{Isometry, Rotation, Vector3};
use nalgebra::Point3;
use std::fmt;
use std::str::FromStr;
use vocab::{MAX_SHOWN_NAME_CHARS, legible};

/// Material of a surface, as a LiDAR of 905 nm distinguishes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Material {
    Concrete,
    Floor,
    Plaster,
    WhiteSheet,
    Steel,
    Galvanised,
    DarkPaint,
    YellowPaint,
    BluePaint,
    Rubber,
    Wood,
    Cardboard,
    Glass,
    Cloth,
    Skin,
    Foliage,
    Asphalt,
    Reflector,
}

impl Material {
    /// All materials.
    pub const ALL: [Self; 18] = [
        Self::Concrete,
        Self::Floor,
        Self::Plaster,
        Self::WhiteSheet,
        Self::Steel,
        Self::Galvanised,
        Self::DarkPaint,
        Self::YellowPaint,
        Self::BluePaint,
        Self::Rubber,
        Self::Wood,
        Self::Cardboard,
        Self::Glass,
        Self::Cloth,
        Self::Skin,
        Self::Foliage,
        Self::Asphalt,
        Self::Reflector,
    ];

    /// Name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Concrete => "concrete",
            Self::Floor => "floor",
            Self::Plaster => "plaster",
            Self::WhiteSheet => "white-sheet",
            Self::Steel => "steel",
            Self::Galvanised => "galvanised",
            Self::DarkPaint => "dark-paint",
            Self::YellowPaint => "yellow-paint",
            Self::BluePaint => "blue-paint",
            Self::Rubber => "rubber",
            Self::Wood => "wood",
            Self::Cardboard => "cardboard",
            Self::Glass => "glass",
            Self::Cloth => "cloth",
            Self::Skin => "skin",
            Self::Foliage => "foliage",
            Self::Asphalt => "asphalt",
            Self::Reflector => "reflector",
        }
    }

    /// Diffuse reflectivity at 905 nm; above 1 for retroreflectors.
    pub const fn reflectivity(self) -> f32 {
        match self {
            Self::Concrete => 0.34,
            Self::Floor => 0.26,
            Self::Plaster => 0.62,
            Self::WhiteSheet => 0.78,
            Self::Steel => 0.45,
            Self::Galvanised => 0.55,
            Self::DarkPaint => 0.12,
            Self::YellowPaint => 0.68,
            Self::BluePaint => 0.30,
            Self::Rubber => 0.05,
            Self::Wood => 0.50,
            Self::Cardboard => 0.58,
            Self::Glass => 0.04,
            Self::Cloth => 0.22,
            Self::Skin => 0.40,
            Self::Foliage => 0.48,
            Self::Asphalt => 0.14,
            Self::Reflector => 2.2,
        }
    }
}

/// Error: there is no material of this name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownMaterial(String);

impl fmt::Display for UnknownMaterial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = Material::ALL.map(Material::name).join(", ");
        let name = legible(&self.0, MAX_SHOWN_NAME_CHARS);
        write!(f, "there is no material \"{name}\"; the materials are {names}")
    }
}

impl std::error::Error for UnknownMaterial {}

impl FromStr for Material {
    type Err = UnknownMaterial;
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let known = Self::ALL.into_iter().find(|material| material.name() == text);
        known.ok_or_else(|| UnknownMaterial(text.to_owned()))
    }
}

/// A closed shape in the site frame, metres. Triangles are the exception: they are sheets, visible from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A box along the axes of the site.
    AlignedBox {
        /// Least corner.
        min: Vector3,
        /// Greatest corner.
        max: Vector3,
    },
    /// A box in any orientation.
    OrientedBox {
        /// Middle.
        center: Vector3,
        /// Half the edge lengths, along the axes of the box.
        half: Vector3,
        /// Orientation of the box in the site.
        site_from_box: Rotation,
    },
    /// A cylinder with flat ends.
    Cylinder {
        /// Middle of one end.
        from: Vector3,
        /// Middle of the other end.
        to: Vector3,
        /// Radius.
        radius: f64,
    },
    /// A sphere.
    Sphere {
        /// Middle.
        center: Vector3,
        /// Radius.
        radius: f64,
    },
    /// A triangle.
    Triangle([Vector3; 3]),
}

/// A shape with its material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Shape and position.
    pub shape: Shape,
    /// Material of the surface.
    pub material: Material,
}

/// Signed distance to a surface with its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Metres; negative inside.
    pub distance: f64,
    /// Unit vector away from the nearest surface, site frame; zero where none is defined.
    pub outward: Vector3,
}

impl Shape {
    /// Least and greatest corner of the axis-aligned bounding box.
    pub fn bounds(&self) -> (Vector3, Vector3) {
        match self {
            Self::AlignedBox { min, max } => (*min, *max),
            Self::OrientedBox { center, half, site_from_box } => {
                let reach = site_from_box.to_rotation_matrix().into_inner().abs() * half;
                (center - reach, center + reach)
            }
            Self::Cylinder { from, to, radius } => {
                let axis = (to - from).normalize();
                let reach = axis.map(|a| radius * (1.0 - a * a).max(0.0).sqrt());
                (from.inf(to) - reach, from.sup(to) + reach)
            }
            Self::Sphere { center, radius } => {
                let reach = Vector3::repeat(*radius);
                (center - reach, center + reach)
            }
            Self::Triangle([a, b, c]) => (a.inf(b).inf(c), a.sup(b).sup(c)),
        }
    }

    /// The shape under a rigid transformation.
    pub fn transformed(&self, by: &Isometry) -> Self {
        let at = |point: &Vector3| (by * Point3::from(*point)).coords;
        match self {
            Self::AlignedBox { min, max } => {
                let (center, half) = (at(&((min + max) / 2.0)), (max - min) / 2.0);
                if by.rotation.angle() == 0.0 {
                    return Self::AlignedBox { min: center - half, max: center + half };
                }
                Self::OrientedBox { center, half, site_from_box: by.rotation }
            }
            Self::OrientedBox { center, half, site_from_box } => Self::OrientedBox {
                center: at(center),
                half: *half,
                site_from_box: by.rotation * site_from_box,
            },
            Self::Cylinder { from, to, radius } => {
                Self::Cylinder { from: at(from), to: at(to), radius: *radius }
            }
            Self::Sphere { center, radius } => Self::Sphere { center: at(center), radius: *radius },
            Self::Triangle(corners) => Self::Triangle(corners.each_ref().map(at)),
        }
    }

    /// Signed distance from the surface to `point`, with its gradient.
    pub fn clearance(&self, point: &Vector3) -> Clearance {
        match self {
            Self::AlignedBox { min, max } => {
                box_clearance(&(point - (min + max) / 2.0), &((max - min) / 2.0))
            }
            Self::OrientedBox { center, half, site_from_box } => {
                let local = box_clearance(&(site_from_box.inverse() * (point - center)), half);
                Clearance { outward: site_from_box * local.outward, ..local }
            }
            Self::Cylinder { from, to, radius } => cylinder_clearance(point, from, to, *radius),
            Self::Sphere { center, radius } => {
                let offset = point - center;
                let distance = offset.norm();
                Clearance { distance: distance - radius, outward: unit_or_zero(&offset) }
            }
            Self::Triangle(corners) => {
                let offset = point - nearest_on_triangle(point, corners);
                Clearance { distance: offset.norm(), outward: unit_or_zero(&offset) }
            }
        }
    }
}

fn unit_or_zero(v: &Vector3) -> Vector3 {
    v.try_normalize(1e-12).unwrap_or_else(Vector3::zeros)
}

/// `point` is in the frame of the box, whose origin is its middle.
fn box_clearance(point: &Vector3, half: &Vector3) -> Clearance {
    let excess = point.abs() - half;
    let outside = excess.sup(&Vector3::zeros());
    let distance = outside.norm();
    if distance > 0.0 {
        let outward = Vector3::from_fn(|i, _| outside[i].copysign(point[i])) / distance;
        return Clearance { distance, outward };
    }
    let axis = excess.imax();
    let mut outward = Vector3::zeros();
    outward[axis] = 1.0_f64.copysign(point[axis]);
    Clearance { distance: excess[axis], outward }
}

fn cylinder_clearance(point: &Vector3, from: &Vector3, to: &Vector3, radius: f64) -> Clearance {
    let axis = (to - from).normalize();
    let offset = point - (from + to) / 2.0;
    let along = offset.dot(&axis);
    let across = offset - axis * along;
    let profile = Vector3::new(across.norm(), along, 0.0);
    // A cylinder is a box in the half plane of (distance from axis, height).
    let local = box_clearance(&profile, &Vector3::new(radius, (to - from).norm() / 2.0, 1.0));
    let outward = unit_or_zero(&across) * local.outward.x + axis * local.outward.y;
    Clearance { distance: local.distance, outward }
}

/// Source: Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5 (barycentric regions).
fn nearest_on_triangle(point: &Vector3, [a, b, c]: &[Vector3; 3]) -> Vector3 {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return *a;
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return *b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return *c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let total = va + vb + vc;
    a + ab * (vb / total) + ac * (vc / total)
}
