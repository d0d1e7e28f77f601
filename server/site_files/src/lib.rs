//! Sites of the simulator as files: a building as `FILE.glb` (glTF 2.0, one binary file), and beside it `FILE.site.json` with what a model does
//! not hold: docks, the start, routes, paths of people, what is furniture, and what surfaces are made of.
//!
//! - `glb`: glTF bytes to triangles and back;
//! - `sidecar`: the JSON file;
//! - `source`: how a command line names a site, and how it is read and written;
//! - `site_changes`: changes of a site as a file, a script or the truth for scorers;
//! - `texts`: the sentences of the errors.

mod error;
pub mod fuzzing;
mod glb;
mod sidecar;
mod site_changes;
mod source;
#[cfg(test)]
mod tests;
mod texts;

pub use error::SiteFileError;
pub use site_changes::SiteChanges;
pub use source::{SiteSource, read_site, write_site};
