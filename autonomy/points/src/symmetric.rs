//! Eigenvalues of symmetric 3x3 matrices in closed form. A surface normal takes tens of nanoseconds. An iterative decomposition takes hundreds.

/// A symmetric 3x3 matrix as `[xx, xy, xz, yy, yz, zz]`.
pub type Symmetric3 = [f32; 6];

/// Principal axes of a covariance matrix that describe a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalAxes {
    /// Eigenvalues in ascending order, in the unit of the matrix.
    pub variances: [f32; 3],
    /// Unit eigenvector of the smallest eigenvalue, of arbitrary sign: the normal of a flat cloud.
    pub normal: [f32; 3],
}

/// Cross products shorter than this share of the squared scale of the matrix mean that the smallest eigenvalue is repeated.
const MIN_RELATIVE_GAP: f64 = 1e-6;

/// Eigenvalues and the eigenvector of the smallest one. `None` if the matrix is not finite or its smallest eigenvalue is nearly
/// repeated, so that no direction is the normal.
///
/// Source: Smith, *Eigenvalues of a symmetric 3x3 matrix*, CACM 4 (4), 1961. The eigenvector is the longest cross product of two
/// rows of `matrix - smallest * identity`.
pub fn principal_axes(matrix: &Symmetric3) -> Option<PrincipalAxes> {
    let [xx, xy, xz, yy, yz, zz] = matrix.map(f64::from);
    let mean = (xx + yy + zz) / 3.0;
    let (dx, dy, dz) = (xx - mean, yy - mean, zz - mean);
    let scale_squared = (dx * dx + dy * dy + dz * dz + 2.0 * (xy * xy + xz * xz + yz * yz)) / 6.0;
    if !scale_squared.is_finite() || scale_squared <= 0.0 {
        return None;
    }
    let scale = scale_squared.sqrt();
    let determinant = dx * (dy * dz - yz * yz) - xy * (xy * dz - yz * xz) + xz * (xy * yz - dy * xz);
    let half = (determinant / (2.0 * scale * scale_squared)).clamp(-1.0, 1.0);
    let angle = half.acos() / 3.0;
    let largest = mean + 2.0 * scale * angle.cos();
    let smallest = mean + 2.0 * scale * (angle + std::f64::consts::TAU / 3.0).cos();
    let middle = 3.0 * mean - largest - smallest;

    let rows = [[xx - smallest, xy, xz], [xy, yy - smallest, yz], [xz, yz, zz - smallest]];
    let crosses = [cross(&rows[0], &rows[1]), cross(&rows[0], &rows[2]), cross(&rows[1], &rows[2])];
    let mut longest = ([0.0; 3], 0.0);
    for vector in crosses {
        let squared = vector.iter().map(|c| c * c).sum::<f64>();
        if squared > longest.1 {
            longest = (vector, squared);
        }
    }
    // Relative to the matrix's scale, the cross products shrink with the gap between the smallest eigenvalue and the others.
    if longest.1 <= (MIN_RELATIVE_GAP * scale_squared).powi(2) {
        return None;
    }
    let inverse_length = 1.0 / longest.1.sqrt();
    Some(PrincipalAxes {
        variances: [smallest.max(0.0) as f32, middle as f32, largest as f32],
        normal: longest.0.map(|c| (c * inverse_length) as f32),
    })
}

fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_points_lines_and_matrices_that_are_not_finite_have_no_normal() {
        assert_eq!(principal_axes(&[1.0, 0.0, 0.0, 1.0, 0.0, 1.0]), None);
        assert_eq!(principal_axes(&[0.0; 6]), None);
        assert_eq!(principal_axes(&[f32::NAN; 6]), None);
        // The two smallest variances of a line are equal.
        assert_eq!(principal_axes(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]), None);
    }
}
