//! Texts of `autoinspect account`: errors and questions. What its entries of the audit log say is in [`runtime::audit_texts`].

/// There is an admin, or the core has not run yet.
pub const NO_FIRST_ADMIN_LINK: &str = "there is no link for a first admin: there is an admin already, or the platform has not run yet. \"autoinspect account list\" shows the accounts";

/// There is no certificate authority of the robot's own.
pub const NO_AUTHORITY: &str = "the robot has no certificate authority of its own yet. \"autoinspect up --tls auto\" makes it at its first start";

/// There is an account of this name.
pub fn account_exists(account: &str) -> String {
    format!(
        "there is an account {account} already. \"autoinspect account reset {account}\" sets a new password"
    )
}

/// There is no account of this name.
pub fn no_account(account: &str) -> String {
    format!("there is no account {account}. \"autoinspect account list\" shows those that there are")
}

/// There is no valid token of this name.
pub fn no_token(name: &str) -> String {
    format!("there is no valid token {name}. \"autoinspect account list\" shows those that there are")
}

/// Asks for a password at a terminal.
pub fn password_prompt(account: &str) -> String {
    format!("New password of {account}: ")
}
