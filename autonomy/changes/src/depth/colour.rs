//! How alike the colours of two parts of an image are.

/// Cells of the histogram: shares of red and of green, and the brightness.
const SHARE_CELLS: usize = 8;
const BRIGHTNESS_CELLS: usize = 4;
/// Shares of red and green up to which cells are told apart; two thirds of the brightness in one of three colours is a strong colour.
const SHARE_MAX: f64 = 2.0 / 3.0;

/// Shares of the pixels of a part with each colour.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ColourHistogram {
    shares: Vec<f64>,
}

impl ColourHistogram {
    /// The histogram of colours; none without colours.
    pub(crate) fn of(colours: impl Iterator<Item = [u8; 3]>) -> Option<Self> {
        let mut counts = vec![0_usize; SHARE_CELLS * SHARE_CELLS * BRIGHTNESS_CELLS];
        for colour in colours {
            counts[cell(colour)] += 1;
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

fn cell(colour: [u8; 3]) -> usize {
    let [red, green, blue] = colour.map(f64::from);
    let sum = red + green + blue + 1.0;
    let share = |part: f64| ((part / sum / SHARE_MAX * SHARE_CELLS as f64) as usize).min(SHARE_CELLS - 1);
    let brightness = ((sum / 768.0 * BRIGHTNESS_CELLS as f64) as usize).min(BRIGHTNESS_CELLS - 1);
    (share(red) * SHARE_CELLS + share(green)) * BRIGHTNESS_CELLS + brightness
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_colours_overlap_and_others_do_not() {
        let of = |colour: [u8; 3]| ColourHistogram::of([colour; 9].into_iter()).expect("colours");
        let (red, blue) = (of([200, 20, 20]), of([20, 20, 200]));
        assert!((red.overlap(&red) - 1.0).abs() < 1e-12);
        assert_eq!(red.overlap(&blue), 0.0);
        assert_eq!(ColourHistogram::of(std::iter::empty()), None);
    }
}
