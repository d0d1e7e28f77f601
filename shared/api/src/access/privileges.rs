//! The rows of the privilege table for all but the HTTP interface.

use super::{AccountRequest, Role};
use crate::{ClientMessage, Command, Event, Query};
use site_model::{Change, Edit, MissionCommandKind, ObjectKind};
use std::fmt;

/// Who may do something, at least.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Privilege {
    /// Everybody who can reach the server, without signing in.
    Anyone,
    /// Whoever has signed in with this role or a greater one.
    SignedIn(Role),
}

impl Privilege {
    /// Whether somebody with this role may do it; `None`: somebody who has not signed in.
    pub fn admits(self, role: Option<Role>) -> bool {
        match self {
            Self::Anyone => true,
            Self::SignedIn(least) => role.is_some_and(|role| role >= least),
        }
    }
}

impl fmt::Display for Privilege {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Anyone => f.write_str("anyone"),
            Self::SignedIn(role) => role.fmt(f),
        }
    }
}

const VIEWER: Privilege = Privilege::SignedIn(Role::Viewer);
const OPERATOR: Privilege = Privilege::SignedIn(Role::Operator);
const ADMIN: Privilege = Privilege::SignedIn(Role::Admin);

/// Who may give a command.
pub fn command_privilege(command: &Command) -> Privilege {
    match command {
        // Whoever sees danger stops the robot.
        Command::StopMotion => VIEWER,
        Command::TakeControl { .. }
        | Command::ReleaseControl
        | Command::RefuseTakeOver
        | Command::StartMapping(_)
        | Command::ExtendMap { .. }
        | Command::FinishMapping { .. }
        | Command::DiscardMapping
        | Command::Teleoperate(_)
        | Command::StartGoal { .. }
        | Command::CancelGoal(_)
        | Command::AllowMotion
        | Command::AcceptLoop { .. }
        | Command::RejectLoop { .. }
        | Command::ProposeLoop { .. }
        | Command::Localise { .. }
        | Command::LeaveMap
        | Command::InjectFault(_)
        | Command::ImportMap { .. }
        | Command::AlignMap { .. }
        | Command::CancelImport(_)
        | Command::SaveInterruptedSession { .. }
        | Command::DiscardInterruptedSession(_)
        | Command::RenameMap { .. }
        | Command::DeleteMap(_)
        | Command::RestoreMap(_)
        | Command::DeleteUpload(_)
        | Command::GenerateTopomap { .. }
        | Command::MakeExample { .. }
        | Command::MakeNormal { .. } => OPERATOR,
        Command::Mission(kind) => match kind {
            MissionCommandKind::Start { .. }
            | MissionCommandKind::Pause(_)
            | MissionCommandKind::Resume(_)
            | MissionCommandKind::SkipTask(..)
            | MissionCommandKind::RedoTask(..)
            | MissionCommandKind::Cancel(_)
            | MissionCommandKind::Abort(_)
            | MissionCommandKind::Answer(..) => OPERATOR,
        },
        // Nothing brings it back.
        Command::DeleteMapPermanently(_) => ADMIN,
    }
}

/// Who may make, change or remove objects of this kind.
pub fn object_privilege(kind: ObjectKind) -> Privilege {
    match kind {
        ObjectKind::Settings
        | ObjectKind::Node
        | ObjectKind::Edge
        | ObjectKind::EdgeBlock
        | ObjectKind::Zone
        | ObjectKind::MutexHold
        | ObjectKind::Dock
        | ObjectKind::Asset
        | ObjectKind::InspectionPoint
        | ObjectKind::Mission
        | ObjectKind::Schedule
        | ObjectKind::Monitor
        | ObjectKind::SceneChange
        | ObjectKind::Alert => OPERATOR,
    }
}

/// Who may make this edit: whoever may change all of its objects.
pub fn edit_privilege(edit: &Edit) -> Privilege {
    let of_change = |change: &Change| object_privilege(change.object_id().kind());
    // An edit without changes does nothing, and is refused by the core.
    edit.changes.iter().map(of_change).max().unwrap_or(OPERATOR)
}

/// Who may ask this of what is stored.
pub fn query_privilege(query: &Query) -> Privilege {
    match query {
        Query::Revisions { .. }
        | Query::Runs { .. }
        | Query::Run(_)
        | Query::Steps { .. }
        | Query::Results { .. }
        | Query::PointResults { .. }
        | Query::PictureComparison { .. }
        | Query::Slots { .. } => VIEWER,
        // It tells who works when, and from where.
        Query::Audit { .. } => ADMIN,
    }
}

/// Who may ask this about accounts.
pub fn account_privilege(request: &AccountRequest) -> Privilege {
    match request {
        AccountRequest::SignIn { .. } | AccountRequest::MakeFirstAdmin(_) => Privilege::Anyone,
        AccountRequest::SignOut | AccountRequest::ChangeOwnPassword { .. } => VIEWER,
        AccountRequest::ListAccounts
        | AccountRequest::AddAccount { .. }
        | AccountRequest::ChangeAccount { .. }
        | AccountRequest::RemoveAccount { .. }
        | AccountRequest::ListTokens
        | AccountRequest::AddToken { .. }
        | AccountRequest::RevokeToken(_) => ADMIN,
    }
}

/// Who may send a message on the control socket, besides what the message holds.
pub fn message_privilege(message: &ClientMessage) -> Privilege {
    match message {
        ClientMessage::Hello { .. }
        | ClientMessage::Ping { .. }
        | ClientMessage::RequestGraph
        | ClientMessage::RequestSite => VIEWER,
        ClientMessage::Command { command, .. } => command_privilege(command),
        ClientMessage::Edit(edit) => edit_privilege(edit),
    }
}

/// Who may see an event.
pub fn event_privilege(event: &Event) -> Privilege {
    match event {
        Event::Estimate(_)
        | Event::Graph(_)
        | Event::Tiles(_)
        | Event::Quality(_)
        | Event::Mapping(_)
        | Event::Localisation(_)
        | Event::Motion(_)
        | Event::Executive(_)
        | Event::Goals(_)
        | Event::Control(_)
        | Event::Health(_)
        | Event::Battery(_)
        | Event::Maps(_)
        | Event::Loops(_)
        | Event::Notice(_)
        | Event::CommandDone { .. }
        | Event::Platform(_)
        | Event::Import(_)
        | Event::Docks(_)
        | Event::GraphChanged(_)
        | Event::DamagedMaps(_)
        | Event::InterruptedSessions(_)
        | Event::BinnedMaps(_)
        | Event::Uploads(_)
        | Event::GraphPart(_)
        | Event::SitePart(_)
        | Event::SiteChanged(_)
        | Event::EditDone(_)
        | Event::Missions(_)
        | Event::Route(_)
        | Event::TopomapGeneration(_)
        | Event::ResultStored(_)
        | Event::Actions(_) => VIEWER,
    }
}
