//! Entry point for the fuzzer: the parsers without the building of a site, which takes seconds.

use crate::{SiteFileError, glb, sidecar, texts};
use sim::BuildingModelConfig;
use std::path::Path;

/// Reads the content of a GLB file and of its sidecar; returns the number of parts.
///
/// # Errors
/// When one of both is damaged, or they contradict each other.
pub fn read_model(model: &[u8], sidecar: &[u8]) -> Result<usize, SiteFileError> {
    let (file, beside) = (Path::new("b.glb"), Path::new("b.site.json"));
    let max_triangles = BuildingModelConfig::default().max_triangles;
    let document = glb::read(model, max_triangles).map_err(|reason| SiteFileError::new(file, reason))?;
    let failed = |reason| SiteFileError::new(beside, reason);
    let text = std::str::from_utf8(sidecar).map_err(|error| failed(texts::not_read(&error)))?;
    let sidecar = sidecar::parse(text).map_err(failed)?;
    let model = sidecar::model("b".to_owned(), &document, &sidecar).map_err(failed)?;
    Ok(model.parts.len())
}
