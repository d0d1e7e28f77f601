//! The comparison of two depth images.

use super::colour::ColourHistogram;
use super::concavity::parted;
use super::config::DepthChangesConfig;
use super::differing::{Verdict, verdicts};
use super::image::{DepthImage, DepthImageError};
use super::segments::{area_m2, connected};
use super::support::Support;
use crate::detect::merged;
use crate::differences::UnmatchedObject;
use crate::moves::moves;
use crate::{Changes, UprightBox};
use geometry::{Isometry, Vector3};
use object_identity::AssociationConfig;

/// What changed between two images of a depth camera.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthChanges {
    /// The frame of the plane on which things stand, in the camera's frame: its third axis is up, its first axis is that of the camera as seen from above.
    pub camera_from_support: Isometry,
    /// The objects. Their boxes are in the frame of the plane, their points in the camera's frame.
    pub changes: Changes,
}

/// Compares two images of one camera that did not move. About linear in the pixels.
///
/// # Errors
/// When the images are of different cameras, or show no plane on which things stand.
pub fn detect_depth_changes(
    before: &DepthImage,
    after: &DepthImage,
    config: &DepthChangesConfig,
) -> Result<DepthChanges, DepthImageError> {
    let is_same_camera = before.size_px() == after.size_px()
        && before.camera().distance_px(after.camera(), before.size_px()) <= config.max_camera_difference_px;
    if !is_same_camera {
        return Err(DepthImageError::CamerasDiffer);
    }
    let support = Support::find([before, after], config)?;
    let removed = differing(before, after, &support, config);
    let appeared = differing(after, before, &support, config);
    let log_ratio = |gone: usize, new: usize| {
        let (gone, new) = (&removed[gone], &appeared[new]);
        let colours = gone.colour.as_ref().zip(new.colour.as_ref());
        let may_be_moved = looks_as_large(&gone.object.place, &new.object.place, config)
            && colours.is_none_or(|(a, b)| a.overlap(b) >= config.moved_colour_overlap);
        // Of two that may be one, nothing else is compared.
        if may_be_moved { f64::INFINITY } else { f64::NEG_INFINITY }
    };
    let places =
        |found: &[UnmatchedImageObject]| found.iter().map(|found| found.object.place).collect::<Vec<_>>();
    let pairs = moves(&places(&removed), &places(&appeared), log_ratio, &AssociationConfig::default());
    let objects =
        |found: Vec<UnmatchedImageObject>| found.into_iter().map(|found| found.object).collect::<Vec<_>>();
    Ok(DepthChanges {
        camera_from_support: support.camera_from_support(),
        changes: merged(objects(removed), objects(appeared), &pairs),
    })
}

/// Whether two boxes may be of one object that was moved, perhaps turned over: of an object one side is hidden, so that only the two longest sides have to agree, and the third one
/// is at least half as long.
fn looks_as_large(a: &UprightBox, b: &UprightBox, config: &DepthChangesConfig) -> bool {
    let sorted = |place: &UprightBox| {
        let mut sides = place.size_m;
        sides.sort_by(f64::total_cmp);
        sides
    };
    let ratios: Vec<f64> = sorted(a).iter().zip(sorted(b)).map(|(a, b)| a.min(b) / a.max(b)).collect();
    ratios[0] >= 0.5 && ratios[1..].iter().all(|ratio| *ratio >= 1.0 - config.moved_size_share)
}

/// An object of one image that the other one does not have.
struct UnmatchedImageObject {
    object: UnmatchedObject,
    colour: Option<ColourHistogram>,
}

/// The objects of an image that the other one does not have.
fn differing(
    image: &DepthImage,
    other: &DepthImage,
    support: &Support,
    config: &DepthChangesConfig,
) -> Vec<UnmatchedImageObject> {
    let verdicts = verdicts(image, other, support, config);
    let is_candidate = |pixel: &usize| matches!(verdicts[*pixel], Verdict::Changed | Verdict::Unknown);
    let candidates: Vec<usize> = (0..image.len()).filter(is_candidate).collect();
    let changed_area_m2 = |pixels: &[usize]| {
        area_m2(pixels.iter().copied().filter(|pixel| verdicts[*pixel] == Verdict::Changed), image)
    };
    let same: Vec<Vector3> = (0..image.len())
        .filter(|pixel| verdicts[*pixel] == Verdict::Same)
        .filter_map(|pixel| image.point(pixel))
        .collect();
    connected(&candidates, image, config.gap_px, config)
        .into_iter()
        .filter(|part| changed_area_m2(part) >= config.min_area_m2)
        .flat_map(|part| parted(&part, image, config))
        .filter(|part| changed_area_m2(part) >= config.min_area_m2)
        .filter_map(|part| found(&part, &verdicts, &same, image, support, config))
        .collect()
}

/// The object of a part of an image; none if it is too small, or most of it is there in the other image too.
fn found(
    part: &[usize],
    verdicts: &[Verdict],
    same: &[Vector3],
    image: &DepthImage,
    support: &Support,
    config: &DepthChangesConfig,
) -> Option<UnmatchedImageObject> {
    let support_from_camera = support.camera_from_support().inverse();
    let on_support = |point: &Vector3| support_from_camera * nalgebra::Point3::from(*point);
    let points: Vec<[f32; 3]> = part
        .iter()
        .filter_map(|pixel| image.point(*pixel))
        .map(|point| on_support(&point).coords.map(|at| at as f32).into())
        .collect();
    let place = UprightBox::around(&points, &config.box_fit)?;
    let place = if place.bottom_m() <= config.stands_within_m { place.down_to(0.0) } else { place };
    let mut sorted = place.size_m;
    sorted.sort_by(f64::total_cmp);
    let changed = part.iter().filter(|pixel| verdicts[**pixel] == Verdict::Changed).count();
    let unchanged = same.iter().filter(|point| place.holds(&on_support(point).coords, 0.0)).count();
    let confidence = changed as f64 / (changed + unchanged) as f64;
    if sorted[1] < config.min_size_m || confidence < config.min_changed_share {
        return None;
    }
    let colours = image.colours();
    let colour =
        ColourHistogram::of(part.iter().filter_map(|pixel| colours.get(*pixel).copied()), &config.colours);
    let points = part.iter().map(|pixel| image.raw_point(*pixel)).collect();
    Some(UnmatchedImageObject { object: UnmatchedObject { place, points, confidence }, colour })
}

#[cfg(test)]
#[path = "detect_tests.rs"]
mod tests;
