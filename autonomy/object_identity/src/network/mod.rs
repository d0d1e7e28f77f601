//! A descriptor that was learned: a small network over pairs of points of an object.
//!
//! - `features`: what it is given of a pair and of the whole; nothing of it depends on how the object is turned;
//! - `layers`: its dense layers and their derivatives;
//! - `file`: its weights as bytes;
//! - `training`: how they are found.

mod features;
mod file;
mod layers;
mod training;

pub use features::ViewFeatures;
pub use file::NetworkFileError;
pub use training::{TrainingConfig, train};

use crate::descriptor::{Descriptor, ObjectDescriptor};
use crate::sample::SurfaceSample;
use features::{PAIR_FEATURES, WHOLE_FEATURES};
use layers::Dense;

/// Name of the method; that of a descriptor ends with the start of the checksum of its weights.
pub(crate) const NAME: &str = "network-1";
/// Units of the layers: of a pair, of a pair before pooling, of the whole, and of the descriptor.
const UNITS: [usize; 4] = [32, 48, 64, 24];
/// The weights that come with the program.
const SHIPPED: &[u8] = include_bytes!("../../weights/network-1.bin");

/// A network in the manner of PointNet (Qi and others, 2017): each pair of points is passed through the same layers, the mean and the maximum over all pairs through further ones. Source of
/// the idea of a learned descriptor for objects: Zhang and others, *InstaLoc*, 2023.
#[derive(Clone, Debug, PartialEq)]
pub struct PointNetwork {
    pair: [Dense; 2],
    whole: [Dense; 2],
    name: String,
}

impl PointNetwork {
    /// The network that comes with the program.
    ///
    /// # Errors
    /// Never, unless the program was built with a damaged file.
    pub fn shipped() -> Result<Self, NetworkFileError> {
        Self::from_bytes(SHIPPED)
    }

    /// A network of these layers.
    fn new(pair: [Dense; 2], whole: [Dense; 2]) -> Self {
        let mut network = Self { pair, whole, name: String::new() };
        network.name = format!("{NAME}-{}", &network.checksum().to_hex()[..8]);
        network
    }

    /// Its layers in the order in which they are passed.
    fn layers(&self) -> [&Dense; 4] {
        let ([a, b], [c, d]) = (&self.pair, &self.whole);
        [a, b, c, d]
    }

    /// Number of its weights.
    pub fn weights(&self) -> usize {
        self.layers().into_iter().map(Dense::weights).sum()
    }

    /// The vector of length one for a view.
    pub fn embed(&self, view: &ViewFeatures) -> Vec<f32> {
        let units = UNITS[1];
        let (mut first, mut second) = (vec![0.0; UNITS[0]], vec![0.0; units]);
        let (mut mean, mut most) = (vec![0.0_f32; units], vec![0.0_f32; units]);
        for pair in &view.pairs {
            self.pair[0].forward(pair, &mut first);
            layers::rectify(&mut first);
            self.pair[1].forward(&first, &mut second);
            layers::rectify(&mut second);
            for unit in 0..units {
                mean[unit] += second[unit];
                most[unit] = most[unit].max(second[unit]);
            }
        }
        let share = 1.0 / view.pairs.len().max(1) as f32;
        let pooled: Vec<f32> =
            mean.into_iter().map(|sum| sum * share).chain(most).chain(view.whole).collect();
        let (mut third, mut last) = (vec![0.0; UNITS[2]], vec![0.0; UNITS[3]]);
        self.whole[0].forward(&pooled, &mut third);
        layers::rectify(&mut third);
        self.whole[1].forward(&third, &mut last);
        layers::normalise(&mut last);
        last
    }

    /// Inputs and outputs of the layers.
    fn shapes() -> [[usize; 2]; 4] {
        [
            [PAIR_FEATURES, UNITS[0]],
            [UNITS[0], UNITS[1]],
            [2 * UNITS[1] + WHOLE_FEATURES, UNITS[2]],
            [UNITS[2], UNITS[3]],
        ]
    }
}

impl ObjectDescriptor for PointNetwork {
    fn name(&self) -> &str {
        &self.name
    }

    fn describe(&self, points: &[[f32; 3]]) -> Option<Descriptor> {
        let view = ViewFeatures::of(&SurfaceSample::new(points)?);
        Some(Descriptor::new(&self.name, self.embed(&view).into_iter().map(f64::from)))
    }
}
