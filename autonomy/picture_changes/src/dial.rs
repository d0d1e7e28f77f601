//! The description of a gauge in another picture.

use crate::Homography;
use gauges::{Dial, DialMarks};

/// The marks of a scale in an earlier picture as they are in a later one. None if one of them is not ahead of the later camera.
pub fn mapped_marks(marks: &DialMarks, after_from_before: &Homography) -> Option<DialMarks> {
    Some(DialMarks {
        centre_px: after_from_before.map(marks.centre_px)?,
        start_px: after_from_before.map(marks.start_px)?,
        middle_px: after_from_before.map(marks.middle_px)?,
        end_px: after_from_before.map(marks.end_px)?,
        range: marks.range,
    })
}

/// The dial of an earlier picture as it is in a later one. None if it is not ahead of the later camera.
///
/// A dial that is seen more from the side is an ellipse; its radius is the mean along both axes of the picture.
pub fn mapped_dial(dial: &Dial, after_from_before: &Homography) -> Option<Dial> {
    let [x, y] = dial.centre_px;
    let r = dial.radius_px;
    let centre_px = after_from_before.map(dial.centre_px)?;
    let distance = |px: [f64; 2]| {
        let [x, y] = after_from_before.map(px)?;
        Some((x - centre_px[0]).hypot(y - centre_px[1]))
    };
    let distances =
        [distance([x - r, y])?, distance([x + r, y])?, distance([x, y - r])?, distance([x, y + r])?];
    let start = after_from_before.map([x + r * dial.start_rad.sin(), y - r * dial.start_rad.cos()])?;
    Some(Dial {
        centre_px,
        axis_px: after_from_before.map(dial.axis_px)?,
        radius_px: 0.25 * distances.iter().sum::<f64>(),
        start_rad: Dial::direction_rad(centre_px, start),
        ..*dial
    })
}
