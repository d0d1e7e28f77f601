//! A stack without sensors, with a site of two nodes, for the tests of this folder.

use super::goal_request;
use crate::{Running, Stack};
use geometry::Isometry;
use messages::{
    BootRecord, Command, CommandKind, GoalKind, GoalStatus, GoalUpdate, Input, LedgerEvent, Principal,
    Publication, RobotProfile, SiteSnapshot, StackEffect, TICK_PERIOD,
};
use site_model::{Edge, EdgeBlock, EdgeId, EditId, Node, NodeId, NodeKind, Object, PoseTolerance};
use uuid::Uuid;
use vocab::{ClientId, CommandId, GoalId, Pose, Span, Stamp, Vec3};

/// Node 1 is where the robot stands, and node 2 is 10 m ahead of it.
pub(super) fn node_id(number: u128) -> NodeId {
    NodeId(Uuid::from_u128(number))
}

pub(super) fn goal_id(number: u128) -> GoalId {
    GoalId(Uuid::from_u128(number))
}

pub(super) fn client(number: u128) -> Principal {
    Principal::operator(ClientId(Uuid::from_u128(number)))
}

/// The edge from node 1 to node 2.
pub(super) const AHEAD: EdgeId = EdgeId(Uuid::from_u128(12));

fn node(number: u128, x_m: f64) -> Object {
    Object::Node(Node {
        id: node_id(number),
        name: format!("N{number}"),
        kind: NodeKind::Waypoint,
        map_from_node: Pose { position: Vec3::new(x_m, 0.0, 0.0), ..Pose::IDENTITY },
        anchor: None,
        tolerance: PoseTolerance::default(),
        influence_area_m: Vec::new(),
        floor: 0,
        tags: [].into(),
        properties: [].into(),
    })
}

pub(super) struct Rig {
    pub stack: Stack,
    pub at: Stamp,
    /// Every update of a goal.
    pub updates: Vec<GoalUpdate>,
    /// All other effects.
    pub effects: Vec<StackEffect>,
    commands: u128,
    /// The newest commit that is durable.
    committed: Option<u64>,
}

impl Rig {
    /// After the boot record.
    pub fn booted() -> Self {
        let mut rig = Self {
            stack: Stack::new(),
            at: Stamp::EPOCH,
            updates: Vec::new(),
            effects: Vec::new(),
            commands: 0,
            committed: None,
        };
        let profile = RobotProfile { standing_height_m: 0.5, ..RobotProfile::default() };
        rig.step(Input::Boot(Box::new(BootRecord { profile, ..BootRecord::default() })));
        rig
    }

    /// After the boot record and the site.
    pub fn new() -> Self {
        let mut rig = Self::booted();
        let edge = Object::Edge(Edge::walk(AHEAD, node_id(1), node_id(2)));
        rig.give_objects(vec![node(1, 0.0), node(2, 10.0), edge]);
        rig.run(0.3);
        rig
    }

    /// Puts objects into the site, which the stack then gets anew.
    pub fn give_objects(&mut self, objects: Vec<Object>) {
        let mut site = self.running().missions.site.as_ref().clone();
        for object in objects {
            let id = EditId(Uuid::nil());
            let edit = site.put(id, object);
            assert!(site.apply(&edit, id).is_ok());
        }
        let objects = site.objects().cloned().collect();
        self.step(Input::Site(Box::new(SiteSnapshot { objects, removed: Vec::new() })));
    }

    /// The edge to node 2 is blocked for this time.
    pub fn block(&mut self, seconds: f64) {
        let until = self.at + Span::from_secs_f64(seconds);
        let block = EdgeBlock { edge: AHEAD, until, failures: 1, reason: "A pallet.".to_owned() };
        self.give_objects(vec![Object::EdgeBlock(block)]);
    }

    /// The pose in the map of the site is this from now until the next tick, or is not known.
    pub fn look_at_place(&mut self, map_from_base: Option<Pose>) {
        let (at, mut effects) = (self.at, Vec::new());
        self.running().look_at_place(at, map_from_base, &mut effects);
        self.handle_effects(effects);
    }

    /// The robot is seen at node 1.
    pub fn stand_at_first_node(&mut self) {
        self.look_at_place(Some(Pose::IDENTITY));
        self.run(0.3);
        assert_eq!(self.running().missions.place().at, Some(node_id(1)));
    }

    /// Every commit becomes durable. Returns whether there was one.
    pub fn commit_all(&mut self) -> bool {
        let newest = self.effects.iter().rev().find_map(|effect| match effect {
            StackEffect::Commit { seq, .. } => Some(*seq),
            _ => None,
        });
        let Some(seq) = newest.filter(|seq| self.committed.is_none_or(|committed| *seq > committed)) else {
            return false;
        };
        self.committed = Some(seq);
        self.step(Input::Committed { seq });
        true
    }

    /// What the stack wants to write to the ledger, in its order.
    pub fn ledger_events(&self) -> impl Iterator<Item = &LedgerEvent> {
        let commits = self.effects.iter().filter_map(|effect| match effect {
            StackEffect::Commit { events, .. } => Some(events),
            _ => None,
        });
        commits.flatten()
    }

    pub fn running(&mut self) -> &mut Running {
        self.stack.running.as_mut().unwrap_or_else(|| panic!("no boot record"))
    }

    pub fn step(&mut self, input: Input) {
        let mut effects = Vec::new();
        self.stack.step(self.at, input, &mut effects);
        self.handle_effects(effects);
    }

    fn handle_effects(&mut self, effects: Vec<StackEffect>) {
        for effect in effects {
            match effect {
                StackEffect::Publish(Publication::Goal(update)) => self.updates.push(update),
                effect => self.effects.push(effect),
            }
        }
    }

    pub fn run(&mut self, seconds: f64) {
        let until = self.at + Span::from_secs_f64(seconds);
        while self.at < until {
            self.at += TICK_PERIOD;
            self.step(Input::Tick);
        }
    }

    /// A command of a client. Returns why it was refused, if it was.
    pub fn command(&mut self, by: u128, kind: CommandKind) -> Option<String> {
        self.commands += 1;
        let id = CommandId(Uuid::from_u128(self.commands));
        self.step(Input::Command(Command { id, by: client(by), kind }));
        self.effects.iter().rev().find_map(|effect| match effect {
            StackEffect::Answer { id: answered, refused, .. } if *answered == id => refused.clone(),
            _ => None,
        })
    }

    /// Client 1 asks for a goal on the topological map. That the robot is localised is not asked for.
    pub fn begin(&mut self, number: u128, kind: GoalKind) -> Result<(), String> {
        let Some(request) = goal_request(kind) else { panic!("not on the topological map") };
        let (at, mut effects) = (self.at, Vec::new());
        let begun = self.running().begin_route(at, (goal_id(number), kind, client(1)), request, &mut effects);
        self.handle_effects(effects);
        begun
    }

    /// Every outcome of a goal.
    pub fn outcomes(&self, number: u128) -> Vec<&GoalStatus> {
        let updates = self.updates.iter().filter(|update| update.id == goal_id(number));
        updates.map(|update| &update.status).filter(|status| status.is_outcome()).collect()
    }

    /// The robot sees a level floor.
    pub fn see_floor(&mut self) {
        let points: Vec<[f32; 3]> = (-40..=40_i8)
            .flat_map(|x| (-40..=40_i8).map(move |y| [0.1 * f32::from(x), 0.1 * f32::from(y), -0.5]))
            .collect();
        let at = self.at;
        let surroundings = self.running().executive.surroundings();
        surroundings.insert_scan(at, &Isometry::identity(), [0.0; 3], &points);
    }
}
