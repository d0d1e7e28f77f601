//! The queue of publications from the control loop to the publisher. Posting never blocks, and memory is bounded however long the publisher takes.
//!
//! An estimate or scan that the publisher has not taken yet is replaced by the next one. All other publications keep their order. When more wait than
//! [`MailboxConfig`] allows, the mailbox is compacted:
//!
//! | publications | what stays |
//! | --- | --- |
//! | state, of which only the newest counts | the newest of each kind; of mapping the newest of each of the last sessions |
//! | goals, decisions on loops, notices | the newest, as many as clients are shown |
//! | keyframes | which ones they were; their clouds are on the disk, from where the publisher cuts their tiles |
//! | the graph and its changes | nothing; the publisher asks for the whole graph |

use api::{MAX_GOALS, MAX_LOOP_DECISIONS};
use messages::{
    CorrectedScan, Estimate, GraphEdge, GraphNode, Keyframe, MotionState, Notice, Publication, Severity,
};
use std::collections::{BTreeSet, VecDeque};
use std::mem::{Discriminant, discriminant};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;
use vocab::{GoalId, KeyframeId, SessionId, Stamp};

/// Bounds of a [`Mailbox`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MailboxConfig {
    /// Publications that may wait in order. Compacted they are some 600 at most. Chosen: three times that.
    pub max_publications: usize,
    /// Bytes that they may take, clouds and graphs included: some 60 keyframes, a minute of a walk over new ground. Chosen: it bounds the memory while the publisher
    /// waits for the disk.
    pub max_bytes: usize,
    /// Sessions of which a compacted mailbox keeps the state of mapping. The files of an older one stay until the next start. Chosen: a person begins few sessions while
    /// the disk does not write.
    pub max_sessions: usize,
}

impl Default for MailboxConfig {
    fn default() -> Self {
        Self { max_publications: 2_000, max_bytes: 64 << 20, max_sessions: 8 }
    }
}

/// Keyframes of one session that were dropped with their clouds, from the first to the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DroppedKeyframes {
    pub session: SessionId,
    pub first: KeyframeId,
    pub last: KeyframeId,
}

impl DroppedKeyframes {
    /// Both, if they are of one session; else the later ones, because a session that has ended is not shown.
    pub fn merge(earlier: Option<Self>, later: Self) -> Self {
        match earlier {
            Some(earlier) if earlier.session == later.session => Self {
                session: later.session,
                first: earlier.first.min(later.first),
                last: earlier.last.max(later.last),
            },
            _ => later,
        }
    }
}

/// The publications that wait.
#[derive(Default)]
pub struct WaitingPublications {
    /// Publications in the order of posting, without estimates and scans.
    pub ordered: VecDeque<Publication>,
    /// The newest scan.
    pub scan: Option<CorrectedScan>,
    /// The newest estimate.
    pub estimate: Option<Estimate>,
    /// Keyframes whose tiles have to be cut from their files.
    pub dropped_keyframes: Option<DroppedKeyframes>,
    /// Whether the graph or changes of it were dropped.
    pub is_graph_dropped: bool,
    /// Whether the control loop has ended.
    pub closed: bool,
    /// Bytes that `ordered` takes.
    bytes: usize,
}

impl WaitingPublications {
    fn is_empty(&self) -> bool {
        self.ordered.is_empty()
            && self.scan.is_none()
            && self.estimate.is_none()
            && self.dropped_keyframes.is_none()
            && !self.is_graph_dropped
    }

    fn push(&mut self, publication: Publication, config: &MailboxConfig) {
        self.bytes += bytes_of(&publication);
        self.ordered.push_back(publication);
        if self.ordered.len() > config.max_publications || self.bytes > config.max_bytes {
            self.compact(config);
            tracing::warn!(
                publications = self.ordered.len(),
                bytes = self.bytes,
                "the publisher is too slow; what waits for it was compacted"
            );
        }
    }

    /// Drops what the table at the head of this file says.
    fn compact(&mut self, config: &MailboxConfig) {
        let mut slots = Slots { max_sessions: config.max_sessions, ..Slots::default() };
        let (mut mapping, mut kept) = (VecDeque::new(), VecDeque::new());
        for publication in std::mem::take(&mut self.ordered).into_iter().rev() {
            match &publication {
                Publication::Keyframe(keyframe) => slots.drop_keyframe(keyframe),
                Publication::Graph { .. } | Publication::GraphDelta(_) => self.is_graph_dropped = true,
                _ if !slots.admit(&publication) => {}
                // It begins and ends sessions, so it comes before what belongs to them.
                Publication::Mapping(_) => mapping.push_front(publication),
                _ => kept.push_front(publication),
            }
        }
        if let Some(dropped) = slots.dropped_keyframes {
            self.dropped_keyframes = Some(DroppedKeyframes::merge(self.dropped_keyframes, dropped));
        }
        self.ordered = mapping.into_iter().chain(kept).collect();
        self.bytes = self.ordered.iter().map(bytes_of).sum();
    }
}

/// What a compacted mailbox keeps, filled from the newest publication to the oldest.
#[derive(Default)]
struct Slots {
    max_sessions: usize,
    states: Vec<Discriminant<Publication>>,
    sessions: Vec<Option<SessionId>>,
    goals: BTreeSet<GoalId>,
    loops: Option<(SessionId, usize)>,
    notices: usize,
    dropped_keyframes: Option<DroppedKeyframes>,
}

impl Slots {
    /// Whether a publication is kept, now counted.
    fn admit(&mut self, publication: &Publication) -> bool {
        match publication {
            Publication::Notice(_) => {
                self.notices += 1;
                self.notices <= api::Notice::MAX_KEPT
            }
            Publication::LoopDecided(decision) => {
                let (session, count) = self.loops.get_or_insert((decision.task.session, 0));
                *count += 1;
                *session == decision.task.session && *count <= MAX_LOOP_DECISIONS
            }
            Publication::Goal(goal) => self.goals.len() < MAX_GOALS && self.goals.insert(goal.id),
            Publication::Mapping(state) => {
                let session = state.session();
                let is_kept = self.sessions.len() < self.max_sessions && !self.sessions.contains(&session);
                self.sessions.extend(is_kept.then_some(session));
                is_kept
            }
            // Clients are not told of these.
            Publication::Reanchored(_) => false,
            state => {
                let kind = discriminant(state);
                let is_kept = !self.states.contains(&kind);
                self.states.extend(is_kept.then_some(kind));
                is_kept
            }
        }
    }

    fn drop_keyframe(&mut self, keyframe: &Keyframe) {
        let earlier = DroppedKeyframes { session: keyframe.session, first: keyframe.id, last: keyframe.id };
        let later = self.dropped_keyframes.unwrap_or(earlier);
        self.dropped_keyframes = Some(DroppedKeyframes::merge(Some(earlier), later));
    }
}

/// Bytes that a publication takes, up to a few hundred.
fn bytes_of(publication: &Publication) -> usize {
    let graph = |nodes: usize, edges: usize| nodes * size_of::<GraphNode>() + edges * size_of::<GraphEdge>();
    let content = match publication {
        Publication::Keyframe(Keyframe { cloud, .. }) => {
            size_of_val(&cloud.xyz[..]) + size_of_val(&cloud.intensity[..])
        }
        Publication::Graph { graph: whole, .. } => graph(whole.nodes.len(), whole.edges.len()),
        Publication::GraphDelta(delta) => graph(delta.nodes.len(), delta.edges.len()),
        Publication::Quality(quality) => size_of_val(&quality.deviations_m[..]),
        Publication::Motion(MotionState::Walking { path, .. }) => size_of_val(&path[..]),
        Publication::Docks(docks) => size_of_val(&docks[..]),
        Publication::Notice(notice) => notice.text.len(),
        _ => 0,
    };
    size_of::<Publication>() + content
}

/// The queue, shared by both threads.
#[derive(Default)]
pub struct Mailbox {
    config: MailboxConfig,
    mail: Mutex<WaitingPublications>,
    arrived: Condvar,
}

impl Mailbox {
    /// Appends a publication.
    pub fn post(&self, publication: Publication) {
        let mut mail = self.lock();
        match publication {
            Publication::Estimate(estimate) => mail.estimate = Some(estimate),
            Publication::Scan(scan) => mail.scan = Some(scan),
            other => mail.push(other, &self.config),
        }
        drop(mail);
        self.arrived.notify_one();
    }

    /// Appends a notice of the shell itself.
    pub fn notice(&self, at: Stamp, severity: Severity, text: String) {
        self.post(Publication::Notice(Notice { at, severity, text }));
    }

    /// Tells the publisher that nothing more comes.
    pub fn close(&self) {
        self.lock().closed = true;
        self.arrived.notify_one();
    }

    /// Waits until there is a publication, the mailbox is closed or `deadline` has passed. Takes all publications.
    pub fn wait(&self, deadline: Instant) -> WaitingPublications {
        let mut mail = self.lock();
        while mail.is_empty() && !mail.closed {
            let remaining = deadline.saturating_duration_since(Instant::now());
            if remaining.is_zero() {
                break;
            }
            mail = self.arrived.wait_timeout(mail, remaining).unwrap_or_else(PoisonError::into_inner).0;
        }
        let closed = mail.closed;
        WaitingPublications { closed, ..std::mem::take(&mut mail) }
    }

    /// Locks the data. A panic of the other thread leaves it usable, because every change of it is a single assignment.
    fn lock(&self) -> MutexGuard<'_, WaitingPublications> {
        self.mail.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
#[path = "mailbox_tests.rs"]
mod tests;
