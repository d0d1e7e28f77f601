//! What an operator can do about accounts.

/// What an operator can do about accounts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AccountAction {
    /// End the session.
    SignOut,
    /// Change the password of the own account.
    ChangePassword,
    /// Open the page of people and tokens.
    ManagePeople,
}
