//! Seeded random numbers: one root seed with named children. A new consumer takes a new name, so the numbers of the existing
//! consumers do not change.

use rand_core::{RngCore, SeedableRng};
use rand_pcg::Pcg64;

/// A seed that derives child seeds by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RngTree {
    seed: u64,
}

impl RngTree {
    /// The root of a tree.
    pub const fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// The child of that name: FNV-1a of the name, started with the parent's seed, finished by the mixer of SplitMix64.
    pub fn child(&self, name: &str) -> Self {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64 ^ self.seed;
        for byte in name.bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
        hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Self { seed: hash ^ (hash >> 31) }
    }

    /// A generator seeded by this node.
    pub fn rng(&self) -> Rng {
        Rng { generator: Pcg64::seed_from_u64(self.seed), spare: None }
    }
}

/// A generator of uniform and normal random numbers (PCG-64).
#[derive(Clone, Debug)]
pub struct Rng {
    generator: Pcg64,
    /// Second number of the last Box-Muller pair.
    spare: Option<f64>,
}

impl Rng {
    /// Uniform over all 64-bit numbers.
    pub fn bits(&mut self) -> u64 {
        self.generator.next_u64()
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Uniform in `[low, high)`.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Normal with mean 0 and standard deviation 1 (Box-Muller).
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        let (sin, cos) = (self.uniform() * std::f64::consts::TAU).sin_cos();
        self.spare = Some(radius * sin);
        radius * cos
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_paths_give_equal_numbers_and_other_paths_give_others() {
        let root = RngTree::new(42);
        let draw = |tree: RngTree| {
            (0..8)
                .map({
                    let mut rng = tree.rng();
                    move |_| rng.bits()
                })
                .collect::<Vec<_>>()
        };
        assert_eq!(draw(root.child("imu")), draw(RngTree::new(42).child("imu")));
        assert_ne!(draw(root.child("imu")), draw(root.child("legs")));
        assert_ne!(draw(root.child("imu")), draw(RngTree::new(43).child("imu")));
    }

    #[test]
    fn normal_numbers_have_mean_zero_and_variance_one() {
        let mut rng = RngTree::new(1).rng();
        let samples: Vec<f64> = (0..20_000).map(|_| rng.normal()).collect();
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        let variance = samples.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / samples.len() as f64;
        assert!(mean.abs() < 0.03 && (variance - 1.0).abs() < 0.04, "{mean} {variance}");
    }
}
