//! Which object that is new at one place is one that is gone from another.

use crate::UprightBox;
use object_identity::{Association, AssociationConfig, ObjectDescriptor, ObjectShape, associate};

/// An object at a place, with the points that a visit has of it.
pub(crate) struct SeenObject<'a> {
    pub(crate) place: &'a UprightBox,
    pub(crate) points: &'a [[f32; 3]],
}

/// Pairs of removed and appeared objects, by their places in the lists, that are likely one thing: those with the greatest sum of logarithms of odds (docs/maths/object-identity.md), each with its
/// probability.
pub(crate) fn moves(
    removed: &[SeenObject],
    appeared: &[SeenObject],
    descriptor: &dyn ObjectDescriptor,
    config: &AssociationConfig,
) -> Vec<Association> {
    let shapes = |objects: &[SeenObject]| -> Vec<ObjectShape> {
        let shape = |object: &SeenObject| ObjectShape {
            size_m: object.place.size_m,
            descriptor: descriptor.describe(object.points),
        };
        objects.iter().map(shape).collect()
    };
    let (gone, new) = (shapes(removed), shapes(appeared));
    best_pairs(removed.len(), appeared.len(), |a, b| {
        let distance_m = (removed[a].place.centre_m - appeared[b].place.centre_m).norm();
        config.log_odds(&gone[a], &new[b], distance_m)
    })
}

/// The same of objects of which all that is known is which may be one: such pairs have the odds of things that look alike.
pub(crate) fn moves_of_alike(
    removed: &[UprightBox],
    appeared: &[UprightBox],
    may_be_same: impl Fn(usize, usize) -> bool,
    config: &AssociationConfig,
) -> Vec<Association> {
    best_pairs(removed.len(), appeared.len(), |a, b| {
        let distance_m = (removed[a].centre_m - appeared[b].centre_m).norm();
        if may_be_same(a, b) { config.log_odds_of_alike(distance_m) } else { f64::NEG_INFINITY }
    })
}

fn best_pairs(removed: usize, appeared: usize, log_odds: impl Fn(usize, usize) -> f64) -> Vec<Association> {
    let row = |a: usize| (0..appeared).map(|b| log_odds(a, b)).collect();
    associate(&(0..removed).map(row).collect::<Vec<_>>())
}

/// Whether two boxes have one size: each side differs at most by a share of the larger, or by a distance, metres.
pub(crate) fn is_same_size(a: &UprightBox, b: &UprightBox, share: f64, distance_m: f64) -> bool {
    a.size_m.iter().zip(b.size_m).all(|(a, b)| (a - b).abs() <= (share * a.max(b)).max(distance_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vector3;
    use object_identity::PointNetwork;

    fn of(x: f64, size_m: [f64; 3]) -> UprightBox {
        UprightBox { centre_m: Vector3::new(x, 0.0, 0.5), size_m, yaw_rad: 0.0 }
    }

    /// Points on three sides of a box.
    fn points(place: &UprightBox) -> Vec<[f32; 3]> {
        let steps = || (0..=12).map(|step| f64::from(step) / 12.0);
        let sides = steps().flat_map(|a| steps().flat_map(move |b| [[a, b, 1.0], [a, 1.0, b], [1.0, a, b]]));
        let at = |share: [f64; 3]| {
            let offset: Vec<f64> =
                share.iter().zip(place.size_m).map(|(share, side)| (share - 0.5) * side).collect();
            [0, 1, 2].map(|axis| (place.centre_m[axis] + offset[axis]) as f32)
        };
        sides.map(at).collect()
    }

    fn seen<'a>(boxes: &'a [UprightBox], points: &'a [Vec<[f32; 3]>]) -> Vec<SeenObject<'a>> {
        boxes.iter().zip(points).map(|(place, points)| SeenObject { place, points }).collect()
    }

    fn found(removed: &[UprightBox], appeared: &[UprightBox]) -> Vec<Association> {
        let of_boxes = |boxes: &[UprightBox]| boxes.iter().map(points).collect::<Vec<_>>();
        let (gone, new) = (of_boxes(removed), of_boxes(appeared));
        let method = PointNetwork::shipped().expect("whole");
        moves(&seen(removed, &gone), &seen(appeared, &new), &method, &AssociationConfig::default())
    }

    #[test]
    fn the_one_that_looks_alike_was_moved() {
        let removed = [of(0.0, [0.6, 0.4, 1.0]), of(1.0, [2.0, 0.4, 1.0])];
        let appeared = [of(9.0, [0.4, 0.3, 0.3]), of(5.0, [0.62, 0.38, 0.98]), of(2.0, [1.2, 1.1, 0.5])];
        let pairs = found(&removed, &appeared);
        assert_eq!(pairs.iter().map(|found| found.pair).collect::<Vec<_>>(), [[0, 1]]);
        assert!(pairs[0].probability > 0.6 && pairs[0].probability < 0.97, "{pairs:?}");
        assert_eq!(found(&[], &appeared), []);
    }

    #[test]
    fn of_things_of_one_make_the_nearer_ones_are_pairs_and_neither_is_certain() {
        let size_m = [0.6, 0.4, 0.4];
        let pairs = found(&[of(0.0, size_m), of(9.0, size_m)], &[of(5.5, size_m), of(4.5, size_m)]);
        assert_eq!(pairs.iter().map(|found| found.pair).collect::<Vec<_>>(), [[0, 1], [1, 0]]);
        assert!(pairs.iter().all(|found| found.probability < 0.75), "{pairs:?}");
        let alike = moves_of_alike(
            &[of(0.0, size_m)],
            &[of(1.0, size_m), of(3.0, size_m)],
            |_, _| true,
            &AssociationConfig::default(),
        );
        assert!(alike.len() == 1 && alike[0].pair == [0, 0] && alike[0].probability < 0.6, "{alike:?}");
    }
}
