//! Makes a site to try.

use api::ImportStage;
use site_model::Object;
use std::ops::ControlFlow;
use std::path::Path;

/// What is asked of an [`ExampleMaker`].
#[derive(Clone, Copy, Debug)]
pub struct ExampleRequest<'a> {
    /// Name of map and site.
    pub name: &'a str,
    /// Time zone of the schedule, a name of the IANA database.
    pub time_zone: &'a str,
    /// Folder for the map, with its tiles in `tiles`.
    pub out: &'a Path,
}

/// Makes an example: a map and the objects of the site.
pub trait ExampleMaker: Send {
    /// The simulated site whose robot can walk in the example.
    fn site(&self) -> &str;

    /// Makes the map in a folder, and returns the objects of the site. `progress` is called with the stage and its share done, 0 to 1, and decides whether to
    /// continue.
    ///
    /// # Errors
    /// One sentence with the error and its remedy.
    fn make(
        &self,
        request: &ExampleRequest<'_>,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<Vec<Object>, String>;
}
