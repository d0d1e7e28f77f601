//! Files of results.

/// How a file of a result is decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResultFileKind {
    /// As a picture.
    Picture,
    /// As a PNG with 16 bits a pixel, hundredths of a kelvin.
    Temperatures,
    /// As the JSON of a [`site_model::GammaSpectrum`].
    Spectrum,
}
