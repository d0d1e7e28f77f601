//! The model and its one entrance.

mod decide;
mod hear;
mod obey;

use crate::compare::Clouds;
use crate::history::History;
use crate::pending::PendingCommand;
use crate::{
    Aged, Align, ClientEffect, ClientEvent, ClientTime, Drive, Ids, Link, LoopEdit, LoopInitialGuess,
    LoopPair, LoopPick, LoopProposal, Loops, MapView, Notices, ScanOverlay, Screen, ServerClock, Socket,
    Throughput, Trajectory, Undo, Upload, ViewSettings, Viewpoint,
};
use api::{
    Battery, ClientMessage, Command, Control, Dock, Estimate, Health, Import, Localisation, MapSummary,
    Mapping, Motion, Platform, Quality, Severity, StreamRequest,
};
use vocab::{ClientId, KeyframeId, MapId, Pose, Stamp, Twist, Vec3};

/// Something selected in the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection {
    /// The robot.
    Robot,
    /// A keyframe of the map on show.
    Keyframe(KeyframeId),
    /// A loop of the map being made.
    Loop(LoopPair),
}

/// What the robot last said of itself. Values stay when the link is lost; their ages tell.
#[derive(Clone, Debug, Default)]
pub struct Robot {
    /// Where it is.
    pub estimate: Option<Aged<Estimate>>,
    /// Its battery.
    pub battery: Option<Aged<Battery>>,
    /// Its sensors.
    pub health: Option<Aged<Health>>,
    /// How it moves.
    pub motion: Option<Aged<Motion>>,
    /// What moves it.
    pub executive: Option<Aged<api::Executive>>,
    /// Its newest goals with their outcomes, the newest first.
    pub goals: Vec<api::Goal>,
    /// The last live scan, without its points: stamp and points.
    pub scan: Option<Aged<Stamp>>,
}

/// Everything the client knows.
#[derive(Debug)]
pub struct Model {
    /// This client, kept over reconnections.
    pub client: ClientId,
    /// The socket for state and commands.
    pub link: Link,
    /// The socket for live scans.
    pub stream: Link,
    /// Bytes coming in, all ways.
    pub throughput: Throughput,
    /// The robot's clock.
    pub clock: ServerClock,
    /// Version of the server's program.
    pub program: String,
    /// The robot.
    pub robot: Robot,
    /// Who controls.
    pub control: Control,
    /// State of mapping.
    pub mapping: Mapping,
    /// State of localisation in a saved map.
    pub localisation: Localisation,
    /// Whether the robot has known its place in that map since this client listens.
    pub(crate) placed: bool,
    /// The server itself.
    pub platform: Option<Aged<Platform>>,
    /// The map being made.
    pub live: MapView,
    /// How good the map being made is.
    pub quality: Quality,
    /// What was decided on loops of the map being made.
    pub loops: Loops,
    /// How far adding a loop by hand has come; `None` while nobody does.
    pub loop_pick: Option<LoopPick>,
    /// Where the newer keyframe of the loop that is added is guessed to be.
    pub loop_guess: LoopInitialGuess,
    /// The loop that was proposed here and is being compared.
    pub proposed: Option<LoopProposal>,
    /// How the scans of the selected loop are laid over each other.
    pub overlay: ScanOverlay,
    pub(crate) clouds: Clouds,
    /// The saved map being looked at.
    pub saved: Option<(MapId, MapView)>,
    /// Where the robot walked.
    pub track: Trajectory,
    /// Saved maps, newest first; `None` before the server told.
    pub maps: Option<Vec<MapSummary>>,
    /// The point cloud that this client is sending.
    pub upload: Option<Upload>,
    /// The saved map whose frame the file that is being chosen is to have.
    pub(crate) import_frame: Option<MapId>,
    /// What becomes of the last point cloud that anybody sent.
    pub import: Import,
    /// How far laying one saved map into the frame of another has come; `None` while nobody does.
    pub align: Option<Align>,
    /// Docks of all saved maps.
    pub(crate) docks: Vec<Dock>,
    /// Sentences on show.
    pub notices: Notices,
    /// How things look.
    pub view: Undo<ViewSettings>,
    history: History,
    /// Which screen is on.
    pub screen: Screen,
    /// What is selected.
    pub selection: Option<Selection>,
    /// Whether the next click on the ground says where to walk.
    pub walk_armed: bool,
    /// Whether the next drag on the ground says where the robot stands.
    pub place_armed: bool,
    /// The hand on the stick.
    pub drive: Drive,
    pub(crate) pending: Vec<PendingCommand>,
    /// Notices that came before the robot's clock was known.
    unread: Vec<api::Notice>,
    /// Client time of the last event.
    pub now: ClientTime,
    pub(crate) ids: Ids,
    sequence: u64,
    pinged: Option<ClientTime>,
    pings: u64,
    eye: Option<Viewpoint>,
    planned: ClientTime,
    ticked: ClientTime,
}

const PING_PERIOD_S: f64 = 2.0;
/// Planning tiles looks at all of them: often enough to feel immediate, seldom enough to cost nothing.
const PLAN_PERIOD_S: f64 = 0.25;
/// Ticks farther apart than this mean that the page stood still: a slow machine, a hidden tab, a sleeping tablet.
const STALL_S: f64 = 1.0;
/// Scans per second asked for.
const SCAN_HZ: f32 = 10.0;

impl Model {
    /// A client that has just been opened. [`Self::connect`] makes it connect.
    pub fn new(client: ClientId, ids: Ids, view: ViewSettings, now: ClientTime) -> Self {
        Self {
            client,
            link: Link::new(now),
            stream: Link::new(now),
            throughput: Throughput::default(),
            clock: ServerClock::default(),
            program: String::new(),
            robot: Robot::default(),
            control: Control::default(),
            mapping: Mapping::Idle,
            localisation: Localisation::Idle,
            placed: false,
            platform: None,
            live: MapView::live(),
            quality: Quality::default(),
            loops: Loops::default(),
            loop_pick: None,
            loop_guess: LoopInitialGuess::default(),
            proposed: None,
            overlay: ScanOverlay::default(),
            clouds: Clouds::default(),
            saved: None,
            track: Trajectory::default(),
            maps: None,
            upload: None,
            import_frame: None,
            import: Import::None,
            align: None,
            docks: Vec::new(),
            notices: Notices::default(),
            view: Undo::new(view),
            history: History::default(),
            screen: Screen::Live,
            selection: None,
            walk_armed: false,
            place_armed: false,
            drive: Drive::default(),
            pending: Vec::new(),
            unread: Vec::new(),
            now,
            ids,
            sequence: 0,
            pinged: None,
            pings: 0,
            eye: None,
            planned: ClientTime(f64::NEG_INFINITY),
            ticked: now,
        }
    }

    /// The way the robot came, map frame, metres: all of the mapping session, or since it found itself in the saved map in use.
    pub fn trajectory(&self) -> impl Iterator<Item = Vec3> {
        let walked_now = self.localisation.map().is_none();
        self.track.positions(if walked_now { &self.live.graph.nodes } else { &[] })
    }

    /// Opens both sockets; once, before the first event.
    pub fn connect(&mut self, effects: &mut Vec<ClientEffect>) {
        effects.extend([ClientEffect::OpenSocket(Socket::Control), ClientEffect::OpenSocket(Socket::Stream)]);
    }

    /// The only way in. `now` is the only clock.
    pub fn handle_event(&mut self, now: ClientTime, event: ClientEvent, effects: &mut Vec<ClientEffect>) {
        self.now = now;
        match event {
            ClientEvent::SocketOpened(socket) => self.opened(socket, effects),
            ClientEvent::SocketClosed { socket, jitter } => self.closed(socket, jitter),
            ClientEvent::Server { message, bytes } => {
                self.link.hear(now);
                self.throughput.add(now, bytes);
                self.hear(message, effects);
            }
            ClientEvent::DecodeFailed { socket } => self.unreadable(socket, effects),
            ClientEvent::Scan { frame, bytes } => self.scan(&frame, bytes),
            ClientEvent::TilesListed { map, result } => self.tiles_listed(map, result, effects),
            ClientEvent::GraphLoaded { map, result } => self.graph_loaded(map, result),
            ClientEvent::TileReady { hash, bytes } => {
                self.throughput.add(now, bytes);
                if !self.displayed_map_mut().tiles.arrive(&hash) {
                    effects.push(ClientEffect::RemoveTile(hash));
                }
            }
            ClientEvent::TileFailed { hash } => self.displayed_map_mut().tiles.fail(&hash, now),
            ClientEvent::CloudFetched { session, keyframe, result } => {
                self.clouds.arrive(session, keyframe, result)
            }
            ClientEvent::UploadStarted { upload, file } => self.upload_begun(upload, file),
            ClientEvent::UploadProgress { upload, share } => self.uploading(upload, share),
            ClientEvent::UploadFinished { upload, result } => self.uploaded(upload, result, effects),
            ClientEvent::ViewpointChanged(eye) => {
                if self.eye != Some(eye) {
                    self.eye = Some(eye);
                    self.displayed_map_mut().tiles.mark_dirty();
                }
            }
            ClientEvent::Command(command) => self.obey(command, effects),
            ClientEvent::Tick => self.tick(effects),
        }
        self.follow_comparison(effects);
        self.plan(effects);
    }

    /// Grows with every change of [`Self::trajectory`].
    pub fn trajectory_revision(&self) -> u64 {
        self.track.revision()
    }

    /// How things look.
    pub fn view_settings(&self) -> &ViewSettings {
        self.view.get()
    }

    /// The velocity that the operator commands by hand; `None` while stick and keys are released.
    pub fn driven_velocity(&self) -> Option<Twist> {
        self.drive.wanted()
    }

    /// The alignment of two saved maps that the operator prepares; `None` while nobody does.
    pub fn alignment(&self) -> Option<&Align> {
        self.align.as_ref()
    }

    /// How far adding a loop by hand has come; `None` while nobody does.
    pub fn loop_pick(&self) -> Option<LoopPick> {
        self.loop_pick
    }

    /// Quality of the map under construction.
    pub fn quality(&self) -> &Quality {
        &self.quality
    }

    /// What is selected.
    pub fn selection(&self) -> Option<Selection> {
        self.selection
    }

    /// Whether the next click on the ground sets the goal of a walk.
    pub fn is_picking_goal(&self) -> bool {
        self.walk_armed
    }

    /// Whether the next drag on the ground sets the pose of the robot.
    pub fn is_picking_pose(&self) -> bool {
        self.place_armed
    }

    /// The decision on a loop that [`crate::ClientCommand::UndoLoop`] would take back.
    pub fn last_loop_step(&self) -> Option<&LoopEdit> {
        self.history.last_loop()
    }

    /// The map on the screen: the saved one being looked at, else the one being made.
    pub fn displayed_map(&self) -> &MapView {
        self.saved.as_ref().map_or(&self.live, |(_, map)| map)
    }

    fn displayed_map_mut(&mut self) -> &mut MapView {
        self.saved.as_mut().map_or(&mut self.live, |(_, map)| map)
    }

    /// The saved map being looked at.
    pub fn viewed_map(&self) -> Option<MapId> {
        self.saved.as_ref().map(|(id, _)| *id)
    }

    /// Docks of the map on show, each the base there while it is charged.
    pub fn docks(&self) -> impl Iterator<Item = &Pose> {
        let map = self.viewed_map().or(self.localisation.map());
        self.docks.iter().filter(move |dock| Some(dock.map) == map).map(|dock| &dock.map_from_base)
    }

    /// Whether this client holds the control lease.
    pub fn has_control(&self) -> bool {
        self.control.owner == Some(self.client)
    }

    /// Whether somebody else holds the control lease.
    pub fn is_controlled_by_other(&self) -> bool {
        self.control.owner.is_some_and(|owner| owner != self.client)
    }

    /// Whether keyframes and edges of the displayed map were measured by a robot. Those of an imported point cloud are virtual viewpoints.
    pub fn has_pose_graph(&self) -> bool {
        let displayed = self.viewed_map().or_else(|| self.localisation.map());
        let summary = self.maps.iter().flatten().find(|summary| Some(summary.id) == displayed);
        summary.is_none_or(|summary| summary.has_pose_graph)
    }

    /// Whether where the robot is said to be means anything in the map on show: not before it has found itself in a saved one.
    pub fn has_pose_in_map(&self) -> bool {
        self.placed || self.localisation == Localisation::Idle
    }

    /// Whether motion has been stopped and not allowed again.
    pub fn is_stopped(&self) -> bool {
        matches!(self.motion(), Motion::Stopped { .. })
    }

    /// State of motion; idle before the robot spoke.
    pub fn motion(&self) -> &Motion {
        self.robot.motion.as_ref().map_or(&Motion::Idle, |motion| &motion.value)
    }

    /// Whether an order of this kind is on its way.
    pub fn is_pending(&self, matches: impl Fn(&Command) -> bool) -> bool {
        self.pending.iter().any(|pending| matches(&pending.order))
    }

    /// Seconds since the robot's own estimate of where it is was made, as well as can be known.
    pub fn data_age_s(&self) -> Option<f64> {
        let estimate = self.robot.estimate.as_ref()?;
        let travelled = self.clock.age_of(estimate.value.stamp, self.now).unwrap_or(0.0);
        Some(estimate.age(self.now).max(travelled))
    }

    /// What this client calls itself to the others.
    pub fn operator_name(&self) -> String {
        format!("Operator {:04x}", self.client.0.as_u128() & 0xffff)
    }

    fn opened(&mut self, socket: Socket, effects: &mut Vec<ClientEffect>) {
        match socket {
            Socket::Control => {
                effects.push(ClientEffect::Send(ClientMessage::Hello {
                    version: api::VERSION,
                    client: self.client,
                }));
            }
            Socket::Stream => {
                effects.push(ClientEffect::SendStream(StreamRequest::Open {
                    version: api::VERSION,
                    max_hz: SCAN_HZ,
                }));
                // The stream has no welcome: it is connected when it is open.
                self.stream.welcome(self.now);
            }
        }
    }

    fn closed(&mut self, socket: Socket, jitter: f64) {
        let now = self.now;
        match socket {
            Socket::Control => {
                self.link.lose(now, jitter);
                self.pinged = None;
            }
            Socket::Stream => self.stream.lose(now, jitter),
        }
    }

    fn unreadable(&mut self, socket: Socket, effects: &mut Vec<ClientEffect>) {
        if socket == Socket::Control {
            let text = "The server sent something this page cannot read. Reload the page; if that does not help, \
                        server and page are of different versions.";
            self.notices.add(self.now, Severity::Error, text.to_owned());
        }
        self.drop_link(socket, effects);
    }

    fn drop_link(&mut self, socket: Socket, effects: &mut Vec<ClientEffect>) {
        effects.push(ClientEffect::CloseSocket(socket));
        self.closed(socket, 0.5);
    }

    fn tick(&mut self, effects: &mut Vec<ClientEffect>) {
        self.notices.expire(self.now);
        self.give_up_proposal();
        self.throughput.expire(self.now);
        let stood_still = self.now.since(std::mem::replace(&mut self.ticked, self.now));
        if stood_still > STALL_S {
            self.link.excuse(stood_still);
            self.stream.excuse(stood_still);
        }
        for socket in [Socket::Control, Socket::Stream] {
            let now = self.now;
            if self.link_mut(socket).retry_due_or_dead(socket, now, effects) {
                self.closed(socket, 0.5);
            }
        }
        if self.link.connected() && self.pinged.is_none_or(|sent| self.now.since(sent) >= PING_PERIOD_S) {
            self.ping(effects);
        }
        if let Some(twist) = self.drive.due(self.now) {
            self.teleoperate(twist, effects);
        }
    }

    fn link_mut(&mut self, socket: Socket) -> &mut Link {
        match socket {
            Socket::Control => &mut self.link,
            Socket::Stream => &mut self.stream,
        }
    }

    fn ping(&mut self, effects: &mut Vec<ClientEffect>) {
        self.pings += 1;
        self.pinged = Some(self.now);
        effects.push(ClientEffect::Send(ClientMessage::Ping { token: self.pings }));
    }

    fn plan(&mut self, effects: &mut Vec<ClientEffect>) {
        let Some(eye) = self.eye else { return };
        let tiles = &self.displayed_map().tiles;
        if tiles.is_empty() || !tiles.plan_due(self.now) || self.now.since(self.planned) < PLAN_PERIOD_S {
            return;
        }
        self.planned = self.now;
        let now = self.now;
        self.displayed_map_mut().plan(&eye, now, effects);
    }

    /// Looks at a saved map, or at the live one. Whoever looks at a third one does not want to lay one onto another any more.
    pub(crate) fn view_map(&mut self, map: Option<MapId>, effects: &mut Vec<ClientEffect>) {
        self.align.take_if(|align| map != Some(align.map) && (map.is_none() || map != align.onto));
        if self.viewed_map() == map {
            return;
        }
        self.displayed_map_mut().tiles.unload(false, effects);
        self.selection = None;
        self.loop_pick = None;
        self.place_armed = false;
        self.saved = map.map(|id| (id, MapView::default()));
        self.displayed_map_mut().tiles.mark_dirty();
        if let Some(id) = map {
            effects.push(ClientEffect::LoadMap(id));
        }
    }
}

impl Link {
    /// Opens the socket if that is due; returns whether it must be counted as lost because it is silent.
    fn retry_due_or_dead(
        &mut self,
        socket: Socket,
        now: ClientTime,
        effects: &mut Vec<ClientEffect>,
    ) -> bool {
        if self.retry_due(now) {
            self.connect(now);
            effects.push(ClientEffect::OpenSocket(socket));
        }
        // Scans may rest; only the control socket is pinged.
        let dead = self.dead(now) && !(socket == Socket::Stream && self.connected());
        if dead {
            effects.push(ClientEffect::CloseSocket(socket));
        }
        dead
    }
}
