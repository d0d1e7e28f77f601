//! A descriptor that counts shapes: distances, angles and areas between points of the surface, its spread and its sides.

use crate::descriptor::{Descriptor, ObjectDescriptor};
use crate::extents::box_sides_m;
use crate::sample::{SurfacePoint, SurfaceSample};

/// Name with version.
pub(crate) const NAME: &str = "geometric-1";
/// Points between which distances and angles are counted: 2,016 pairs.
const COUNTED_POINTS: usize = 64;
/// Bins of distances, of angles of triangles, of their areas, and of angles between normals.
const BINS: [usize; 4] = [8, 6, 6, 4];
/// Distances of the corners of a triangle in the list of points: triangles of points near and far in the list.
const TRIANGLES: [[usize; 2]; 8] = [[1, 2], [1, 5], [2, 9], [3, 7], [5, 16], [8, 21], [11, 30], [17, 27]];

/// Parameters of [`GeometricDescriptor`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeometricDescriptorConfig {
    /// Weight of the logarithms of the sides of the box. Source: docs/benchmarks/changes.md; half and twice of it were tried.
    pub size_weight: f64,
    /// Weight of the shares of the spread along the principal axes. Chosen: they say less of a view from one side than the sides do.
    pub spread_weight: f64,
    /// Weight of the square roots of the shares in each bin. Chosen: with the sizes alone, things of one size are the same.
    pub histogram_weight: f64,
}

impl Default for GeometricDescriptorConfig {
    fn default() -> Self {
        Self { size_weight: 0.4, spread_weight: 0.1, histogram_weight: 0.1 }
    }
}

/// Shape distributions D2, D3 and A3 (Osada and others, *Shape Distributions*, 2002), with those of the angles between normals, the eigenvalues of the points (Weinmann and others,
/// *Semantic point cloud interpretation based on optimal neighborhoods, relevant features and efficient classifiers*, 2015), and the sides of the box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GeometricDescriptor {
    /// Its parameters. Descriptors of others than the default ones cannot be compared with those.
    pub config: GeometricDescriptorConfig,
}

impl ObjectDescriptor for GeometricDescriptor {
    fn name(&self) -> &str {
        NAME
    }

    fn describe(&self, points: &[[f32; 3]]) -> Option<Descriptor> {
        let sample = SurfaceSample::new(points)?;
        let config = &self.config;
        let sizes = box_sides_m(&sample).map(|side_m| config.size_weight * (side_m + 0.05).ln());
        let sigma = sample.spread_m2.map(f64::sqrt);
        let spread = [sigma[0] - sigma[1], sigma[1] - sigma[2], sigma[2]]
            .map(|part| config.spread_weight * part / sigma[0].max(1e-9));
        let shares = histograms(&sample).into_iter().map(|share| config.histogram_weight * share.sqrt());
        Some(Descriptor::new(NAME, sizes.into_iter().chain(spread).chain(shares)))
    }
}

/// Shares in the bins of all histograms.
fn histograms(sample: &SurfaceSample) -> Vec<f64> {
    let points: Vec<&SurfacePoint> = sample.points.iter().take(COUNTED_POINTS).collect();
    let reach_m = 2.0 * sample.radius_m;
    let [mut distances, mut angles, mut areas, mut normals] = BINS.map(|bins| vec![0.0; bins]);
    for (place, a) in points.iter().enumerate() {
        for b in &points[place + 1..] {
            count(&mut distances, (a.at_m - b.at_m).norm() / reach_m);
            // Both have to be of a surface, or else the angle is chance.
            let weight = a.planarity * b.planarity;
            count_weighted(&mut normals, a.normal.dot(&b.normal).abs(), weight);
        }
        for [second, third] in TRIANGLES {
            let [b, c] = [second, third].map(|step| points[(place + step) % points.len()].at_m);
            let (ab, ac) = (b - a.at_m, c - a.at_m);
            let (lengths, doubled_area_m2) = (ab.norm() * ac.norm(), ab.cross(&ac).norm());
            if lengths > 0.0 {
                count(&mut angles, (1.0 - ab.dot(&ac) / lengths) / 2.0);
            }
            count(&mut areas, (doubled_area_m2 / 2.0).sqrt() / reach_m * 1.5);
        }
    }
    [distances, angles, areas, normals].into_iter().flat_map(shares).collect()
}

fn count(bins: &mut [f64], value: f64) {
    count_weighted(bins, value, 1.0);
}

/// Counts a value from 0 to 1 in the two bins nearest to it, so that a little noise changes little.
fn count_weighted(bins: &mut [f64], value: f64, weight: f64) {
    let last = bins.len() - 1;
    let at = (value.clamp(0.0, 1.0) * bins.len() as f64 - 0.5).clamp(0.0, last as f64);
    let low = (at as usize).min(last);
    let share = at - low as f64;
    bins[low] += weight * (1.0 - share);
    bins[(low + 1).min(last)] += weight * share;
}

fn shares(bins: Vec<f64>) -> Vec<f64> {
    let sum: f64 = bins.iter().sum();
    bins.into_iter().map(|count| if sum > 0.0 { count / sum } else { 0.0 }).collect()
}
