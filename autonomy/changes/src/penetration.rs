//! Whether the rays of a visit went through an object that stands in another visit.

use crate::ray_image::RayImage;
use crate::side::is_stray;
use crate::{ChangesConfig, UprightBox};
use geometry::Vector3;
use std::iter::Sum;

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
        // A ray that ends just before the far side went through too: something may stand behind the object. One that ends just behind a thin part of the object tells nothing.
        if range_m > (leaves_m - margin_m).max(enters_m + 2.0 * margin_m) {
            counted.through += 1;
        } else if range_m <= leaves_m + margin_m / 2.0 {
            counted.ended += 1;
        }
    }
    counted
}

/// Whether an object was there during all of its own visit. A person who walks past was not: from most of the views that tell of that place, nearly all rays went through it, or only
/// one or two views saw it at all. Of a rack or a tripod, some rays of each view end at it.
/// What does not stand on the ground may be the upper part of a person. What one view alone saw was not there if the rays of the others together say so.
pub(crate) fn was_there(
    place: &UprightBox,
    stands: bool,
    own: &[Penetration],
    config: &ChangesConfig,
) -> bool {
    let (seeing, others): (Vec<&Penetration>, Vec<&Penetration>) =
        own.iter().partition(|view| view.ended >= config.min_free_rays);
    let is_seen = if may_walk(place, config) {
        seeing.len() >= config.min_views_if_walking.min(own.len())
    } else {
        seeing.len() >= config.min_views.min(own.len())
            || stands
                && is_clear_to_one(place, own.iter().map(|view| view.ended), config)
                && !is_empty_to(&others, config)
    };
    !is_empty_to_most(own, config) && is_seen
}

/// Whether [`ChangesConfig::min_rays_of_one_view`] rays of one view tell the same of a thing that is twice [`ChangesConfig::same_surface_m`] thick: an error of the view's pose does not explain that.
fn is_clear_to_one(
    place: &UprightBox,
    mut rays_of_views: impl Iterator<Item = usize>,
    config: &ChangesConfig,
) -> bool {
    let [length, width, _] = place.size_m;
    length.min(width) >= 2.0 * config.same_surface_m
        && rays_of_views.any(|rays| rays >= config.min_rays_of_one_view)
}

/// Whether the other visit looked through the place of an object from more than one view, or from one with many rays: the pose of a single view may be wrong, and with it all its rays.
pub(crate) fn was_looked_through(place: &UprightBox, other: &[Penetration], config: &ChangesConfig) -> bool {
    let looking = other.iter().filter(|view| view.through > 0).count();
    looking >= config.min_views.min(other.len())
        || is_clear_to_one(place, other.iter().map(|view| view.through), config)
}

fn may_walk(place: &UprightBox, config: &ChangesConfig) -> bool {
    place.size_m[2] >= config.walking_height_m
}

/// Whether from most of the views that tell of a place nearly all rays went through it: what ended the rays of the others passed.
fn is_empty_to_most(views: &[Penetration], config: &ChangesConfig) -> bool {
    let telling = views.iter().filter(|view| view.through + view.ended >= config.min_telling_rays);
    let (empty, telling) = telling.fold((0_usize, 0_usize), |(empty, telling), view| {
        (empty + usize::from(is_empty(view, config)), telling + 1)
    });
    empty as f64 > config.moving_share * telling as f64
}

/// Whether views that have few rays each say together that nothing was there.
fn is_empty_to(views: &[&Penetration], config: &ChangesConfig) -> bool {
    let all: Penetration = views.iter().copied().sum();
    all.through + all.ended >= config.min_telling_rays && is_empty(&all, config)
}

fn is_empty(view: &Penetration, config: &ChangesConfig) -> bool {
    is_stray(view.ended, view.through + view.ended, config)
}

/// The rays of the other visit that met the place of an object, without the views in which something passed there. Of an object that may have walked there itself all rays count: that its place was
/// not always empty says that people walk there.
pub(crate) fn without_passing(
    place: &UprightBox,
    views: &[Penetration],
    config: &ChangesConfig,
) -> Penetration {
    let is_passed = !may_walk(place, config) && is_empty_to_most(views, config);
    views.iter().filter(|view| !is_passed || is_empty(view, config)).sum()
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
        [length, width].map(|side| (side - 2.0 * config.edge_margin_m).max(config.min_core_side_m.min(side)));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_walks_past_was_not_there_and_what_some_rays_go_through_was() {
        let config = ChangesConfig::default();
        let view = |through: usize, ended: usize| Penetration { through, ended };
        let of_height = |height_m: f64, own: &[Penetration]| {
            let size_m = [0.5, 0.4, height_m];
            was_there(&UprightBox { centre_m: Vector3::zeros(), size_m, yaw_rad: 0.0 }, true, own, &config)
        };
        let tall = |own: &[Penetration]| of_height(1.6, own);
        assert!(tall(&[view(0, 40), view(2, 30), view(0, 20), view(0, 0)]), "a box");
        assert!(tall(&[view(30, 10), view(40, 9), view(25, 8)]), "a rack");
        assert!(!tall(&[view(0, 80), view(60, 0), view(50, 1), view(20, 0)]), "a person");
        assert!(!tall(&[view(0, 80), view(0, 0), view(0, 0)]), "seen from one view only");
        let of_two = [view(0, 40), view(2, 30), view(0, 0)];
        assert!(!tall(&of_two) && of_height(0.2, &of_two), "what is low does not walk");
        assert!(tall(&[view(0, 80)]), "a visit of one view");
        let of_one = [view(0, 150), view(0, 0), view(0, 0)];
        assert!(!tall(&of_one) && of_height(0.4, &of_one), "what is low is seen from one view");
        let few = [view(0, 279), view(5, 0), view(4, 0), view(2, 0)];
        assert!(!of_height(0.3, &few), "the rays of the others, few of each, went through");
        assert!(of_height(0.3, &few[..3]), "too few of them");
        let low = UprightBox { centre_m: Vector3::new(0.0, 0.0, 0.9), size_m: [0.5, 0.4, 0.4], yaw_rad: 0.0 };
        assert!(!was_there(&low, false, &of_one, &config), "it may be the upper part of a person");
    }

    #[test]
    fn one_view_of_many_does_not_tell_that_a_place_was_empty() {
        let config = ChangesConfig::default();
        let was_empty = |through: &[usize], size_m: [f64; 3]| {
            let views: Vec<_> =
                through.iter().map(|through| Penetration { through: *through, ended: 0 }).collect();
            let place = UprightBox { centre_m: Vector3::zeros(), size_m, yaw_rad: 0.0 };
            was_looked_through(&place, &views, &config)
        };
        let (sheet, thing) = ([0.6, 0.03, 0.6], [0.6, 0.4, 0.5]);
        assert!(was_empty(&[7, 0, 1], sheet));
        assert!(!was_empty(&[7, 0, 0], sheet));
        assert!(was_empty(&[7], sheet), "a visit of one view");
        assert!(was_empty(&[150, 0, 0], thing), "a thing as thick as this");
        assert!(!was_empty(&[150, 0, 0], sheet));
    }

    #[test]
    fn a_ray_beside_a_thin_object_tells_nothing_of_it() {
        let config = ChangesConfig::default();
        let post =
            UprightBox { centre_m: Vector3::new(5.0, 0.0, 0.5), size_m: [0.1, 0.1, 1.0], yaw_rad: 0.0 };
        let through = |y: f32| {
            let view =
                crate::SensorView { sensor: Vector3::new(0.0, 0.0, 0.5), points: vec![[10.0, y, 0.5]] };
            penetration(&post, &[RayImage::new(&view, &config)], &config)[0]
        };
        assert_eq!(through(0.0), Penetration { through: 1, ended: 0 });
        assert_eq!(through(0.08), Penetration::default(), "at its edge");
        assert_eq!(through(0.2), Penetration::default(), "beside it");
    }
}
