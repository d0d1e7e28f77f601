//! Areas that people draw on a plan.

/// Whether a point is inside a polygon, by the even-odd rule: a ray along x crosses an odd number of edges. `corners`: in either sense of rotation. Linear in the corners.
pub fn is_in_polygon(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let mut is_inside = false;
    for (index, a) in corners.iter().enumerate() {
        let b = corners[(index + 1) % corners.len()];
        if (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
            is_inside = !is_inside;
        }
    }
    is_inside
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_notch_is_outside_and_the_sense_of_rotation_does_not_matter() {
        let mut corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]];
        for _ in 0..2 {
            let inside =
                [[1.0, 0.5], [3.5, 2.0], [2.0, 2.0], [5.0, 0.5]].map(|at| is_in_polygon(&corners, at));
            assert_eq!(inside, [true, true, false, false]);
            corners.reverse();
        }
        assert!(!is_in_polygon(&[], [0.0, 0.0]));
    }
}
