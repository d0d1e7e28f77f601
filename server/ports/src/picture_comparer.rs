//! Compares two pictures of one thing.

use site_model::{ActionReport, PictureComparisonOutcome};
use std::path::Path;

/// A picture that is compared.
#[derive(Clone, Copy, Debug)]
pub struct ComparedPicture<'a> {
    /// Its file.
    pub file: &'a Path,
    /// Report of the action that took it.
    pub report: &'a ActionReport,
}

/// Compares pictures. An implementation must protect the core from pictures that are damaged or very large, and from the time that a comparison takes.
pub trait PictureComparer: Send {
    /// Aligns an earlier picture with a later one, and finds what has changed. Asks now and then whether to give up.
    ///
    /// # Errors
    /// One sentence with the error and its remedy. Pictures that cannot be aligned are no error.
    fn compare(
        &self,
        before: ComparedPicture<'_>,
        after: ComparedPicture<'_>,
        is_cancelled: &mut dyn FnMut() -> bool,
    ) -> Result<PictureComparisonOutcome, String>;
}
