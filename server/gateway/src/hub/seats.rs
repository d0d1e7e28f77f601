//! Places of sockets in the hub.

use super::{Hub, Member, State};
use crate::limits::FIXED;
use crate::outbox::Outbox;
use crate::snapshot::Cursor;
use crate::texts;
use api::{Caller, Command, Event, GatewayMessage};
use site_model::Edit;
use std::collections::VecDeque;
use std::sync::Arc;
use tokio::sync::watch;
use vocab::{ClientId, CommandId};

/// A control socket's place in the hub; leaves it when dropped.
pub(crate) struct ControlSeat {
    hub: Arc<Hub>,
    key: u64,
    caller: Caller,
    pub(crate) outbox: Arc<Outbox>,
}

impl ControlSeat {
    /// Claims a place for somebody who has signed in with this account. A client may have several: after a network change its old socket lingers.
    ///
    /// # Errors
    /// When none is free, one sentence.
    pub(crate) fn claim(hub: &Arc<Hub>, caller: Caller, account: Option<&str>) -> Result<Self, String> {
        let outbox = Arc::new(Outbox::default());
        let key = {
            let mut state = hub.lock();
            if state.members.len() >= hub.max_clients {
                return Err(texts::too_many_clients(hub.max_clients));
            }
            let is_of_account = |member: &&Member| member.account.as_deref() == account;
            let most = hub.max_clients_of_account;
            if account.is_some() && state.members.values().filter(is_of_account).count() >= most {
                return Err(texts::too_many_clients_of_account(most));
            }
            let key = state.next_member;
            state.next_member += 1;
            let member = Member {
                client: caller.client,
                account: account.map(str::to_owned),
                outbox: outbox.clone(),
                pending: VecDeque::new(),
                pending_edits: VecDeque::new(),
            };
            state.members.insert(key, member);
            hub.publish_client_count(&mut state);
            key
        };
        hub.changed.send_replace(());
        Ok(Self { hub: hub.clone(), key, caller, outbox })
    }

    /// The client's id.
    pub(crate) fn client(&self) -> ClientId {
        self.caller.client
    }

    /// Changes whenever there may be something to send.
    pub(crate) fn changes(&self) -> watch::Receiver<()> {
        self.hub.changed.subscribe()
    }

    /// The next event that the client has not received.
    pub(crate) fn next_event(&self, cursor: &mut Cursor) -> Option<Arc<Event>> {
        self.hub.lock().snapshot.next(cursor)
    }

    /// Forwards a command to the core.
    ///
    /// # Errors
    /// Why it was not forwarded, one sentence.
    pub(crate) fn forward(&self, id: CommandId, command: Command) -> Result<(), &'static str> {
        let mut state = self.hub.lock();
        let is_stop = command == Command::StopMotion;
        let State { core, members, .. } = &mut *state;
        let core = core.as_ref().ok_or(texts::CORE_LOST)?;
        let Some(member) = members.get_mut(&self.key) else { return Err(texts::CONNECTION_CLOSING) };
        if !is_stop && member.pending.len() >= FIXED.max_pending_commands {
            return Err(texts::CORE_BUSY);
        }
        let command = GatewayMessage::Command { id, by: self.caller, command };
        core.send(command)?;
        if member.pending.len() < FIXED.max_pending_commands && !member.pending.contains(&id) {
            member.pending.push_back(id);
        }
        Ok(())
    }

    /// Why an edit is refused whatever the core would say of it, one sentence.
    pub(crate) fn refusal(&self, edit: &Edit) -> Option<String> {
        let (schemas, site) = (self.hub.action_schemas(), self.hub.site());
        schemas.refusal(edit, site.as_ref().map(|state| &state.site))
    }

    /// Forwards an edit of the site to the core.
    ///
    /// # Errors
    /// Why it was not forwarded, one sentence.
    pub(crate) fn forward_edit(&self, edit: Edit) -> Result<(), &'static str> {
        let mut state = self.hub.lock();
        let Some(member) = state.members.get(&self.key) else { return Err(texts::CONNECTION_CLOSING) };
        if member.pending_edits.len() >= FIXED.max_pending_edits {
            return Err(texts::CORE_BUSY);
        }
        let id = edit.id;
        state.forward_edit(self.caller, edit, |_, _| Ok(()))?;
        if let Some(member) = state.members.get_mut(&self.key)
            && !member.pending_edits.contains(&id)
        {
            member.pending_edits.push_back(id);
        }
        Ok(())
    }
}

impl Drop for ControlSeat {
    fn drop(&mut self) {
        {
            let mut state = self.hub.lock();
            state.members.remove(&self.key);
            self.hub.publish_client_count(&mut state);
        }
        self.hub.changed.send_replace(());
    }
}

/// A stream socket's place in the hub; leaves it when dropped.
pub(crate) struct StreamSeat {
    hub: Arc<Hub>,
    wants_scans: bool,
}

impl StreamSeat {
    /// Claims a place, if one is free.
    pub(crate) fn claim(hub: &Arc<Hub>) -> Option<Self> {
        let mut state = hub.lock();
        if state.stream_sockets >= hub.max_clients {
            return None;
        }
        state.stream_sockets += 1;
        Some(Self { hub: hub.clone(), wants_scans: false })
    }

    /// Sets whether this client wants scans now.
    pub(crate) fn set_wants_scans(&mut self, wants_scans: bool) {
        if wants_scans == self.wants_scans {
            return;
        }
        self.wants_scans = wants_scans;
        self.hub.listeners.send_modify(|listeners| {
            listeners.streams =
                if wants_scans { listeners.streams + 1 } else { listeners.streams.saturating_sub(1) };
        });
    }
}

impl Drop for StreamSeat {
    fn drop(&mut self) {
        self.set_wants_scans(false);
        self.hub.lock().stream_sockets -= 1;
    }
}
