//! The panels of features, a folder each: panel, texts by key, tests. A folder has the name of its slice in `client_model` if it has
//! one.
//!
//! # A new panel
//!
//! 1. A folder here, with a struct that implements [`FeaturePanel`]. The struct holds what the panel keeps between frames.
//! 2. Two lines in this file: its `mod`, and its entry in the list at the end. Its field in [`FeaturePanels`] and all calls of the frame
//!    follow from the entry.
//!
//! A tab of its own is a [`Tab`](crate::feature_panel::Tab) that the panel returns: the side card shows every tab that a panel names.
//! `tabs` has those that several features share.
//!
//! Folders that the list does not name have no panel of their own: other panels and the top bar show them (control lease, imports,
//! quality, tasks of missions). `scene_labels` labels what several features show in the scene.

pub(crate) mod account;
pub(crate) mod action_form;
pub(crate) mod alerts;
pub(crate) mod alignment;
pub(crate) mod assets;
pub(crate) mod changes;
pub(crate) mod connection;
pub(crate) mod control;
pub(crate) mod driving;
pub(crate) mod example;
pub(crate) mod goals;
pub(crate) mod imports;
pub(crate) mod inspection_points;
pub(crate) mod interrupted_sessions;
pub(crate) mod localisation;
pub(crate) mod loops;
pub(crate) mod map_management;
pub(crate) mod map_view;
pub(crate) mod mapping;
pub(crate) mod maps;
pub(crate) mod mission_editor;
pub(crate) mod mission_list;
pub(crate) mod mission_palette;
pub(crate) mod mission_task;
pub(crate) mod monitors;
pub(crate) mod notices;
pub(crate) mod platform;
pub(crate) mod point_history;
pub(crate) mod quality;
pub(crate) mod robot;
pub(crate) mod runs;
pub(crate) mod scene_labels;
pub(crate) mod schedule;
pub(crate) mod selection;
pub(crate) mod sensors;
pub(crate) mod simulated_faults;
pub(crate) mod site_draft;
pub(crate) mod site_graph;
pub(crate) mod site_settings;
pub(crate) mod tabs;
pub(crate) mod view_settings;
pub(crate) mod zones;

use crate::feature_panel::FeaturePanel;

/// Makes [`FeaturePanels`] of the listed panels.
macro_rules! panels_of {
    ($($(#[$doc:meta])* $name:ident: $panel:ty,)*) => {
        /// The panels of all features, a field each.
        #[derive(Debug, Default)]
        pub(crate) struct FeaturePanels {
            $($(#[$doc])* pub(crate) $name: $panel,)*
        }

        impl FeaturePanels {
            /// All panels, in the order of the list.
            pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut dyn FeaturePanel> {
                [$(&mut self.$name as &mut dyn FeaturePanel,)*].into_iter()
            }
        }
    };
}

// The order is that of the messages at the top of the scene, of the tabs of a screen, and of the sections in a tab.
panels_of! {
    /// The view tools.
    view_settings: view_settings::ViewTools,
    /// The beginning of an empty site. Before the drive card, which gives way to it.
    example: example::ExamplePanel,
    /// Driving by hand.
    driving: driving::DrivingPanel,
    /// The connection to the robot.
    connection: connection::ConnectionPanel,
    /// The saved map that is viewed.
    map_view: map_view::MapViewPanel,
    /// Mapping sessions that were interrupted.
    interrupted_sessions: interrupted_sessions::InterruptedSessionsPanel,
    /// The mapping session.
    mapping: mapping::MappingPanel,
    /// Runs of missions.
    runs: runs::RunsPanel,
    /// The history of an inspection point.
    point_history: point_history::PointHistoryPanel,
    /// What has changed between visits.
    changes: changes::ChangesPanel,
    /// What a person has to look at.
    alerts: alerts::AlertsPanel,
    /// The robot's state.
    robot: robot::RobotPanel,
    /// Goals and their outcomes.
    goals: goals::GoalsPanel,
    /// Setting the robot's pose.
    localisation: localisation::LocalisationPanel,
    /// Sensors and their findings.
    sensors: sensors::SensorsPanel,
    /// Faults of a simulated robot.
    simulated_faults: simulated_faults::SimulatedFaultsPanel,
    /// The robot's computer.
    platform: platform::PlatformPanel,
    /// Somebody who asks for control.
    control: control::ControlPanel,
    /// The account that has signed in.
    account: account::AccountPanel,
    /// Loops of the map under construction.
    loops: loops::LoopsPanel,
    /// Aligning one saved map to another.
    alignment: alignment::AlignmentPanel,
    /// Saved maps.
    maps: maps::MapsPanel,
    /// The bin, and the undo of a deletion.
    map_management: map_management::MapManagementPanel,
    /// The topological map.
    site_graph: site_graph::SiteGraphPanel,
    /// What is looked at, from where.
    inspection_points: inspection_points::InspectionPointsPanel,
    /// The things that are inspected.
    assets: assets::AssetsPanel,
    /// Areas in which a rule holds.
    zones: zones::ZonesPanel,
    /// Edits that gather until they are published.
    site_draft: site_draft::SiteDraftPanel,
    /// Places and actions for missions.
    mission_palette: mission_palette::MissionPalette,
    /// The list of missions.
    mission_list: mission_list::MissionListPanel,
    /// The mission that is edited.
    mission_editor: mission_editor::MissionEditorPanel,
    /// When missions run.
    schedule: schedule::SchedulePanel,
    /// What holds for the whole site.
    site_settings: site_settings::SiteSettingsPanel,
    /// Conditions that are watched.
    monitors: monitors::MonitorsPanel,
    /// Notices.
    notices: notices::NoticesPanel,
    /// What is selected.
    selection: selection::SelectionPanel,
}
