//! What people want, carried out: orders to the robot under idempotent ids, changes of the view.

use super::Model;
use crate::history::Step;
use crate::pending::Pending;
use crate::{CameraMove, Changed, Command, Effect, LinkState, Socket, ViewSettings};
use api::{Order, Severity};
use vocab::{CommandId, Pose, Twist};

impl Model {
    pub(super) fn obey(&mut self, command: Command, effects: &mut Vec<Effect>) {
        match command {
            Command::Show(screen) => self.screen = screen,
            Command::StopMotion => self.stop_motion(effects),
            Command::AllowMotion => self.order_in_control(Order::AllowMotion, effects),
            Command::TakeControl => self.take_control(effects),
            Command::ReleaseControl => self.order(Order::ReleaseControl, effects),
            Command::StartMapping => {
                let session = self.ids.session();
                self.order_in_control(Order::StartMapping(session), effects);
            }
            Command::ExtendMap(map) => {
                let session = self.ids.session();
                self.order_in_control(Order::ExtendMap { session, map }, effects);
            }
            Command::UseMap(map) => self.order_in_control(Order::Localise { map, at: None }, effects),
            Command::ArmPlace(armed) => {
                self.place_armed = armed;
                self.walk_armed = false;
            }
            Command::PlaceRobot(place) => self.place_robot(place, effects),
            Command::PickMapFile { frame } => {
                self.import_frame = frame;
                effects.push(Effect::PickFile);
            }
            Command::Align { map, onto } => self.begin_align(map, onto, effects),
            Command::PickPoint(at) => self.pick_point(at, effects),
            Command::UnpickPoint => {
                self.take_point_back(effects);
            }
            Command::Lay => self.lay(effects),
            Command::CancelAlign => self.align = None,
            Command::CancelImport => self.cancel_import(effects),
            Command::Cause(mishap) => self.order(Order::Cause(mishap), effects),
            Command::LookAbout => self.order_in_control(Order::LookAbout, effects),
            Command::LeaveMap => self.order_in_control(Order::LeaveMap, effects),
            Command::FinishMapping { name } => {
                let map = self.ids.map();
                self.order_in_control(Order::FinishMapping { map, name: name.trim().to_owned() }, effects);
            }
            Command::DiscardMapping => self.order_in_control(Order::DiscardMapping, effects),
            Command::AcceptLoop(pair) => self.decide_loop(pair, true, effects),
            Command::RejectLoop(pair) => self.decide_loop(pair, false, effects),
            Command::UndoLoop => self.undo_loop(effects),
            Command::PickLoop(begin) => self.pick_loop(begin),
            Command::GuessLoop(guess) => self.loop_guess = guess,
            Command::ProposeLoop => self.propose_loop(effects),
            Command::Overlay(overlay) => self.overlay = overlay,
            Command::Drive(wanted) => {
                if let Some(twist) = self.drive.hold(self.now, wanted) {
                    self.teleoperate(twist, effects);
                }
            }
            Command::WalkTo(goal) => {
                self.walk_armed = false;
                self.order_in_control(Order::WalkTo(goal), effects);
            }
            // A velocity by hand ends a walk; none means: stand.
            Command::CancelWalk => self.order_in_control(Order::Teleoperate(Twist::default()), effects),
            Command::ArmWalk(armed) => {
                self.walk_armed = armed;
                self.place_armed = false;
            }
            Command::ViewMap(map) => self.view_map(map, effects),
            Command::Edit(settings) => {
                self.edit(settings, effects);
            }
            Command::Undo => self.undo(effects),
            Command::Redo => self.redo(effects),
            Command::Move(to) => self.move_camera(to, effects),
            Command::Select(selection) => self.select(selection),
            Command::Dismiss(note) => self.notes.dismiss(note),
            Command::Reconnect => self.reconnect(effects),
        }
    }

    fn place_robot(&mut self, place: Pose, effects: &mut Vec<Effect>) {
        self.place_armed = false;
        if let Some(map) = self.viewed().or(self.localisation.map()) {
            self.order_in_control(Order::Localise { map, at: Some(place) }, effects);
            self.view_map(None, effects);
        }
    }

    fn edit(&mut self, settings: ViewSettings, effects: &mut Vec<Effect>) {
        let changed = self.view.set(self.now, settings);
        if changed == Changed::Step {
            self.history.add(Step::View);
        }
        if changed != Changed::No {
            effects.push(Effect::Keep(self.view.get().clone()));
        }
    }

    /// Takes back the last point picked, or else the last step that can be; the view's own memory may be shorter than the history.
    fn undo(&mut self, effects: &mut Vec<Effect>) {
        if self.take_point_back(effects) {
            return;
        }
        while let Some(step) = self.history.take_last() {
            match step {
                Step::Loop(step) => return self.take_back(step, effects),
                Step::View if self.view.undo() => {
                    effects.push(Effect::Keep(self.view.get().clone()));
                    return self.history.undone(Step::View);
                }
                Step::View => {}
            }
        }
    }

    fn redo(&mut self, effects: &mut Vec<Effect>) {
        while let Some(step) = self.history.take_undone() {
            match step {
                Step::Loop(step) => return self.do_again(step, effects),
                Step::View if self.view.redo() => {
                    effects.push(Effect::Keep(self.view.get().clone()));
                    return self.history.redone(Step::View);
                }
                Step::View => {}
            }
        }
    }

    fn move_camera(&mut self, to: CameraMove, effects: &mut Vec<Effect>) {
        // A camera that was sent elsewhere must not be pulled back at once.
        if !matches!(to, CameraMove::Robot | CameraMove::Remember(_)) && self.view.get().follow {
            let settings = ViewSettings { follow: false, ..self.view.get().clone() };
            self.edit(settings, effects);
        }
        effects.push(Effect::Move(to));
    }

    fn reconnect(&mut self, effects: &mut Vec<Effect>) {
        for socket in [Socket::Control, Socket::Stream] {
            let now = self.now;
            let link = self.link_mut(socket);
            if matches!(link.state(), LinkState::Lost { .. }) {
                link.connect(now);
                effects.push(Effect::Open(socket));
            }
        }
    }

    /// Needs no lease, and ends driving by hand.
    fn stop_motion(&mut self, effects: &mut Vec<Effect>) {
        self.drive.hold(self.now, None);
        self.walk_armed = false;
        self.order(Order::StopMotion, effects);
    }

    pub(super) fn teleoperate(&mut self, twist: Twist, effects: &mut Vec<Effect>) {
        if !self.link.connected() {
            return;
        }
        self.take_free_control(effects);
        // Ten a second, each of them soon out of date: they are not kept for a reconnection.
        let id = self.ids.command();
        effects.push(Effect::command(id, Order::Teleoperate(twist)));
    }

    fn take_control(&mut self, effects: &mut Vec<Effect>) {
        self.order(Order::TakeControl { name: self.operator_name() }, effects);
    }

    /// Takes the lease if it lies about: nobody wants to press a button for that.
    pub(super) fn take_free_control(&mut self, effects: &mut Vec<Effect>) {
        let asked = self.waits_for(|order| matches!(order, Order::TakeControl { .. }));
        if self.control.owner.is_none() && !asked {
            self.take_control(effects);
        }
    }

    pub(super) fn order_in_control(&mut self, order: Order, effects: &mut Vec<Effect>) {
        self.take_free_control(effects);
        self.order(order, effects);
    }

    pub(crate) fn order(&mut self, order: Order, effects: &mut Vec<Effect>) {
        let id = self.ids.command();
        self.order_as(id, order, effects);
    }

    /// Gives an order under an id of the caller's.
    pub(super) fn order_as(&mut self, id: CommandId, order: Order, effects: &mut Vec<Effect>) {
        if self.link.connected() {
            effects.push(Effect::command(id, order.clone()));
        } else if order == Order::StopMotion {
            let text = "Not connected: the stop has not reached the robot yet. It is sent as soon as the link is back. \
                        Use the stop button on the robot.";
            self.notes.add(self.now, Severity::Error, text.to_owned());
        }
        self.pending.push(Pending { id, order, asked: self.now });
    }
}
