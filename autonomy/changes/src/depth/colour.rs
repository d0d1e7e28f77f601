//! How alike the colours of two parts of an image are.

use super::config::ColourHistogramConfig;

/// Shares of the pixels of a part with each colour.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ColourHistogram {
    shares: Vec<f64>,
}

impl ColourHistogram {
    /// The histogram of colours; none without colours.
    pub(crate) fn of(colours: impl Iterator<Item = [u8; 3]>, config: &ColourHistogramConfig) -> Option<Self> {
        let mut counts = vec![0_usize; config.share_cells * config.share_cells * config.brightness_cells];
        for colour in colours {
            counts[cell(colour, config)] += 1;
        }
        let total: usize = counts.iter().sum();
        let shares = counts.into_iter().map(|count| count as f64 / total as f64).collect();
        (total > 0).then_some(Self { shares })
    }

    /// Overlap with another: 0 for no common colour, 1 for the same shares of all (Bhattacharyya coefficient).
    pub(crate) fn overlap(&self, other: &Self) -> f64 {
        self.shares.iter().zip(&other.shares).map(|(a, b)| (a * b).sqrt()).sum()
    }
}

fn cell(colour: [u8; 3], config: &ColourHistogramConfig) -> usize {
    let ColourHistogramConfig { share_cells, brightness_cells, max_share } = *config;
    let [red, green, blue] = colour.map(f64::from);
    let sum = red + green + blue + 1.0;
    let share = |part: f64| ((part / sum / max_share * share_cells as f64) as usize).min(share_cells - 1);
    let brightness = ((sum / 768.0 * brightness_cells as f64) as usize).min(brightness_cells - 1);
    (share(red) * share_cells + share(green)) * brightness_cells + brightness
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_colours_overlap_and_others_do_not() {
        let of = |colour: [u8; 3]| {
            ColourHistogram::of([colour; 9].into_iter(), &ColourHistogramConfig::default()).expect("colours")
        };
        let (red, blue) = (of([200, 20, 20]), of([20, 20, 200]));
        assert!((red.overlap(&red) - 1.0).abs() < 1e-12);
        assert_eq!(red.overlap(&blue), 0.0);
        assert_eq!(ColourHistogram::of(std::iter::empty(), &ColourHistogramConfig::default()), None);
    }
}
