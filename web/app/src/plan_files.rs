//! Missions and schedules as files of the operator's machine: read from one that is chosen in the browser's dialogue, or saved as a download.

use crate::browser;
use crate::file_dialog::FileDialog;
use crate::inbox::Inbox;
use crate::saved_file;
use crate::texts;
use client_model::ClientEvent;
use site_model::PlanFile;
use wasm_bindgen_futures::JsFuture;
use web_sys::File;

/// File types that the dialogue offers first.
const FILE_TYPES: &str = ".json";
/// Id of the page's file input.
const INPUT_ID: &str = "plan-file";
/// Media type of a saved file.
const FILE_TYPE: &str = "application/json";
/// Name that a saved file is given.
const FILE_NAME: &str = "autoinspect-plan.json";

/// Parameters of plan files that are read.
struct PlanFileConfig {
    /// Largest file that is read, bytes. Missions and schedules of a site are a few hundred kilobytes. Chosen: many times that; a larger one is another file.
    max_file_bytes: f64,
}

const CONFIG: PlanFileConfig = PlanFileConfig { max_file_bytes: 16e6 };

/// The dialogue for files of missions and schedules.
pub(crate) struct PlanFiles {
    inbox: Inbox,
    dialog: FileDialog,
}

impl PlanFiles {
    /// `inbox` receives what was read.
    pub(crate) fn new(inbox: Inbox) -> Self {
        Self { inbox, dialog: FileDialog::new(INPUT_ID, FILE_TYPES) }
    }

    /// Opens the browser's file dialogue; the chosen file is read.
    pub(crate) fn open_file_dialog(&mut self) {
        let inbox = self.inbox.clone();
        self.dialog.open(move |file| {
            let inbox = inbox.clone();
            wasm_bindgen_futures::spawn_local(async move {
                let (name, result) = (file.name(), read(&file).await);
                inbox.push_event(ClientEvent::PlanFileRead { name, result });
            });
        });
    }
}

async fn read(file: &File) -> Result<PlanFile, String> {
    let unreadable = |reason: &str| texts::plan_file_unreadable(&file.name(), reason);
    if file.size() > CONFIG.max_file_bytes {
        return Err(unreadable(texts::PLAN_FILE_TOO_LONG));
    }
    let text = JsFuture::from(file.text()).await.ok().and_then(|text| text.as_string());
    let text = text.ok_or_else(|| unreadable(texts::PLAN_FILE_NO_TEXT))?;
    serde_json::from_str(&text).map_err(|error| unreadable(&error.to_string()))
}

/// Saves a file as a download of the browser.
pub(crate) fn save(file: &PlanFile) {
    match serde_json::to_string_pretty(file) {
        Ok(text) => saved_file::save(FILE_NAME, FILE_TYPE, &text),
        Err(error) => browser::log_warning(&format!("missions and schedules could not be saved: {error}")),
    }
}
