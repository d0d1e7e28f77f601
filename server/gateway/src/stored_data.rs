//! The core's lists of stored data: maps, damaged maps, the bin, uploads.

use api::{BinnedMap, DamagedMap, Event, MapSummary, StoredUpload};
use std::sync::Arc;

/// The lists of stored data; `None` where the core has not sent one.
#[derive(Default)]
pub(crate) struct StoredData<'a> {
    /// Saved maps, newest first.
    pub(crate) maps: Option<&'a [MapSummary]>,
    /// Saved maps that cannot be read.
    pub(crate) damaged: Option<&'a [DamagedMap]>,
    /// Deleted maps, the last deleted first.
    pub(crate) binned: Option<&'a [BinnedMap]>,
    /// Uploaded files.
    pub(crate) uploads: Option<&'a [StoredUpload]>,
}

impl<'a> StoredData<'a> {
    /// The lists in these events.
    pub(crate) fn of(events: &'a [Option<Arc<Event>>]) -> Self {
        let mut data = Self::default();
        for event in events.iter().flatten() {
            match &**event {
                Event::Maps(maps) => data.maps = Some(maps),
                Event::DamagedMaps(maps) => data.damaged = Some(maps),
                Event::BinnedMaps(maps) => data.binned = Some(maps),
                Event::Uploads(uploads) => data.uploads = Some(uploads),
                _ => {}
            }
        }
        data
    }
}
