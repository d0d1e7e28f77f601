//! What the core has sent last of stored data and missions: maps, damaged maps, the bin, uploads, runs.

use api::{BinnedMap, DamagedMap, Event, Import, MapSummary, StoredUpload};
use site_model::{MissionStatus, RouteStatus};
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
    /// The making of a map.
    pub(crate) import: Option<&'a Import>,
    /// State of missions.
    pub(crate) missions: Option<&'a MissionStatus>,
    /// Place on the topological map, and route.
    pub(crate) route: Option<&'a RouteStatus>,
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
                Event::Import(import) => data.import = Some(import),
                Event::Missions(missions) => data.missions = Some(missions),
                Event::Route(route) => data.route = Some(route),
                _ => {}
            }
        }
        data
    }
}
