//! The offset that is subtracted from the coordinates of a survey, so that single precision is enough for them.

use vocab::Vec3;

/// Parameters of the offset that is subtracted from coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OffsetConfig {
    /// Coordinates up to this size get no offset, metres: single precision resolves a tenth of a millimetre there. Chosen: most sites are smaller; map grids have
    /// coordinates of some 100 km.
    pub max_coordinate_m: f64,
    /// The offset is a multiple of this, metres, so that people can add it in their heads. Chosen: the last digit stays.
    pub multiple_m: f64,
    /// Number of points whose median decides on the offset. Chosen: a median of that number is not moved by stray points.
    pub sample_points: usize,
}

impl Default for OffsetConfig {
    fn default() -> Self {
        Self { max_coordinate_m: 1_000.0, multiple_m: 10.0, sample_points: 1_000 }
    }
}

/// The offset of a file, once it is decided.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CoordinateOffset {
    config: OffsetConfig,
    offset: Option<[f64; 3]>,
}

impl CoordinateOffset {
    /// Decides by the median of the first points, or of the first positions of a scanner.
    pub fn decide(&mut self, first: &[[f64; 3]]) {
        let config = self.config;
        self.offset.get_or_insert_with(|| {
            std::array::from_fn(|axis| {
                let mut values: Vec<f64> =
                    first.iter().map(|point| point[axis]).filter(|value| value.is_finite()).collect();
                values.sort_by(f64::total_cmp);
                let median = values.get(values.len() / 2).copied().unwrap_or(0.0);
                if median.abs() > config.max_coordinate_m {
                    (median / config.multiple_m).round() * config.multiple_m
                } else {
                    0.0
                }
            })
        });
    }

    /// Whether this number of points is enough to decide it.
    pub fn is_enough(&self, points: usize) -> bool {
        points >= self.config.sample_points
    }

    /// Whether it is decided.
    pub fn is_decided(&self) -> bool {
        self.offset.is_some()
    }

    /// The offset, metres; zero before it is decided.
    pub fn offset(&self) -> [f64; 3] {
        self.offset.unwrap_or_default()
    }

    /// A position less the offset.
    pub fn relative(&self, place: Vec3) -> Vec3 {
        let [x, y, z] = self.offset();
        Vec3::new(place.x - x, place.y - y, place.z - z)
    }
}
