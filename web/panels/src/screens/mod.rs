//! The screens of the page, a folder each: what the rail and the side card show of it, texts by key.
//!
//! # A new screen
//!
//! 1. A folder here with a [`ScreenDescription`].
//! 2. Two lines in this file: its `mod`, and its entry in the list at the end. Its button on the rail, its side card and the tests of the
//!    frame follow from the entry.
//!
//! Panels appear on a screen by naming its constant in a [`Tab`](crate::feature_panel::Tab).

mod live;
mod map;
mod missions;
mod runs;
mod schedule;
mod settings;
mod site;

use client_model::Screen;

/// What the frame shows of a screen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScreenDescription {
    /// Text of its button on the rail. Unique.
    pub(crate) name: &'static str,
    /// Icon of that button.
    pub(crate) icon: &'static str,
    /// Name of its side card in the accessible tree.
    pub(crate) side_card: &'static str,
}

/// Makes the constants of the listed screens, [`SCREENS`] and [`FIRST`].
macro_rules! screens_of {
    ($(#[$first_doc:meta])* $first:ident: $first_folder:ident, $($(#[$doc:meta])* $id:ident: $folder:ident,)*) => {
        $(#[$first_doc])*
        pub(crate) const $first: Screen = Screen(stringify!($first_folder));
        $($(#[$doc])* pub(crate) const $id: Screen = Screen(stringify!($folder));)*

        /// The screen that is shown until the operator chooses one.
        pub(crate) const FIRST: Screen = $first;

        /// All screens, in the order of the rail.
        pub(crate) const SCREENS: &[(Screen, ScreenDescription)] =
            &[($first, $first_folder::DESCRIPTION), $(($id, $folder::DESCRIPTION),)*];
    };
}

// The order is that of the rail. The first screen is shown when the page opens.
screens_of! {
    /// The robot now.
    LIVE: live,
    /// Making and viewing maps.
    MAP: map,
    /// The topological map.
    SITE: site,
    /// Lists of tasks.
    MISSIONS: missions,
    /// When missions run.
    SCHEDULE: schedule,
    /// Runs of missions.
    RUNS: runs,
    /// What holds for the whole site.
    SETTINGS: settings,
}

/// Whether a card of the screen lies over the whole scene.
pub(crate) fn covers_scene(screen: Screen) -> bool {
    [SCHEDULE].contains(&screen)
}

/// The description of a screen; that of the first one where there is no such screen.
pub(crate) fn description_of(screen: Screen) -> ScreenDescription {
    let described = SCREENS.iter().find(|(listed, _)| *listed == screen).unwrap_or(&SCREENS[0]);
    described.1
}
