//! Stores data in the browser between visits: the view settings, the draft of the site, and the client's secret as long as the tab is open.
//!
//! A browser may forbid storage, or its storage may be full. Then every visit starts with the defaults.

use crate::browser;
use api::LeaseToken;
use client_model::{StoredDraft, ViewSettings};

const LEASE_KEY: &str = "autoinspect.lease";
const VIEW_KEY: &str = "autoinspect.view";
const DRAFT_KEY: &str = "autoinspect.draft";

/// The secret of this tab. It is kept over reloads, so that a reload keeps control of the robot.
pub(crate) fn load_lease_token() -> LeaseToken {
    let storage = browser::tab_storage();
    let stored = storage.as_ref().and_then(|storage| storage.get_item(LEASE_KEY).ok().flatten());
    if let Some(token) = stored.and_then(|text| text.parse().ok()) {
        return LeaseToken(token);
    }
    let token = uuid::Uuid::new_v4();
    if let Some(storage) = storage {
        // Without storage every reload has a new one.
        let _ = storage.set_item(LEASE_KEY, &token.to_string());
    }
    LeaseToken(token)
}

/// The view settings of the last visit, or the defaults.
pub(crate) fn load_view_settings() -> ViewSettings {
    browser::lasting_storage()
        .and_then(|storage| storage.get_item(VIEW_KEY).ok().flatten())
        .and_then(|text| serde_json::from_str(&text).ok())
        .unwrap_or_default()
}

/// Stores the view settings for the next visit.
pub(crate) fn save_view_settings(settings: &ViewSettings) {
    if let (Some(storage), Ok(text)) = (browser::lasting_storage(), serde_json::to_string(settings)) {
        // Without storage the next visit starts with the defaults.
        let _ = storage.set_item(VIEW_KEY, &text);
    }
}

/// The draft of the site of the last visit, or none.
pub(crate) fn load_draft() -> StoredDraft {
    browser::lasting_storage()
        .and_then(|storage| storage.get_item(DRAFT_KEY).ok().flatten())
        .and_then(|text| serde_json::from_str(&text).ok())
        .unwrap_or_default()
}

/// Stores the draft of the site for the next visit; one that is over is removed.
pub(crate) fn save_draft(draft: &StoredDraft) {
    let Some(storage) = browser::lasting_storage() else { return };
    let stored = if *draft == StoredDraft::default() {
        storage.remove_item(DRAFT_KEY)
    } else {
        serde_json::to_string(draft).map_or(Ok(()), |text| storage.set_item(DRAFT_KEY, &text))
    };
    if stored.is_err() {
        browser::log_warning("the draft of the site could not be stored: it will be gone after a reload");
    }
}
