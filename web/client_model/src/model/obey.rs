//! What people want, carried out: orders to the robot under idempotent ids, changes of the view.

use super::Model;
use crate::history::Step;
use crate::pending::PendingCommand;
use crate::{CameraMove, Changed, ClientCommand, ClientEffect, LinkState, Socket, ViewSettings};
use api::{Command, GoalKind, Severity};
use vocab::{CommandId, Pose, Twist};

impl Model {
    pub(super) fn obey(&mut self, command: ClientCommand, effects: &mut Vec<ClientEffect>) {
        match command {
            ClientCommand::ShowScreen(screen) => self.screen = screen,
            ClientCommand::StopMotion => self.stop_motion(effects),
            ClientCommand::AllowMotion => self.order_in_control(Command::AllowMotion, effects),
            ClientCommand::TakeControl => self.take_control(effects),
            ClientCommand::ReleaseControl => self.order(Command::ReleaseControl, effects),
            ClientCommand::StartMapping => {
                let session = self.ids.session();
                self.order_in_control(Command::StartMapping(session), effects);
            }
            ClientCommand::ExtendMap(map) => {
                let session = self.ids.session();
                self.order_in_control(Command::ExtendMap { session, map }, effects);
            }
            ClientCommand::UseMap(map) => self.order_in_control(Command::Localise { map, at: None }, effects),
            ClientCommand::PickPose(armed) => {
                self.place_armed = armed;
                self.walk_armed = false;
            }
            ClientCommand::SetPose(place) => self.place_robot(place, effects),
            ClientCommand::ImportMap { frame } => {
                self.import_frame = frame;
                effects.push(ClientEffect::OpenFileDialog);
            }
            ClientCommand::AlignMap { map, onto } => self.begin_align(map, onto, effects),
            ClientCommand::AddAlignmentPoint(at) => self.pick_point(at, effects),
            ClientCommand::RemoveAlignmentPoint => {
                self.take_point_back(effects);
            }
            ClientCommand::StartAlignment => self.lay(effects),
            ClientCommand::CancelAlignment => self.align = None,
            ClientCommand::CancelImport => self.cancel_import(effects),
            ClientCommand::InjectFault(mishap) => self.order(Command::InjectFault(mishap), effects),
            ClientCommand::Relocalise => {
                let goal = self.ids.goal();
                self.order_in_control(Command::StartGoal { goal, kind: GoalKind::Relocalise }, effects);
            }
            ClientCommand::LeaveMap => self.order_in_control(Command::LeaveMap, effects),
            ClientCommand::FinishMapping { name } => {
                let map = self.ids.map();
                self.order_in_control(Command::FinishMapping { map, name: name.trim().to_owned() }, effects);
            }
            ClientCommand::DiscardMapping => self.order_in_control(Command::DiscardMapping, effects),
            ClientCommand::AcceptLoop(pair) => self.decide_loop(pair, true, effects),
            ClientCommand::RejectLoop(pair) => self.decide_loop(pair, false, effects),
            ClientCommand::UndoLoop => self.undo_loop(effects),
            ClientCommand::PickLoopKeyframes(begin) => self.pick_loop(begin),
            ClientCommand::SetLoopInitialGuess(guess) => self.loop_guess = guess,
            ClientCommand::ProposeLoop => self.propose_loop(effects),
            ClientCommand::SetScanOverlay(overlay) => self.overlay = overlay,
            ClientCommand::SetVelocity(wanted) => {
                if let Some(twist) = self.drive.hold(self.now, wanted) {
                    self.teleoperate(twist, effects);
                }
            }
            ClientCommand::WalkTo(goal) => {
                self.walk_armed = false;
                let id = self.ids.goal();
                self.order_in_control(Command::StartGoal { goal: id, kind: GoalKind::WalkTo(goal) }, effects);
            }
            // A velocity by hand ends a walk; none means: stand.
            ClientCommand::CancelWalk => {
                self.order_in_control(Command::Teleoperate(Twist::default()), effects)
            }
            ClientCommand::PickGoal(armed) => {
                self.walk_armed = armed;
                self.place_armed = false;
            }
            ClientCommand::ViewMap(map) => self.view_map(map, effects),
            ClientCommand::EditView(settings) => {
                self.edit(settings, effects);
            }
            ClientCommand::Undo => self.undo(effects),
            ClientCommand::Redo => self.redo(effects),
            ClientCommand::MoveCamera(to) => self.move_camera(to, effects),
            ClientCommand::Select(selection) => self.select(selection),
            ClientCommand::DismissNotice(note) => self.notices.dismiss(note),
            ClientCommand::Reconnect => self.reconnect(effects),
        }
    }

    fn place_robot(&mut self, place: Pose, effects: &mut Vec<ClientEffect>) {
        self.place_armed = false;
        if let Some(map) = self.viewed_map().or(self.localisation.map()) {
            self.order_in_control(Command::Localise { map, at: Some(place) }, effects);
            self.view_map(None, effects);
        }
    }

    fn edit(&mut self, settings: ViewSettings, effects: &mut Vec<ClientEffect>) {
        let changed = self.view.set(self.now, settings);
        if changed == Changed::Step {
            self.history.add(Step::View);
        }
        if changed != Changed::No {
            effects.push(ClientEffect::SaveSettings(self.view.get().clone()));
        }
    }

    /// Takes back the last point picked, or else the last step that can be; the view's own memory may be shorter than the history.
    fn undo(&mut self, effects: &mut Vec<ClientEffect>) {
        if self.take_point_back(effects) {
            return;
        }
        while let Some(step) = self.history.take_last() {
            match step {
                Step::Loop(step) => return self.take_back(step, effects),
                Step::View if self.view.undo() => {
                    effects.push(ClientEffect::SaveSettings(self.view.get().clone()));
                    return self.history.undone(Step::View);
                }
                Step::View => {}
            }
        }
    }

    fn redo(&mut self, effects: &mut Vec<ClientEffect>) {
        while let Some(step) = self.history.take_undone() {
            match step {
                Step::Loop(step) => return self.do_again(step, effects),
                Step::View if self.view.redo() => {
                    effects.push(ClientEffect::SaveSettings(self.view.get().clone()));
                    return self.history.redone(Step::View);
                }
                Step::View => {}
            }
        }
    }

    fn move_camera(&mut self, to: CameraMove, effects: &mut Vec<ClientEffect>) {
        // A camera that was sent elsewhere must not be pulled back at once.
        if !matches!(to, CameraMove::Robot | CameraMove::SaveBookmark(_)) && self.view.get().follow {
            let settings = ViewSettings { follow: false, ..self.view.get().clone() };
            self.edit(settings, effects);
        }
        effects.push(ClientEffect::MoveCamera(to));
    }

    fn reconnect(&mut self, effects: &mut Vec<ClientEffect>) {
        for socket in [Socket::Control, Socket::Stream] {
            let now = self.now;
            let link = self.link_mut(socket);
            if matches!(link.state(), LinkState::Lost { .. }) {
                link.connect(now);
                effects.push(ClientEffect::OpenSocket(socket));
            }
        }
    }

    /// Needs no lease, and ends driving by hand.
    fn stop_motion(&mut self, effects: &mut Vec<ClientEffect>) {
        self.drive.hold(self.now, None);
        self.walk_armed = false;
        self.order(Command::StopMotion, effects);
    }

    pub(super) fn teleoperate(&mut self, twist: Twist, effects: &mut Vec<ClientEffect>) {
        if !self.link.connected() {
            return;
        }
        self.take_free_control(effects);
        // Ten a second, each of them soon out of date: they are not kept for a reconnection.
        let id = self.ids.command();
        effects.push(ClientEffect::command(id, Command::Teleoperate(twist)));
    }

    fn take_control(&mut self, effects: &mut Vec<ClientEffect>) {
        self.order(Command::TakeControl { name: self.operator_name() }, effects);
    }

    /// Takes the lease if it lies about: nobody wants to press a button for that.
    pub(super) fn take_free_control(&mut self, effects: &mut Vec<ClientEffect>) {
        let asked = self.is_pending(|order| matches!(order, Command::TakeControl { .. }));
        if self.control.owner.is_none() && !asked {
            self.take_control(effects);
        }
    }

    pub(super) fn order_in_control(&mut self, order: Command, effects: &mut Vec<ClientEffect>) {
        self.take_free_control(effects);
        self.order(order, effects);
    }

    pub(crate) fn order(&mut self, order: Command, effects: &mut Vec<ClientEffect>) {
        let id = self.ids.command();
        self.order_as(id, order, effects);
    }

    /// Gives an order under an id of the caller's.
    pub(super) fn order_as(&mut self, id: CommandId, order: Command, effects: &mut Vec<ClientEffect>) {
        if self.link.connected() {
            effects.push(ClientEffect::command(id, order.clone()));
        } else if order == Command::StopMotion {
            let text = "Not connected: the stop has not reached the robot yet. It is sent as soon as the link is back. \
                        Use the stop button on the robot.";
            self.notices.add(self.now, Severity::Error, text.to_owned());
        }
        self.pending.push(PendingCommand { id, order, asked: self.now });
    }
}
