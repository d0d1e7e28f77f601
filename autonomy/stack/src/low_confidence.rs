//! A place that fits only half, recognised again and again as the robot walks.
//!
//! Where the map ends, much of what a scan shows is in no map, so that the right place fits no better than a wrong one may by chance. But
//! chance does not walk along: a place that is found anew from nothing, each time where the last one and the way since say, is the right
//! one.

use geometry::Isometry;
use localisation::{PoseHypothesis, is_same_place};

/// It is believed after so many metres over which it was found again and again.
const WAY: f64 = 1.2;

/// What was recognised so far.
#[derive(Debug, Default)]
pub(crate) struct LowConfidenceConfirmation {
    /// The base in the map and by odometry, when it was recognised last.
    last: Option<(Isometry, Isometry)>,
    /// Over which it was, metres.
    way: f64,
}

impl LowConfidenceConfirmation {
    /// Takes a place in that one scan fits half, taken at a moment of odometry. Says whether it can be believed now.
    pub fn recognise(&mut self, place: &PoseHypothesis, odom_from_base: &Isometry) -> bool {
        let before = self.last.replace((place.map_from_base, *odom_from_base));
        let Some((was, from)) = before else { return false };
        let moved = from.inverse() * odom_from_base;
        let goes_along = is_same_place(&(was * moved), &place.map_from_base);
        self.way = if goes_along { self.way + moved.translation.vector.norm() } else { 0.0 };
        self.way >= WAY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64) -> Isometry {
        Isometry::translation(x, 0.0, 0.0)
    }

    fn half(x: f64) -> PoseHypothesis {
        PoseHypothesis { map_from_base: at(x), fit: 0.6, contradicted: 0.0 }
    }

    #[test]
    fn a_place_that_walks_along_is_believed_and_one_that_does_not_or_that_stands_is_not() {
        let believed = |looks: &[(f64, f64)]| {
            let mut faint = LowConfidenceConfirmation::default();
            looks.iter().map(|(place, way)| faint.recognise(&half(*place), &at(*way))).collect::<Vec<_>>()
        };
        assert_eq!(
            believed(&[(10.0, 0.0), (10.5, 0.5), (11.0, 1.0), (11.5, 1.5)]),
            [false, false, false, true]
        );
        assert_eq!(believed(&[(10.0, 0.0); 6]), [false; 6], "it stands");
        let strays = [(10.0, 0.0), (10.5, 0.5), (11.0, 1.0), (30.0, 1.5), (30.5, 2.0), (31.0, 2.5)];
        assert_eq!(believed(&strays), [false; 6]);
        assert_eq!(believed(&[(10.0, 0.0), (10.0, 0.8), (10.0, 1.6), (10.0, 2.4), (10.0, 3.2)]), [false; 5]);
        assert_eq!(believed(&[(10.0, 0.0), (12.3, 2.3)]), [false, true], "fast robots look less often");
    }
}
