//! The features of the client, a folder each: state, reducer and tests.
//!
//! # A new feature
//!
//! 1. A folder here with a state that implements [`Feature`], `Default` and `Debug`, and its tests.
//! 2. Two lines in this file: its `mod`, and its entry in the list at the end. The field of [`Model`](crate::Model) and all dispatch
//!    follow from the entry. A macro could make the `mod` from the entry too, but `rustfmt` does not find a module that a macro declares.
//! 3. Its panel: a folder of the same name in `web/panels/src/features`, and the same two lines in the `mod.rs` there.
//!
//! Each of these needs a line more, where the feature has it: something that operators ask for is a variant of
//! [`ClientCommand`](crate::ClientCommand); a type that panels name is exported by `lib.rs`; a step that can be undone is a variant of
//! `HistoryStep`; a change that other features follow is a variant of [`Change`]; a screen of its own is a folder and two lines in
//! `web/panels/src/screens`.
//!
//! # Where the reducers are
//!
//! - The reducer of a feature in the list is its `impl Feature`, in the `mod.rs` of its folder.
//! - Folders that the list does not name are slices of [`Shared`](crate::shared::Shared), because the features depend on them. An event
//!   reaches them before the features. `shared_reducers` says which slice reacts to which event:
//!   - `connection` and `map_view` have a `reducer.rs`;
//!   - `control`, `commands`, `history`, `maps`, `notices` and `selection` hold state with methods that change it. `shared_reducers`, the
//!     methods of [`Context`] and features call them.

pub(crate) mod account;
pub(crate) mod alignment;
pub(crate) mod changes_view;
pub(crate) mod commands;
pub(crate) mod connection;
pub(crate) mod control;
pub(crate) mod driving;
pub(crate) mod example;
pub(crate) mod goals;
pub(crate) mod history;
pub(crate) mod imports;
pub(crate) mod interrupted_sessions;
pub(crate) mod localisation;
pub(crate) mod loops;
pub(crate) mod map_management;
pub(crate) mod map_view;
pub(crate) mod mapping;
pub(crate) mod maps;
pub(crate) mod missions;
pub(crate) mod notices;
pub(crate) mod platform;
pub(crate) mod point_history;
pub(crate) mod quality;
pub(crate) mod robot;
pub(crate) mod runs;
pub(crate) mod schedule;
pub(crate) mod selection;
pub(crate) mod site;
pub(crate) mod trajectory;
pub(crate) mod view_settings;

use crate::shared::{Context, Shared, SliceChange};
use crate::{ClientCommand, ClientEvent};
use history::HistoryStep;

/// A slice of the client's state with its reducer. Every method has a default that does nothing.
pub(crate) trait Feature {
    /// The server sent an event.
    fn on_event(&mut self, _event: &api::Event, _cx: &mut Context<'_>) {}

    /// Something happened on the client: a download or an upload went on, time passed.
    fn on_client_event(&mut self, _event: &ClientEvent, _cx: &mut Context<'_>) {}

    /// The operator asks for something.
    fn on_command(&mut self, _command: &ClientCommand, _cx: &mut Context<'_>) {}

    /// Another slice changed.
    fn on_change(&mut self, _change: &SliceChange, _cx: &mut Context<'_>) {}

    /// Called once after everything that an event led to, for effects that depend on several slices.
    fn after_event(&mut self, _cx: &mut Context<'_>) {}

    /// Takes back a part of something unfinished, before the history is asked. Returns whether there was any.
    fn undo_unfinished(&mut self, _cx: &mut Context<'_>) -> bool {
        false
    }

    /// Undoes a step of the history and records it as undone. Returns whether something was undone.
    fn undo(&mut self, _step: HistoryStep, _cx: &mut Context<'_>) -> bool {
        false
    }

    /// Does an undone step again and records it. Returns whether something was done.
    fn redo(&mut self, _step: HistoryStep, _cx: &mut Context<'_>) -> bool {
        false
    }
}

/// Makes [`Model`] of the shared slices and the listed features.
macro_rules! model_of {
    ($($(#[$doc:meta])* $name:ident: $state:ty,)*) => {
        /// Everything the client knows: shared slices, and a slice for each feature.
        #[derive(Debug)]
        pub struct Model {
            pub(crate) shared: Shared,
            $($(#[$doc])* pub $name: $state,)*
        }

        impl Model {
            /// All features in their first state.
            pub(crate) fn compose(shared: Shared) -> Self {
                Self { shared, $($name: Default::default(),)* }
            }

            /// Calls `visit` for every feature, in the order of the list.
            pub(crate) fn for_each_feature(
                &mut self,
                mut visit: impl FnMut(&mut dyn Feature, &mut Shared),
            ) {
                $(visit(&mut self.$name, &mut self.shared);)*
            }
        }
    };
}

model_of! {
    /// The account that has signed in.
    account: account::AccountFeature,
    /// What the robot last reported of itself.
    robot: robot::RobotTelemetry,
    /// The robot's computer.
    platform: platform::PlatformFeature,
    /// The path that the robot travelled.
    trajectory: trajectory::Trajectory,
    /// The mapping session.
    mapping: mapping::MappingFeature,
    /// Mapping sessions that were interrupted.
    interrupted_sessions: interrupted_sessions::InterruptedSessions,
    /// Localisation in a saved map.
    localisation: localisation::LocalisationFeature,
    /// Driving by hand and stopping.
    driving: driving::Driving,
    /// Goals and their outcomes.
    goals: goals::Goals,
    /// Loops of the map under construction.
    loops: loops::Loops,
    /// The documents of the site.
    site: site::SiteFeature,
    /// How changes of the scene are shown.
    changes_view: changes_view::ChangesView,
    /// The mission that is edited.
    missions: missions::MissionEditor,
    /// Runs of missions.
    runs: runs::Runs,
    /// The history of an inspection point.
    point_history: point_history::PointHistory,
    /// Schedules, as the operator works on them.
    schedule: schedule::ScheduleFeature,
    /// Quality of the map under construction.
    quality: quality::QualityFeature,
    /// Aligning one saved map to another.
    alignment: alignment::AlignmentFeature,
    /// Renaming, deleting and restoring saved maps.
    map_management: map_management::MapManagement,
    /// Maps made of point clouds.
    imports: imports::Imports,
    /// The example, a site to try.
    example: example::ExampleFeature,
    /// How things look.
    view: view_settings::ViewFeature,
}
