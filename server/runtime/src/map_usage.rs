//! Which saved maps are in use now: they cannot be deleted.
//!
//! The control loop updates it before it hands in the jobs of a step. So a map that the disk lane is to read is in use before the job is on the lane.

use messages::{LocalisationState, MappingState, Publication};
use std::sync::{Mutex, MutexGuard, PoisonError};
use vocab::{ClientId, MapId, UploadId};

/// What a map is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapUse {
    /// The robot is localised in it, or searches its pose there.
    Localisation,
    /// A mapping session extends it.
    Extension,
    /// A file or another map is aligned with it, or it is aligned.
    Import,
    /// An interrupted mapping session extends it.
    InterruptedSession,
}

/// Shared by the control loop, the import thread and the disk lane.
#[derive(Debug, Default)]
pub struct MapUsage {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    localised: Option<MapId>,
    extended: Option<MapId>,
    is_mapping: bool,
    is_on_run: bool,
    /// Who has control of the robot.
    controlled_by: Option<ClientId>,
    import: Option<RunningImport>,
}

/// The import that runs.
#[derive(Debug)]
struct RunningImport {
    upload: UploadId,
    maps: Vec<MapId>,
}

impl MapUsage {
    /// At the start: the map in which the robot was when it was switched off, if any.
    pub fn new(localised: Option<MapId>) -> Self {
        Self { state: Mutex::new(State { localised, ..State::default() }) }
    }

    /// Follows the state of localisation, mapping, missions and control.
    pub fn update(&self, publication: &Publication) {
        match publication {
            Publication::Localisation(state) => {
                self.lock().localised = match *state {
                    LocalisationState::Idle => None,
                    LocalisationState::Loading { map }
                    | LocalisationState::Relocalising { map, .. }
                    | LocalisationState::Localised { map, .. } => Some(map),
                };
            }
            Publication::Mapping(mapping) => {
                let mut state = self.lock();
                state.is_mapping = *mapping != MappingState::Idle;
                state.extended = match *mapping {
                    MappingState::Idle | MappingState::Starting { .. } => None,
                    MappingState::Loading { map, .. } | MappingState::Finding { map, .. } => Some(map),
                    MappingState::Mapping { extends, .. } => extends,
                    // Saving reads the map that the session extends.
                    MappingState::Saving { .. } => state.extended,
                };
            }
            Publication::Control(control) => self.lock().controlled_by = control.owner,
            Publication::Missions(status) => self.lock().is_on_run = !status.runs.is_empty(),
            _ => {}
        }
    }

    /// An import begins that works on this upload and reads these maps.
    pub fn begin_import(&self, upload: UploadId, maps: Vec<MapId>) {
        self.lock().import = Some(RunningImport { upload, maps });
    }

    /// The import has ended.
    pub fn end_import(&self) {
        self.lock().import = None;
    }

    /// What a map is used for, if it is in use.
    pub fn use_of(&self, map: MapId) -> Option<MapUse> {
        let state = self.lock();
        if state.localised == Some(map) {
            Some(MapUse::Localisation)
        } else if state.extended == Some(map) {
            Some(MapUse::Extension)
        } else {
            let is_imported = state.import.as_ref().is_some_and(|import| import.maps.contains(&map));
            is_imported.then_some(MapUse::Import)
        }
    }

    /// Whether an upload is being imported.
    pub fn is_importing(&self, upload: UploadId) -> bool {
        self.lock().import.as_ref().is_some_and(|import| import.upload == upload)
    }

    /// Whether the robot is localised in a map, or searches its pose there, and has no run of a mission, nor one that waits.
    pub fn is_idle_in(&self, map: MapId) -> bool {
        let state = self.lock();
        state.localised == Some(map) && !state.is_on_run && !state.is_mapping
    }

    /// Who has control of the robot, if somebody has.
    pub fn controlled_by(&self) -> Option<ClientId> {
        self.lock().controlled_by
    }

    /// Whether there is a mapping session.
    pub fn is_mapping(&self) -> bool {
        self.lock().is_mapping
    }

    /// Every change of the state is a single assignment or two, none of which depends on the other, so it is usable after a panic of another thread.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use uuid::Uuid;
    use vocab::SessionId;

    #[test]
    fn a_map_is_in_use_from_reading_it_until_it_is_left_or_the_session_is_saved() {
        let (map, session) = (MapId(Uuid::from_u128(1)), SessionId(Uuid::from_u128(2)));
        let usage = MapUsage::new(Some(map));
        assert_eq!(usage.use_of(map), Some(MapUse::Localisation), "from the start on");
        usage.update(&Publication::Localisation(LocalisationState::Idle));
        assert_eq!(usage.use_of(map), None);
        usage.update(&Publication::Localisation(LocalisationState::Loading { map }));
        assert_eq!(usage.use_of(map), Some(MapUse::Localisation));
        usage.update(&Publication::Localisation(LocalisationState::Idle));
        usage.update(&Publication::Mapping(MappingState::Loading { session, map }));
        usage.update(&Publication::Mapping(MappingState::Saving { session, map: MapId(Uuid::nil()) }));
        assert_eq!((usage.use_of(map), usage.is_mapping()), (Some(MapUse::Extension), true));
        usage.update(&Publication::Mapping(MappingState::Idle));
        assert_eq!((usage.use_of(map), usage.is_mapping()), (None, false));
        let upload = UploadId(Uuid::from_u128(3));
        usage.begin_import(upload, vec![map]);
        assert_eq!((usage.use_of(map), usage.is_importing(upload)), (Some(MapUse::Import), true));
        usage.end_import();
        assert_eq!((usage.use_of(map), usage.is_importing(upload)), (None, false));
    }

    #[test]
    fn a_robot_is_idle_in_its_map_and_not_in_others_or_while_it_maps() {
        let [map, other] = [1, 2].map(|number| MapId(Uuid::from_u128(number)));
        let usage = MapUsage::new(Some(map));
        assert_eq!([map, other].map(|map| usage.is_idle_in(map)), [true, false]);
        let session = SessionId(Uuid::from_u128(3));
        usage.update(&Publication::Mapping(MappingState::Starting { session }));
        assert!(!usage.is_idle_in(map));
        usage.update(&Publication::Mapping(MappingState::Idle));
        assert!(usage.is_idle_in(map));
        let owner = Some(ClientId(Uuid::from_u128(4)));
        assert_eq!(usage.controlled_by(), None);
        usage.update(&Publication::Control(messages::ControlState { owner, name: String::new() }));
        assert_eq!(usage.controlled_by(), owner);
    }
}
