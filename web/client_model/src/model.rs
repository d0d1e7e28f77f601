//! The entrance of the model, and what views ask that concerns several slices.

use crate::features::Feature;
use crate::features::alignment::AlignmentDraft;
use crate::features::connection::Connection;
use crate::features::control::ControlLease;
use crate::features::history::LoopEdit;
use crate::features::loops::{LoopPick, ScanComparison};
use crate::features::map_view::MapView;
use crate::features::maps::SavedMaps;
use crate::features::missions::PlanConditions;
use crate::features::notices::Notices;
use crate::features::selection::{GraphTool, PointerMode, Selection};
use crate::features::view_settings::ViewFeature;
use crate::shared::{Context, Shared, SliceChange};
use crate::{
    ClientCommand, ClientEffect, ClientEvent, ClientTime, Ids, Model, Socket, StoredDraft, ViewSettings,
};
use api::{ClientIdentity, LeaseToken, Localisation, Mapping, Motion, Quality, Role, ServerMessage};
use site_model::NodeId;
use std::collections::BTreeSet;
use vocab::{MapId, Pose, Twist, Vec3};

impl Model {
    /// A client that has just been opened. [`Self::connect`] makes it connect.
    pub fn new(lease: LeaseToken, ids: Ids, view: ViewSettings, now: ClientTime) -> Self {
        let mut model = Self::compose(Shared::new(lease, ids, now));
        model.view = ViewFeature::new(view);
        model
    }

    /// Goes on with a draft of the site from an earlier visit.
    pub fn restore_draft(&mut self, stored: StoredDraft) {
        self.site.restore_draft(stored);
    }

    /// Opens both sockets; once, before the first event.
    pub fn connect(&mut self, effects: &mut Vec<ClientEffect>) {
        effects.extend([ClientEffect::OpenSocket(Socket::Control), ClientEffect::OpenSocket(Socket::Stream)]);
    }

    /// The only way to change the model. `now` is the only clock.
    pub fn handle_event(&mut self, now: ClientTime, event: ClientEvent, effects: &mut Vec<ClientEffect>) {
        self.shared.now = now;
        let mut changes = Vec::new();
        match &event {
            ClientEvent::Command(ClientCommand::Undo) => self.undo(effects, &mut changes),
            ClientEvent::Command(ClientCommand::Redo) => self.redo(effects, &mut changes),
            ClientEvent::Command(command) => {
                self.context(effects, &mut changes, |cx| cx.on_command(command));
                self.dispatch(effects, &mut changes, |feature, cx| feature.on_command(command, cx));
            }
            ClientEvent::Server { message, bytes } => {
                self.on_message(message, *bytes, effects, &mut changes);
            }
            other => {
                self.context(effects, &mut changes, |cx| cx.on_client_event(other));
                self.dispatch(effects, &mut changes, |feature, cx| feature.on_client_event(other, cx));
            }
        }
        self.dispatch(effects, &mut changes, |feature, cx| feature.after_event(cx));
        self.shared.map_views.plan(now, effects);
        let conditions = self.plan_conditions();
        self.missions.update(&self.site, &conditions);
        self.runs.update(&self.site, conditions.now);
        self.point_history.update(&self.site);
    }

    /// What plans of missions depend on besides the site.
    fn plan_conditions(&self) -> PlanConditions<'static> {
        let is_there = self.viewed_map().is_none() && self.is_site_on_screen();
        let estimate = self.robot.estimate.as_ref().filter(|_| is_there);
        PlanConditions {
            now: self.connection().clock().stamp_at(self.now()),
            robot: estimate.map(|estimate| estimate.value.map_from_base.position),
            forms: None,
        }
    }

    /// A message of the server. Only an event that follows the last one reaches the slices.
    fn on_message(
        &mut self,
        message: &ServerMessage,
        bytes: usize,
        effects: &mut Vec<ClientEffect>,
        changes: &mut Vec<SliceChange>,
    ) {
        let mut next = None;
        self.context(effects, changes, |cx| next = cx.on_message(message, bytes));
        if let Some(event) = next {
            let whole = match event {
                api::Event::GraphPart(part) => match self.shared.graph_parts.add(part) {
                    Some(graph) => Some(api::Event::Graph(graph)),
                    None => return,
                },
                _ => None,
            };
            let event = whole.as_ref().unwrap_or(event);
            self.context(effects, changes, |cx| cx.on_event(event));
            // Features see the event in the frame and session that it belongs to.
            self.dispatch_changes(effects, changes);
            self.dispatch(effects, changes, |feature, cx| feature.on_event(event, cx));
        }
    }

    /// Lets the shared slices work.
    fn context(
        &mut self,
        effects: &mut Vec<ClientEffect>,
        changes: &mut Vec<SliceChange>,
        work: impl FnOnce(&mut Context<'_>),
    ) {
        work(&mut Context { shared: &mut self.shared, effects, changes });
    }

    /// Lets every feature work, then tells all of them what changed.
    fn dispatch(
        &mut self,
        effects: &mut Vec<ClientEffect>,
        changes: &mut Vec<SliceChange>,
        mut work: impl FnMut(&mut dyn Feature, &mut Context<'_>),
    ) {
        self.for_each_feature(|feature, shared| work(feature, &mut Context { shared, effects, changes }));
        self.dispatch_changes(effects, changes);
    }

    fn dispatch_changes(&mut self, effects: &mut Vec<ClientEffect>, changes: &mut Vec<SliceChange>) {
        while !changes.is_empty() {
            for change in std::mem::take(changes) {
                self.for_each_feature(|feature, shared| {
                    feature.on_change(&change, &mut Context { shared, effects, changes });
                });
            }
        }
    }

    /// Takes back a part of something unfinished, or else the last step that can be. The view keeps fewer steps than the history.
    fn undo(&mut self, effects: &mut Vec<ClientEffect>, changes: &mut Vec<SliceChange>) {
        let mut done = false;
        self.for_each_feature(|feature, shared| {
            done = done || feature.undo_unfinished(&mut Context { shared, effects, changes });
        });
        while !done && let Some(step) = self.shared.history.take_last() {
            self.for_each_feature(|feature, shared| {
                done = done || feature.undo(step, &mut Context { shared, effects, changes });
            });
        }
        self.dispatch_changes(effects, changes);
    }

    fn redo(&mut self, effects: &mut Vec<ClientEffect>, changes: &mut Vec<SliceChange>) {
        let mut done = false;
        while !done && let Some(step) = self.shared.history.take_undone() {
            self.for_each_feature(|feature, shared| {
                done = done || feature.redo(step, &mut Context { shared, effects, changes });
            });
        }
        self.dispatch_changes(effects, changes);
    }

    /// Client time of the last event.
    pub fn now(&self) -> ClientTime {
        self.shared.now
    }

    /// The sockets, the server's clock and version.
    pub fn connection(&self) -> &Connection {
        &self.shared.connection
    }

    /// Whether state and commands flow.
    pub fn is_connected(&self) -> bool {
        self.shared.connection.is_connected()
    }

    /// Who this client is, as the server says; `None` before it has welcomed the client.
    pub fn you(&self) -> Option<&ClientIdentity> {
        self.shared.you.as_ref()
    }

    /// What this client calls itself to others.
    pub fn operator_name(&self) -> String {
        self.shared.operator_name()
    }

    /// Whether whoever has signed in may do what needs this role.
    pub fn may(&self, role: Role) -> bool {
        self.you().is_none_or(|you| you.role >= role)
    }

    /// Who controls the robot.
    pub fn control(&self) -> &ControlLease {
        &self.shared.control
    }

    /// Whether this client holds the control lease.
    pub fn has_control(&self) -> bool {
        self.shared.client().is_some_and(|client| self.shared.control.owner() == Some(client))
    }

    /// Somebody who asks this client for the control lease: the name, and the time in which this client can refuse, s.
    pub fn asked_for_control(&self) -> Option<(&str, f64)> {
        let control = &self.shared.control;
        let request = control.request().filter(|_| self.has_control())?;
        Some((&request.name, control.refusal_left_s(self.shared.now)))
    }

    /// Whether this client asks another one for the control lease.
    pub fn asks_for_control(&self) -> bool {
        let by = self.shared.control.request().map(|request| request.by);
        by.is_some() && by == self.shared.client()
    }

    /// Whether another client holds the control lease.
    pub fn is_controlled_by_other(&self) -> bool {
        self.shared.is_controlled_by_other()
    }

    /// Whether commands that need the control lease make sense now: connected, no other client holds the lease, and the role allows them.
    pub fn can_command(&self) -> bool {
        self.is_connected() && !self.is_controlled_by_other() && self.may(Role::Operator)
    }

    /// Whether a command of this kind has not been answered yet.
    pub fn is_pending(&self, matches: impl Fn(&api::Command) -> bool) -> bool {
        self.shared.commands.is_pending(matches)
    }

    /// Sentences on show.
    pub fn notices(&self) -> &Notices {
        &self.shared.notices
    }

    /// Saved maps and their docks.
    pub fn maps(&self) -> &SavedMaps {
        &self.shared.maps
    }

    /// The map under construction.
    pub fn live_map(&self) -> &MapView {
        self.shared.map_views.live()
    }

    /// The saved map that is viewed.
    pub fn saved_map(&self) -> Option<(MapId, &MapView)> {
        self.shared.map_views.saved()
    }

    /// The map on the screen: the saved one that is viewed, else the one under construction.
    pub fn displayed_map(&self) -> &MapView {
        self.shared.map_views.displayed()
    }

    /// The id of the saved map that is viewed.
    pub fn viewed_map(&self) -> Option<MapId> {
        self.shared.map_views.viewed()
    }

    /// Whether a robot measured the keyframes and edges of the displayed map. Those of an imported point cloud are virtual viewpoints, which
    /// would only hide the map.
    pub fn has_pose_graph(&self) -> bool {
        let displayed = self.viewed_map().or_else(|| self.localisation().map());
        displayed.and_then(|map| self.maps().get(map)).is_none_or(|map| map.has_pose_graph)
    }

    /// Docks of the map on the screen: the pose of the base while it is charged.
    pub fn docks(&self) -> impl Iterator<Item = &Pose> {
        let map = self.viewed_map().or(self.localisation().map());
        self.maps().docks_of(map)
    }

    /// What is selected.
    pub fn selection(&self) -> Option<Selection> {
        self.shared.selected.selection
    }

    /// The nodes of the topological map that are selected: one, or several together.
    pub fn selected_nodes(&self) -> BTreeSet<NodeId> {
        let mut nodes = self.shared.selected.nodes();
        nodes.retain(|node| self.site.site().is_some_and(|site| site.node(*node).is_some()));
        nodes
    }

    /// Whether the next click on the ground sets the goal of a walk.
    pub fn is_picking_goal(&self) -> bool {
        self.shared.selected.mode() == PointerMode::PickGoal
    }

    /// Whether the next drag on the ground sets the pose of the robot.
    pub fn is_picking_pose(&self) -> bool {
        self.shared.selected.mode() == PointerMode::PickPose
    }

    /// What a click in the scene does to the topological map; `None` while it does nothing.
    pub fn graph_tool(&self) -> Option<GraphTool> {
        match self.shared.selected.mode() {
            PointerMode::EditGraph(tool) => Some(tool),
            PointerMode::Select | PointerMode::PickGoal | PointerMode::PickPose => None,
        }
    }

    /// The saved map that is on the screen, or in which the robot is localised; `None` while there is none.
    pub fn saved_map_on_screen(&self) -> Option<MapId> {
        self.viewed_map().or_else(|| self.localisation().map())
    }

    /// Whether poses of the site are in the frame of the map on the screen.
    pub fn is_site_on_screen(&self) -> bool {
        let site_map = self.site.site().and_then(|site| site.settings()?.map);
        site_map.is_some()
            && site_map == self.saved_map_on_screen()
            && (self.viewed_map().is_some() || self.has_pose_in_map())
    }

    /// The path that the robot travelled, map frame, metres: of the mapping session, or since it was localised in the saved map.
    pub fn trajectory(&self) -> impl Iterator<Item = Vec3> {
        let mapping = self.localisation().map().is_none();
        self.trajectory.positions(if mapping { &self.live_map().graph.nodes } else { &[] })
    }

    /// Grows with every change of [`Self::trajectory`].
    pub fn trajectory_revision(&self) -> u64 {
        self.trajectory.revision()
    }

    /// State of the mapping session.
    pub fn mapping(&self) -> &Mapping {
        self.mapping.state()
    }

    /// State of localisation in a saved map.
    pub fn localisation(&self) -> Localisation {
        self.localisation.state()
    }

    /// Whether the robot's pose means anything in the map on the screen: not before it was localised in a saved one.
    pub fn has_pose_in_map(&self) -> bool {
        self.localisation.has_pose()
    }

    /// State of motion; idle before the robot reported.
    pub fn motion(&self) -> &Motion {
        self.robot.motion.as_ref().map_or(&Motion::Idle, |motion| &motion.value)
    }

    /// Whether motion has been stopped and not allowed again.
    pub fn is_stopped(&self) -> bool {
        matches!(self.motion(), Motion::Stopped { .. })
    }

    /// Seconds since the robot made its last pose estimate, if its clock is known; else since the estimate arrived.
    pub fn data_age_s(&self) -> Option<f64> {
        let estimate = self.robot.estimate.as_ref()?;
        let travelled = self.connection().clock().age_of(estimate.value.stamp, self.now()).unwrap_or(0.0);
        Some(estimate.age(self.now()).max(travelled))
    }

    /// The velocity that the operator commands by hand; `None` while joystick and keys are released.
    pub fn driven_velocity(&self) -> Option<Twist> {
        self.driving.velocity()
    }

    /// How far adding a loop by hand has come; `None` while nobody does.
    pub fn loop_pick(&self) -> Option<LoopPick> {
        self.loops.pick()
    }

    /// The decision on a loop that [`ClientCommand::UndoLoop`] would take back.
    pub fn last_loop_edit(&self) -> Option<&LoopEdit> {
        self.shared.history.last_loop()
    }

    /// The two scans to lay over each other now: those of the selected loop, or of the two keyframes chosen for a new one. `None`
    /// without such a pair, if the overlay is off, or while a saved map is viewed.
    pub fn scan_comparison(&self) -> Option<ScanComparison> {
        self.loops.comparison(&self.shared)
    }

    /// Pose of the newer keyframe in the older one from which a comparison would start; `None` if the graph lacks one of them.
    pub fn loop_initial_guess(&self, pair: crate::LoopPair, guess: crate::LoopInitialGuess) -> Option<Pose> {
        crate::features::loops::initial_guess(self.live_map(), pair, guess)
    }

    /// How far the scan of a keyframe of the live map has come; `None` while it is not wanted.
    pub fn cloud(&self, keyframe: vocab::KeyframeId) -> Option<&crate::CloudState> {
        self.loops.cloud(self.live_map().graph.session?, keyframe)
    }

    /// Quality of the map under construction.
    pub fn quality(&self) -> &Quality {
        self.quality.quality()
    }

    /// The alignment of two saved maps that the operator prepares; `None` while nobody does.
    pub fn alignment(&self) -> Option<&AlignmentDraft> {
        self.alignment.current()
    }

    /// How things look.
    pub fn view_settings(&self) -> &ViewSettings {
        self.view.settings()
    }
}
