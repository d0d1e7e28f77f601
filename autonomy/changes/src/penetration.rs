//! Whether the rays of a visit went through an object that stands in another visit.

use crate::ray_image::RayImage;
use crate::{ChangesConfig, UprightBox};
use geometry::Vector3;
use std::iter::Sum;

/// Least side of what is tested, metres: a sheet. Chosen: less than the noise of a LiDAR.
const SHEET_M: f64 = 0.01;

/// Rays of a visit that met the place of an object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Penetration {
    /// Those that ended behind it.
    pub through: usize,
    /// Those that ended in it.
    pub ended: usize,
}

impl<'a> Sum<&'a Self> for Penetration {
    fn sum<I: Iterator<Item = &'a Self>>(iter: I) -> Self {
        iter.fold(Self::default(), |sum, of_view| Self {
            through: sum.through + of_view.through,
            ended: sum.ended + of_view.ended,
        })
    }
}

/// Counts the rays of each view that would have ended at an object if it had been there: those that meet its [`core`]. Linear in the rays towards it.
pub(crate) fn penetration(
    place: &UprightBox,
    images: &[RayImage],
    config: &ChangesConfig,
) -> Vec<Penetration> {
    let tested = core(place, config);
    images.iter().map(|image| penetration_of_view(&tested, image, config)).collect()
}

fn penetration_of_view(tested: &UprightBox, image: &RayImage, config: &ChangesConfig) -> Penetration {
    let mut counted = Penetration::default();
    let [length, width, height] = tested.size_m;
    let reach_m = length.hypot(width).hypot(height) / 2.0;
    // A ray across an edge may have ended at what is behind it, or have gone through where the thing is not.
    let min_chord_m = config.free_margin_m.min(width / 2.0);
    for (along, range_m) in image.rays_near(&tested.centre_m, reach_m) {
        let (along, range_m) = (Vector3::from(along.map(f64::from)), f64::from(*range_m));
        if range_m < config.min_range_m {
            continue;
        }
        let Some([enters_m, leaves_m]) = tested.crossed_by(image.sensor(), &along) else { continue };
        let margin_m = config.free_margin_m + config.free_margin_share * enters_m;
        if range_m < enters_m - margin_m || leaves_m - enters_m < min_chord_m {
            continue;
        }
        // A ray that ends just before the far side went through too: something may stand behind the object.
        if range_m > (leaves_m - margin_m).max(enters_m + 2.0 * margin_m) {
            counted.through += 1;
        } else {
            counted.ended += 1;
        }
    }
    counted
}

/// Whether an object was there for a part of its own visit only, such as a person who walked past: from most of the views that tell of its place, nearly all rays went through it. Of
/// a rack or a tripod, some rays of each view end at it.
pub(crate) fn was_passing(own: &[Penetration], config: &ChangesConfig) -> bool {
    let telling = own.iter().filter(|view| view.through + view.ended >= config.min_telling_rays);
    let (mut views, mut empty) = (0_usize, 0_usize);
    for Penetration { through, ended } in telling {
        views += 1;
        empty += usize::from(*ended as f64 <= config.stray_share * (through + ended) as f64);
    }
    empty as f64 > config.moving_share * views as f64
}

/// The part of a box that a ray meets even if the poses are a little wrong. A ray that passes beside an object tells nothing of it, so that a strip between two rays of a sparse
/// sensor stays unknown. The part next to the ground is left out, because rays end at the ground there (docs/maths/changes.md, equation 3).
fn core(place: &UprightBox, config: &ChangesConfig) -> UprightBox {
    let [length, width, height] = place.size_m;
    let top_m = place.centre_m.z + height / 2.0 - config.edge_margin_m.min(height / 4.0);
    let bottom_m = (place.bottom_m() + config.same_surface_m).min(place.centre_m.z);
    let centre_m = Vector3::new(place.centre_m.x, place.centre_m.y, (top_m + bottom_m) / 2.0);
    // Of an object that was seen from one side only, the box is as thin as the noise. It stays a sheet.
    let [length, width] =
        [length, width].map(|side| (side - 2.0 * config.edge_margin_m).max(SHEET_M.min(side)));
    UprightBox { centre_m, size_m: [length, width, top_m - bottom_m], yaw_rad: place.yaw_rad }
}

/// Logarithm of how much likelier it is that the object was not there in the other visit than that it was: its solidity is the share of the rays of its own visit that ended in
/// it. Of a rack or a tripod many rays of its own visit go through, so that a few rays of the other one prove nothing
/// (docs/maths/changes.md, equation 3).
pub(crate) fn evidence_of_absence(own: Penetration, other: Penetration, config: &ChangesConfig) -> f64 {
    let solidity = own.ended as f64 / (own.ended + own.through).max(1) as f64;
    let solidity = solidity.clamp(config.stray_share, 1.0 - config.stray_share);
    let of_rays = other.through as f64 * ((1.0 - config.stray_share) / (1.0 - solidity)).ln()
        + other.ended as f64 * (config.stray_share / solidity).ln();
    // Rays that go through gaps go through the same ones.
    solidity * solidity * of_rays
}

/// Whether the absence of an object explains the rays that ended in its place: their number is not improbable if rays end there by chance only.
pub(crate) fn explains_absence(other: Penetration, config: &ChangesConfig) -> bool {
    // Probability of fewer of them, of a Poisson distribution.
    let mean = config.chance_share * (other.through + other.ended) as f64;
    let mut term = (-mean).exp();
    let mut fewer = 0.0;
    for count in 0..other.ended {
        fewer += term;
        term *= mean / (count + 1) as f64;
    }
    1.0 - fewer >= config.min_chance
}
