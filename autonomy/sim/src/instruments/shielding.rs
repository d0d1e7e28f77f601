//! How much of the solids of a site a ray of gamma passes, and what they take of it.

use crate::bvh::Bvh;
use crate::shape::{Material, Shape, Solid};
use geometry::Vector3;

/// Energy for which the attenuation of materials is given, keV: the line of caesium.
const REFERENCE_KEV: f64 = 661.7;
/// Attenuation falls with this power of the energy, between 300 keV and 3 MeV (NIST XCOM: concrete and steel within 5 %).
const ENERGY_EXPONENT: f64 = 0.48;
/// Attenuation of air, per metre.
const AIR_PER_M: f64 = 0.0094;
/// Thickness of the sheet that a triangle stands for, metres: those of models are the surfaces of walls and machines.
const SHEET_M: f64 = 0.05;

/// Attenuation of a material at [`REFERENCE_KEV`], per metre: the mass attenuation of NIST XCOM (0.0075 to 0.0077 m²/kg) times its density. Machines and cabinets are
/// mostly air, so painted and galvanised metal counts with 1.6 g/cm³.
fn attenuation_per_m(material: Material) -> f64 {
    match material {
        Material::Concrete | Material::Floor | Material::Asphalt => 17.5,
        Material::Steel => 57.0,
        Material::Galvanised | Material::DarkPaint | Material::YellowPaint | Material::BluePaint => 12.0,
        Material::Glass | Material::Reflector => 19.0,
        Material::Plaster => 7.0,
        Material::Rubber | Material::Skin | Material::Cloth => 8.5,
        Material::Wood | Material::WhiteSheet => 5.0,
        Material::Cardboard => 1.5,
        Material::Foliage => 0.5,
    }
}

/// Exponent of the attenuation between two points, site frame, metres: the share `exp(-depth)` of the gamma passes. Where solids overlap, the densest counts.
/// Linear in the number of solids between the points.
pub(super) fn optical_depth(bvh: &Bvh, from: &Vector3, to: &Vector3, kev: f64) -> f64 {
    let (segment, middle) = (to - from, 0.5 * (from + to));
    let length = segment.norm();
    let mut passages: Vec<(f64, f64, f64)> = Vec::new();
    let mut sheets = 0.0;
    bvh.near(&middle, 0.5 * length, |solid| match passage(solid, from, &segment) {
        Some((enters, leaves)) => passages.push((enters, leaves, attenuation_per_m(solid.material))),
        None => {
            if let Shape::Triangle(corners) = &solid.shape
                && crosses(corners, from, &segment)
            {
                sheets += SHEET_M * attenuation_per_m(solid.material);
            }
        }
    });
    let solids = sheets + length * densest(&passages);
    (solids + AIR_PER_M * length) * (REFERENCE_KEV / kev).powf(ENERGY_EXPONENT)
}

/// Sum over the stretches of a segment of their share times the greatest attenuation there.
fn densest(passages: &[(f64, f64, f64)]) -> f64 {
    let mut borders: Vec<f64> = passages.iter().flat_map(|(enters, leaves, _)| [*enters, *leaves]).collect();
    borders.sort_by(f64::total_cmp);
    let stretch = |ends: &[f64]| {
        let at = 0.5 * (ends[0] + ends[1]);
        let inside = passages.iter().filter(|(enters, leaves, _)| (*enters..*leaves).contains(&at));
        (ends[1] - ends[0]) * inside.map(|(.., attenuation)| *attenuation).fold(0.0, f64::max)
    };
    borders.windows(2).map(stretch).sum()
}

/// Where a segment enters and leaves a solid, as shares of the segment; none if it does not, or if the solid is a sheet.
fn passage(solid: &Solid, from: &Vector3, segment: &Vector3) -> Option<(f64, f64)> {
    let (enters, leaves) = match &solid.shape {
        Shape::AlignedBox { min, max } => slabs(&(from - min), segment, &(max - min))?,
        Shape::OrientedBox { center, half, site_from_box } => {
            let turn = site_from_box.inverse();
            slabs(&(turn * (from - center) + half), &(turn * segment), &(half * 2.0))?
        }
        Shape::Sphere { center, radius } => ball(&(from - center), segment, *radius)?,
        Shape::Cylinder { from: end, to, radius } => {
            let axis = (to - end).try_normalize(1e-12)?;
            let offset = from - end;
            let (along, speed) = (offset.dot(&axis), segment.dot(&axis));
            let (enters, leaves) = ball(&(offset - axis * along), &(segment - axis * speed), *radius)?;
            let (bottom, top) = slab(along, speed, (to - end).norm())?;
            (enters.max(bottom), leaves.min(top))
        }
        Shape::Triangle(_) => return None,
    };
    let (enters, leaves) = (enters.max(0.0), leaves.min(1.0));
    (enters < leaves).then_some((enters, leaves))
}

/// Where a segment is in a box from 0 to `size`.
fn slabs(from: &Vector3, segment: &Vector3, size: &Vector3) -> Option<(f64, f64)> {
    let mut inside = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let (enters, leaves) = slab(from[axis], segment[axis], size[axis])?;
        inside = (inside.0.max(enters), inside.1.min(leaves));
    }
    Some(inside)
}

/// Where a coordinate is between 0 and `size`.
fn slab(from: f64, speed: f64, size: f64) -> Option<(f64, f64)> {
    if speed.abs() < 1e-12 {
        return (0.0..size).contains(&from).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let (one, other) = (-from / speed, (size - from) / speed);
    Some((one.min(other), one.max(other)))
}

/// Where a segment is within `radius` of the origin.
fn ball(from: &Vector3, segment: &Vector3, radius: f64) -> Option<(f64, f64)> {
    let (a, b, c) = (segment.norm_squared(), from.dot(segment), from.norm_squared() - radius * radius);
    if a < 1e-18 {
        return (c < 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let root = (b * b - a * c).sqrt();
    root.is_finite().then(|| ((-b - root) / a, (-b + root) / a))
}

/// Whether a segment crosses a triangle (Möller and Trumbore, 1997).
fn crosses([a, b, c]: &[Vector3; 3], from: &Vector3, segment: &Vector3) -> bool {
    let (ab, ac) = (b - a, c - a);
    let across = segment.cross(&ac);
    let volume = ab.dot(&across);
    if volume.abs() < 1e-12 {
        return false;
    }
    let offset = from - a;
    let u = offset.dot(&across) / volume;
    let around = offset.cross(&ab);
    let (v, at) = (segment.dot(&around) / volume, ac.dot(&around) / volume);
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=1.0).contains(&at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Rotation;

    fn depth(shape: Shape, material: Material, to: Vector3) -> f64 {
        let bvh = Bvh::new(&[Solid { shape, material }]);
        optical_depth(&bvh, &Vector3::zeros(), &to, REFERENCE_KEV) - AIR_PER_M * to.norm()
    }

    #[test]
    fn the_passage_through_every_shape_counts() {
        let to = Vector3::new(4.0, 0.0, 0.0);
        let wall = Shape::AlignedBox { min: Vector3::new(1.0, -1.0, -1.0), max: Vector3::new(1.2, 1.0, 1.0) };
        let turned = Shape::OrientedBox {
            center: Vector3::new(2.0, 0.0, 0.0),
            half: Vector3::new(0.1, 1.0, 1.0),
            site_from_box: Rotation::from_euler_angles(0.0, 0.0, std::f64::consts::FRAC_PI_4),
        };
        let ball = Shape::Sphere { center: Vector3::new(2.0, 0.0, 0.0), radius: 0.25 };
        let (low, high) = (Vector3::new(2.0, 0.0, -1.0), Vector3::new(2.0, 0.0, 1.0));
        let pillar = Shape::Cylinder { from: low, to: high, radius: 0.15 };
        for (shape, thickness_m) in
            [(wall, 0.2), (turned, 0.2 * std::f64::consts::SQRT_2), (ball, 0.5), (pillar, 0.3)]
        {
            let found = depth(shape, Material::Concrete, to);
            assert!((found - 17.5 * thickness_m).abs() < 1e-9, "{found} for {shape:?}");
            // Beside it, before it and above it there is nothing.
            for other in
                [Vector3::new(0.4, 0.0, 0.0), Vector3::new(0.0, 4.0, 0.0), Vector3::new(1.0, 0.0, 6.0)]
            {
                assert_eq!(depth(shape, Material::Concrete, other), 0.0, "{shape:?} to {other}");
            }
        }
        let sheet = Shape::Triangle([
            Vector3::new(2.0, -1.0, -1.0),
            Vector3::new(2.0, 1.0, -1.0),
            Vector3::new(2.0, 0.0, 1.0),
        ]);
        assert!((depth(sheet, Material::Steel, to) - 57.0 * SHEET_M).abs() < 1e-9);
        assert_eq!(depth(sheet, Material::Steel, Vector3::new(4.0, 0.0, 5.0)), 0.0);
    }

    #[test]
    fn solids_that_overlap_count_once_and_harder_gamma_passes_more() {
        let slab = |from_m: f64, to_m: f64, material| Solid {
            shape: Shape::AlignedBox {
                min: Vector3::new(from_m, -1.0, -1.0),
                max: Vector3::new(to_m, 1.0, 1.0),
            },
            material,
        };
        let bvh = Bvh::new(&[slab(1.0, 2.0, Material::Wood), slab(1.5, 1.6, Material::Steel)]);
        let to = Vector3::new(3.0, 0.0, 0.0);
        let soft = optical_depth(&bvh, &Vector3::zeros(), &to, REFERENCE_KEV);
        let expected = 0.9 * 5.0 + 0.1 * 57.0 + 3.0 * AIR_PER_M;
        assert!((soft - expected).abs() < 1e-9, "{soft} {expected}");
        let hard = optical_depth(&bvh, &Vector3::zeros(), &to, 1332.5);
        // XCOM: 0.0529 against 0.0735 cm²/g in iron.
        assert!((hard / soft - 0.72).abs() < 0.02, "{}", hard / soft);
    }
}
