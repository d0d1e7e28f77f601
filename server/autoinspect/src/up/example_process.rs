//! Makes the example in a separate process, with low priority, so that the robot's core keeps its time.

use super::import_process::run;
use crate::example::{ExampleDocument, OBJECTS_FILE, SITE_NAME};
use crate::texts;
use api::ImportStage;
use ports::{ExampleMaker, ExampleRequest};
use site_model::Object;
use std::ffi::OsString;
use std::fs;
use std::ops::ControlFlow;

/// Runs `autoinspect example`.
pub struct ExampleProcess {
    /// Length of the walk; none: that of the command.
    pub minutes: Option<f64>,
}

impl ExampleMaker for ExampleProcess {
    fn site(&self) -> &str {
        SITE_NAME
    }

    fn make(
        &self,
        request: &ExampleRequest<'_>,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<Vec<Object>, String> {
        let ExampleRequest { name, time_zone, out } = request;
        let mut arguments: Vec<OsString> = vec![
            "example".into(),
            format!("--name={name}").into(),
            format!("--time-zone={time_zone}").into(),
            "--out".into(),
            out.into(),
            "--background".into(),
        ];
        arguments.extend(self.minutes.map(|minutes| format!("--minutes={minutes}").into()));
        run(None, &arguments, &[(out, texts::EXAMPLE_FOLDER)], progress)?;
        let file = out.join(OBJECTS_FILE);
        let unreadable =
            |error: &dyn std::fmt::Display| texts::unreadable_input(OBJECTS_FILE.as_ref(), error);
        let text = fs::read_to_string(&file).map_err(|error| unreadable(&error))?;
        let document: ExampleDocument = serde_json::from_str(&text).map_err(|error| unreadable(&error))?;
        // The map's folder holds what belongs to the map only.
        fs::remove_file(&file).map_err(|error| unreadable(&error))?;
        Ok(document.objects)
    }
}
