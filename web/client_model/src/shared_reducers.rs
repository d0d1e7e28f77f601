//! Which reducer of the shared slices works on what. They work before those of the features.

use crate::features::connection::reducer as connection;
use crate::features::map_view::reducer as map_view;
use crate::shared::Context;
use crate::{ClientCommand, ClientEvent};
use api::ServerMessage;

impl Context<'_> {
    /// A message of the server. Returns its event if that follows the last one.
    pub(crate) fn on_message<'m>(
        &mut self,
        message: &'m ServerMessage,
        bytes: usize,
    ) -> Option<&'m api::Event> {
        connection::on_message(message, bytes, self)
    }

    pub(crate) fn on_event(&mut self, event: &api::Event) {
        match event {
            api::Event::Control(control) => {
                let now = self.now();
                self.shared.control.set(control.clone(), now);
            }
            api::Event::Maps(maps) => self.shared.maps.set_maps(maps.clone()),
            api::Event::DamagedMaps(maps) => self.shared.maps.set_damaged(maps.clone()),
            api::Event::Docks(docks) => self.shared.maps.set_docks(docks.clone()),
            api::Event::Notice(notice) => {
                self.shared.notices.receive(notice.clone());
                self.show_notices();
            }
            api::Event::CommandDone { id, outcome } => self.answer(*id, outcome),
            other => map_view::on_event(other, self),
        }
    }

    pub(crate) fn on_client_event(&mut self, event: &ClientEvent) {
        connection::on_client_event(event, self);
        map_view::on_client_event(event, self);
        if matches!(event, ClientEvent::Tick) {
            let now = self.now();
            self.shared.notices.expire(now);
        }
    }

    pub(crate) fn on_command(&mut self, command: &ClientCommand) {
        match command {
            ClientCommand::TakeControl => self.take_control(),
            ClientCommand::ReleaseControl => self.send(api::Command::ReleaseControl),
            ClientCommand::RefuseTakeOver => self.send(api::Command::RefuseTakeOver),
            ClientCommand::ViewMap(map) => self.view_map(*map),
            ClientCommand::DismissNotice(notice) => self.shared.notices.dismiss(*notice),
            ClientCommand::Reconnect => connection::reconnect(self),
            _ => {}
        }
    }
}
