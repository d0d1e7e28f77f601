//! Connects the link to the core with the clients: the latest state, the listeners, and the queue of commands.
//!
//! One lock protects the state; it is never held across an await. Nobody waits for a client: the link to the core writes into the [`Snapshot`],
//! and every client reads from it at its own pace.

mod core_queue;
mod seats;

pub(crate) use core_queue::CoreMessages;
pub(crate) use seats::{ControlSeat, StreamSeat};

use crate::access::AccessGate;
use crate::access::current_caller;
use crate::limits::{FIXED, Limits};
use crate::outbox::Outbox;
use crate::robot_clock::RobotClockEstimate;
use crate::site::{ActionSchemas, SiteRequests};
use crate::snapshot::Snapshot;
use crate::stored_data::StoredData;
use crate::texts;
use api::access::{AccountRefusal, AccountReply, AccountRequest};
use api::{
    Caller, Command, CommandOutcome, CoreMessage, EditDone, EditOutcome, EditRefusal, Event, GatewayMessage,
    Notice, Platform, ProcessRestart, Query, QueryReply, ScanFrame, Severity, SiteState,
};
use core_queue::CoreQueue;
use site_model::{Edit, EditId};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Instant, SystemTime, UNIX_EPOCH};
use tokio::sync::{oneshot, watch};
use uuid::Uuid;
use vocab::{ClientId, CommandId, Stamp};

type AccountResult = Result<AccountReply, AccountRefusal>;

/// Clients that listen, as [`GatewayMessage::Listeners`] tells the core.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Listeners {
    pub(crate) clients: u32,
    pub(crate) streams: u32,
}

/// The latest scan.
pub(crate) struct LiveScan {
    /// When it came from the core.
    pub(crate) received: Instant,
    /// The scan, not yet numbered.
    pub(crate) frame: ScanFrame,
}

impl LiveScan {
    /// Whether it is not older than `max_live_scan_age`. The core sends scans only while a client wants them, so the last one may be old.
    pub(crate) fn is_live(&self, now: Instant) -> bool {
        now.saturating_duration_since(self.received) < FIXED.max_live_scan_age
    }
}

/// State shared by all connections.
pub(crate) struct Hub {
    /// Who may use the gateway.
    pub(crate) access: AccessGate,
    state: Mutex<State>,
    max_clients: usize,
    /// Control sockets of one account.
    max_clients_of_account: usize,
    /// When this process started, nanoseconds since 1970: part of the ids of its own commands.
    started_ns: u64,
    /// Changes whenever there may be something to send to a client.
    changed: watch::Sender<()>,
    scan: watch::Sender<Option<Arc<LiveScan>>>,
    listeners: watch::Sender<Listeners>,
    /// Clients with a control socket.
    present: watch::Sender<Vec<ClientId>>,
}

struct State {
    snapshot: Snapshot,
    /// What clients are told once the robot's clock is known.
    restart_notice: Option<String>,
    clock: RobotClockEstimate,
    /// Queue to the core; `None` while it is not connected.
    core: Option<CoreQueue>,
    /// Why the core is not connected, one sentence.
    core_fault: String,
    /// Whether the core was asked for the whole graph and has not answered.
    is_graph_requested: bool,
    members: BTreeMap<u64, Member>,
    next_member: u64,
    stream_sockets: usize,
    /// Commands that came over HTTP and are not answered.
    requests: BTreeMap<CommandId, (ClientId, oneshot::Sender<CommandOutcome>)>,
    /// Number of commands that came over HTTP.
    requests_made: u64,
    /// Whether the core was asked for the whole site and has not answered.
    is_site_requested: bool,
    /// Edits and questions that the core has not answered.
    site_requests: SiteRequests,
    /// Requests about accounts that the core has not answered, by their number.
    account_requests: BTreeMap<u64, oneshot::Sender<AccountResult>>,
    account_requests_made: u64,
    /// Schemas of the actions that can be called.
    schemas: Arc<ActionSchemas>,
}

/// One control socket.
struct Member {
    client: ClientId,
    /// Who has signed in; none: nobody needs to.
    account: Option<String>,
    outbox: Arc<Outbox>,
    /// Forwarded commands that the core has not answered.
    pending: VecDeque<CommandId>,
    /// Forwarded edits that the core has not answered.
    pending_edits: VecDeque<EditId>,
}

impl State {
    /// Asks the core for the whole graph, once, if changes were lost on the way. If the queue is full, the next event asks again.
    fn request_graph_if_stale(&mut self) {
        let is_stale = self.snapshot.is_graph_stale();
        if is_stale
            && !self.is_graph_requested
            && let Some(core) = self.core.as_ref().filter(|core| core.has_room())
        {
            tracing::warn!("changes of the pose graph do not apply; the whole graph is asked for");
            self.is_graph_requested = core.send(GatewayMessage::RequestGraph).is_ok();
        }
        self.is_graph_requested &= is_stale;
    }

    /// The same for the site.
    fn request_site_if_stale(&mut self) {
        let is_stale = self.snapshot.is_site_stale();
        if is_stale
            && !self.is_site_requested
            && let Some(core) = self.core.as_ref().filter(|core| core.has_room())
        {
            tracing::warn!("a change of the site does not apply; the whole site is asked for");
            self.is_site_requested = core.send(GatewayMessage::RequestSite).is_ok();
        }
        self.is_site_requested &= is_stale;
    }
}

impl State {
    /// Puts an edit into the queue to the core, and lets `wait` note who waits for its answer.
    fn forward_edit<T>(
        &mut self,
        by: Caller,
        edit: Edit,
        wait: impl FnOnce(&mut SiteRequests, EditId) -> Result<T, &'static str>,
    ) -> Result<T, &'static str> {
        let core = self.core.as_ref().ok_or(texts::CORE_LOST)?;
        if !core.has_room() {
            return Err(texts::CORE_BUSY);
        }
        let id = edit.id;
        self.site_requests.admit(&edit)?;
        let waiting = wait(&mut self.site_requests, id)?;
        core.send(GatewayMessage::Edit { by, edit })?;
        Ok(waiting)
    }
}

impl Hub {
    /// Without core and clients.
    pub(crate) fn new(limits: &Limits, restart: Option<ProcessRestart>, access: AccessGate) -> Self {
        Self {
            access,
            state: Mutex::new(State {
                restart_notice: restart.as_ref().map(|restart| texts::server_restarted(&restart.cause)),
                snapshot: Snapshot::new(restart),
                clock: RobotClockEstimate::new(),
                core: None,
                core_fault: texts::CORE_NOT_REACHED.to_owned(),
                is_graph_requested: false,
                members: BTreeMap::new(),
                next_member: 0,
                stream_sockets: 0,
                requests: BTreeMap::new(),
                requests_made: 0,
                is_site_requested: false,
                site_requests: SiteRequests::default(),
                account_requests: BTreeMap::new(),
                account_requests_made: 0,
                schemas: Arc::default(),
            }),
            started_ns: started_ns(),
            max_clients: limits.clients,
            max_clients_of_account: limits.clients_of_account,
            changed: watch::Sender::new(()),
            scan: watch::Sender::new(None),
            listeners: watch::Sender::new(Listeners::default()),
            present: watch::Sender::default(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // No code under the lock leaves the state half changed, so it is usable after a panic of another thread.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A core has sent its hello; its snapshot follows. Returns the queue of messages for it.
    pub(crate) fn core_connected(&self) -> CoreMessages {
        let (queue, messages) = CoreQueue::new();
        {
            let mut state = self.lock();
            state.core = Some(queue);
            state.is_graph_requested = false;
            state.is_site_requested = false;
            state.clock = RobotClockEstimate::new();
            state.snapshot.forget_tiles();
            state.snapshot.change_platform(|platform| platform.core_connected = true);
        }
        self.changed.send_replace(());
        messages
    }

    /// The connection to the core has ended, for this reason. Commands that the core has not answered are refused.
    pub(crate) fn core_lost(&self, reason: &str) {
        {
            let mut state = self.lock();
            reason.clone_into(&mut state.core_fault);
            if state.core.take().is_none() {
                return;
            }
            state.snapshot.change_platform(|platform| platform.core_connected = false);
            // Those who wait learn it from their end of the channel.
            state.requests.clear();
            state.site_requests.clear();
            state.account_requests.clear();
            for member in state.members.values_mut() {
                for id in member.pending.drain(..) {
                    let outcome = CommandOutcome::Refused(texts::CORE_LOST_BEFORE_ANSWER.to_owned());
                    member.outbox.answer(Arc::new(Event::CommandDone { id, outcome }));
                }
                for id in member.pending_edits.drain(..) {
                    let reason = texts::CORE_LOST_BEFORE_ANSWER.to_owned();
                    let outcome = EditOutcome::Refused(EditRefusal::Unavailable(reason));
                    member.outbox.answer(Arc::new(Event::EditDone(EditDone { id, outcome })));
                }
            }
        }
        self.scan.send_replace(None);
        self.changed.send_replace(());
    }

    /// Handles a message that follows the core's hello.
    pub(crate) fn apply(&self, message: CoreMessage) {
        match message {
            CoreMessage::Hello { .. } => tracing::warn!("the core sent a second hello"),
            CoreMessage::Event { to: Some(client), event } => self.answer(client, event),
            CoreMessage::Event { to: None, event } => {
                {
                    let mut state = self.lock();
                    state.clock.update(&event, Instant::now());
                    if let Some(schemas) = state.schemas.after(&event) {
                        state.schemas = Arc::new(schemas);
                    }
                    if let Event::Platform(Platform { now: at, .. }) = event
                        && let Some(text) = state.restart_notice.take()
                    {
                        let notice = Notice { at, severity: Severity::Warning, text };
                        state.snapshot.apply(Event::Notice(notice));
                    }
                    state.snapshot.apply(event);
                    state.request_graph_if_stale();
                    state.request_site_if_stale();
                }
                self.changed.send_replace(());
            }
            CoreMessage::Access(access) => self.access.set(access),
            CoreMessage::AccountReply { number, result } => {
                if let Some(waiting) = self.lock().account_requests.remove(&number) {
                    // Whoever waited may have gone.
                    waiting.send(result).ok();
                }
            }
            CoreMessage::Reply { number, result } => self.lock().site_requests.reply(number, result),
            CoreMessage::Scan { stamp, map_from_base, points } => {
                let frame = ScanFrame { sequence: 0, stamp, map_from_base, points };
                self.scan.send_replace(Some(Arc::new(LiveScan { received: Instant::now(), frame })));
            }
        }
    }

    fn answer(&self, client: ClientId, event: Event) {
        let mut state = self.lock();
        if let Event::CommandDone { id, outcome } = &event
            && state.requests.get(id).is_some_and(|(by, _)| *by == client)
            && let Some((_, request)) = state.requests.remove(id)
        {
            // Whoever waited may have gone.
            request.send(outcome.clone()).ok();
            return;
        }
        if let Event::EditDone(done) = &event
            && state.site_requests.edit_done(done)
        {
            return;
        }
        let event = Arc::new(event);
        for member in state.members.values_mut().filter(|member| member.client == client) {
            if let Event::CommandDone { id, .. } = &*event {
                member.pending.retain(|pending| pending != id);
            }
            if let Event::EditDone(EditDone { id, .. }) = &*event {
                member.pending_edits.retain(|pending| pending != id);
            }
            member.outbox.answer(event.clone());
        }
    }

    /// Whether the core is connected.
    ///
    /// # Errors
    /// Why it is not, one sentence.
    pub(crate) fn core_state(&self) -> Result<(), String> {
        let state = self.lock();
        if state.core.is_some() { Ok(()) } else { Err(state.core_fault.clone()) }
    }

    /// Processes that failed and run again.
    pub(crate) fn restarts(&self) -> Vec<ProcessRestart> {
        self.lock().snapshot.restarts()
    }

    /// Forwards a command that came over HTTP to the core. The answer comes over the channel, which closes without one if the core is lost.
    ///
    /// # Errors
    /// Why it was not forwarded, one sentence.
    pub(crate) fn request(
        &self,
        command: Command,
    ) -> Result<oneshot::Receiver<CommandOutcome>, &'static str> {
        let mut state = self.lock();
        let by = current_caller()?;
        state.requests.retain(|_, (_, request)| !request.is_closed());
        let core = state.core.as_ref().ok_or(texts::CORE_LOST)?;
        let is_stop = command == Command::StopMotion;
        if !is_stop && (state.requests.len() >= FIXED.max_http_commands || !core.has_room()) {
            return Err(texts::CORE_BUSY);
        }
        let id = CommandId(Uuid::from_u64_pair(self.started_ns, state.requests_made));
        let command = GatewayMessage::Command { id, by, command };
        core.send(command)?;
        state.requests_made += 1;
        let (sender, receiver) = oneshot::channel();
        state.requests.insert(id, (by.client, sender));
        Ok(receiver)
    }

    /// Forwards an edit that came over HTTP to the core. The answer comes over the channel, which closes without one if the core is lost.
    ///
    /// # Errors
    /// Why it was not forwarded, one sentence.
    pub(crate) fn edit(&self, edit: Edit) -> Result<oneshot::Receiver<EditOutcome>, &'static str> {
        let by = current_caller()?;
        self.lock().forward_edit(by, edit, |requests, id| requests.wait_for_edit(id))
    }

    /// Asks the core about what is stored. The answer comes as for [`Self::edit`].
    ///
    /// # Errors
    /// Why it was not asked, one sentence.
    pub(crate) fn query(
        &self,
        query: Query,
    ) -> Result<oneshot::Receiver<Result<QueryReply, String>>, &'static str> {
        let by = current_caller()?;
        let mut state = self.lock();
        let State { core, site_requests, .. } = &mut *state;
        let core = core.as_ref().ok_or(texts::CORE_LOST)?;
        if !core.has_room() {
            return Err(texts::CORE_BUSY);
        }
        let (number, receiver) = site_requests.wait_for_reply()?;
        core.send(GatewayMessage::Query { number, by, query })?;
        Ok(receiver)
    }

    /// Asks the core something about accounts. The answer comes as for [`Self::edit`].
    ///
    /// # Errors
    /// Why it was not asked, one sentence.
    pub(crate) fn account(
        &self,
        by: Caller,
        request: AccountRequest,
    ) -> Result<oneshot::Receiver<AccountResult>, &'static str> {
        let mut state = self.lock();
        let State { core, account_requests, account_requests_made, .. } = &mut *state;
        let core = core.as_ref().ok_or(texts::CORE_LOST)?;
        account_requests.retain(|_, waiting| !waiting.is_closed());
        if account_requests.len() >= FIXED.max_account_requests || !core.has_room() {
            return Err(texts::CORE_BUSY);
        }
        *account_requests_made += 1;
        let number = *account_requests_made;
        core.send(GatewayMessage::Account { number, by, request })?;
        let (sender, receiver) = oneshot::channel();
        account_requests.insert(number, sender);
        Ok(receiver)
    }

    /// Tells the core from time to time which sessions and tokens were used; never returns.
    pub(crate) async fn report_uses(&self) {
        let mut interval = tokio::time::interval(FIXED.use_report_period);
        loop {
            interval.tick().await;
            let used = self.access.take_used();
            let state = self.lock();
            if let Some(core) = state.core.as_ref().filter(|core| core.has_room())
                && !used.is_empty()
            {
                // If the queue is full after all, the next use is told.
                core.send(GatewayMessage::CredentialsUsed(used)).ok();
            }
        }
    }

    /// Tells the core what its audit log has to say of requests that it has not seen; never returns. While the core is not connected, what is to be told is counted on.
    pub(crate) async fn report_journal(&self) {
        let mut interval = tokio::time::interval(FIXED.journal_report_period);
        loop {
            interval.tick().await;
            let state = self.lock();
            let Some(core) = state.core.as_ref().filter(|core| core.has_room()) else { continue };
            let notes = self.access.journal.take_due(Instant::now());
            if !notes.is_empty() && core.send(GatewayMessage::Audit(notes)).is_err() {
                tracing::warn!("refusals could not be told to the core");
            }
        }
    }

    /// The site, if the core has sent it.
    pub(crate) fn site(&self) -> Option<Arc<SiteState>> {
        self.lock().snapshot.site().cloned()
    }

    /// Schemas of the actions that can be called.
    pub(crate) fn action_schemas(&self) -> Arc<ActionSchemas> {
        Arc::clone(&self.lock().schemas)
    }

    /// What `read` finds in the lists of stored data.
    pub(crate) fn with_stored<T>(&self, read: impl FnOnce(&StoredData<'_>) -> T) -> T {
        let events = self.lock().snapshot.stored_data();
        read(&StoredData::of(&events))
    }

    /// Robot's clock now.
    pub(crate) fn robot_now(&self) -> Stamp {
        self.lock().clock.now(Instant::now())
    }

    /// Clients with a control socket now.
    pub(crate) fn present(&self) -> watch::Receiver<Vec<ClientId>> {
        self.present.subscribe()
    }

    /// Clients connected now.
    pub(crate) fn listeners(&self) -> watch::Receiver<Listeners> {
        self.listeners.subscribe()
    }

    /// The latest scan.
    pub(crate) fn scans(&self) -> watch::Receiver<Option<Arc<LiveScan>>> {
        self.scan.subscribe()
    }

    fn publish_client_count(&self, state: &mut State) {
        let clients = state.members.len() as u32;
        state.snapshot.change_platform(|platform| platform.clients = clients);
        self.listeners.send_modify(|listeners| listeners.clients = clients);
        let present: BTreeSet<_> = state.members.values().map(|member| member.client).collect();
        self.present.send_replace(present.into_iter().collect());
    }
}

/// Now, nanoseconds since 1970.
fn started_ns() -> u64 {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since_1970.as_nanos()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_scans_are_not_live() {
        let received = Instant::now();
        let scan = LiveScan { received, frame: ScanFrame::default() };
        assert!(scan.is_live(received + FIXED.max_live_scan_age / 2));
        assert!(!scan.is_live(received + FIXED.max_live_scan_age));
    }
}
