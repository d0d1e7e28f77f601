//! Texts of the account, by key.

pub(super) const HEAD: &str = "Account";
pub(super) const ACCOUNT: &str = "Signed in as";
pub(super) const ROLE: &str = "Role";
pub(super) const NOBODY: &str = "nobody";
pub(super) const DEMO_SHORT: &str = "Demonstration";
pub(super) const DEMO: &str =
    "This is a demonstration: nobody signs in, and everybody at this computer is an admin.";
pub(super) const VIEWER: &str = "You are signed in as viewer: you can watch and stop motion. To do more, ask an admin for the role operator.";
pub(super) const MANAGE: &str = "People and tokens";
pub(super) const CHANGE_PASSWORD: &str = "Change password";
pub(super) const SIGN_OUT: &str = "Sign out";
