//! Reads the needle of a gauge in a picture.

use site_model::{GaugeDial, GaugeReport, Reading};
use std::path::Path;

/// What a picture says of a gauge.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadGauge {
    /// The value, with its standard deviation; none if the needle was not read.
    pub reading: Option<Reading>,
    /// Why not, and where the needle is.
    pub report: GaugeReport,
}

/// Reads gauges. An implementation must protect the core from pictures that are damaged or very large.
pub trait GaugeReader: Send {
    /// Reads the needle in the file `picture`. The dial was described in the file `described_in`, with which the picture is aligned first. Asks now and then whether to give up.
    ///
    /// # Errors
    /// One sentence with the error and its remedy. A needle that cannot be read is no error.
    fn read(
        &self,
        picture: &Path,
        described_in: &Path,
        dial: &GaugeDial,
        is_cancelled: &mut dyn FnMut() -> bool,
    ) -> Result<ReadGauge, String>;
}
