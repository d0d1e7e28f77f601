//! Documents about accounts over HTTP.

use api::Role;
use api::access::{AccountSummary, TokenSummary};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use utoipa::ToSchema;

fn role_name<S: Serializer>(role: &Role, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(role.name())
}

fn role_of<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Role, D::Error> {
    String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
}

fn optional_role<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Role>, D::Error> {
    role_of(deserializer).map(Some)
}

/// Who asks.
#[derive(Serialize, ToSchema)]
#[schema(as = Session)]
pub(crate) struct SessionDocument {
    /// Whether nobody needs to sign in, because the platform is demonstrated.
    pub(crate) is_demo: bool,
    /// Whether there is no admin yet. The robot's console shows a link that makes the first one.
    pub(crate) needs_first_admin: bool,
    /// The account; of a program `token:` and the name of its token. Null: nobody has signed in.
    pub(crate) account: Option<String>,
    /// `viewer`, `operator` or `admin`; null: nobody has signed in.
    #[schema(value_type = Option<String>)]
    pub(crate) role: Option<&'static str>,
}

/// Who signs in.
#[derive(Deserialize, ToSchema)]
#[schema(as = SignIn)]
#[serde(deny_unknown_fields)]
pub(crate) struct SignInDocument {
    /// Name of the account, in any case.
    pub(crate) account: String,
    /// Its password.
    pub(crate) password: String,
}

/// The first admin.
#[derive(Deserialize, ToSchema)]
#[schema(as = FirstAdmin)]
#[serde(deny_unknown_fields)]
pub(crate) struct FirstAdminDocument {
    /// The secret of the link that the robot's console shows.
    pub(crate) link: String,
    /// Name of the account.
    pub(crate) account: String,
    /// Its password, 12 characters or more.
    pub(crate) password: String,
}

/// A new password.
#[derive(Deserialize, ToSchema)]
#[schema(as = PasswordChange)]
#[serde(deny_unknown_fields)]
pub(crate) struct PasswordChangeDocument {
    /// The present one.
    pub(crate) current: String,
    /// The new one, 12 characters or more.
    pub(crate) new: String,
}

/// A new account.
#[derive(Deserialize, ToSchema)]
#[schema(as = NewAccount)]
#[serde(deny_unknown_fields)]
pub(crate) struct NewAccountDocument {
    /// Its name: letters a to z, digits, `.`, `_`, `-`, `@`.
    pub(crate) account: String,
    /// `viewer`, `operator` or `admin`.
    #[schema(value_type = String)]
    #[serde(deserialize_with = "role_of")]
    pub(crate) role: Role,
    /// Its first password, 12 characters or more.
    pub(crate) password: String,
}

/// A change of an account: exactly one of these.
#[derive(Deserialize, ToSchema)]
#[schema(as = AccountChange)]
#[serde(deny_unknown_fields)]
pub(crate) struct AccountChangeDocument {
    /// `viewer`, `operator` or `admin`.
    #[schema(value_type = Option<String>)]
    #[serde(default, deserialize_with = "optional_role")]
    pub(crate) role: Option<Role>,
    /// A new password. The account's sessions end.
    pub(crate) password: Option<String>,
    /// Whether it may sign in. If not, its sessions end.
    pub(crate) is_enabled: Option<bool>,
    /// `true`: its sessions end.
    pub(crate) end_sessions: Option<bool>,
}

/// An account.
#[derive(Serialize, ToSchema)]
#[schema(as = Account)]
pub(crate) struct AccountDocument {
    /// Its name.
    account: String,
    /// `viewer`, `operator` or `admin`.
    #[schema(value_type = String)]
    #[serde(serialize_with = "role_name")]
    role: Role,
    /// Whether it may sign in.
    is_enabled: bool,
    /// Its sessions.
    sessions: u32,
    /// When it was made, nanoseconds since 1970, UTC.
    created: i64,
    /// When its sessions were used last, to a few minutes; null: never.
    last_used: Option<i64>,
}

impl From<AccountSummary> for AccountDocument {
    fn from(summary: AccountSummary) -> Self {
        let AccountSummary { account, role, is_enabled, sessions, created, last_used } = summary;
        let last_used = last_used.map(|at| at.nanos());
        Self { account, role, is_enabled, sessions, created: created.nanos(), last_used }
    }
}

/// A new token.
#[derive(Deserialize, ToSchema)]
#[schema(as = NewToken)]
#[serde(deny_unknown_fields)]
pub(crate) struct NewTokenDocument {
    /// Its name, for people.
    pub(crate) name: String,
    /// `viewer`, `operator` or `admin`.
    #[schema(value_type = String)]
    #[serde(deserialize_with = "role_of")]
    pub(crate) role: Role,
    /// For how many days it is valid, 1 to 366.
    pub(crate) days: u32,
}

/// A token, without its secret.
#[derive(Serialize, ToSchema)]
#[schema(as = Token)]
pub(crate) struct TokenDocument {
    /// Names it.
    id: String,
    /// Its name, for people.
    name: String,
    /// `viewer`, `operator` or `admin`.
    #[schema(value_type = String)]
    #[serde(serialize_with = "role_name")]
    role: Role,
    /// When it was made, nanoseconds since 1970, UTC.
    created: i64,
    /// When it ends.
    expires: i64,
    /// When it was used last, to a few minutes; null: never.
    last_used: Option<i64>,
}

impl From<TokenSummary> for TokenDocument {
    fn from(summary: TokenSummary) -> Self {
        let TokenSummary { id, name, role, created, expires, last_used } = summary;
        let (created, expires) = (created.nanos(), expires.nanos());
        Self { id: id.to_string(), name, role, created, expires, last_used: last_used.map(|at| at.nanos()) }
    }
}

/// A token that was made.
#[derive(Serialize, ToSchema)]
#[schema(as = IssuedToken)]
pub(crate) struct IssuedTokenDocument {
    /// Its secret, for `Authorization: Bearer`. It is shown only now.
    pub(crate) secret: String,
    /// What is known of it.
    pub(crate) token: TokenDocument,
}
