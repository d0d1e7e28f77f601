//! Signing in and out, accounts and tokens over HTTP. The core does the work.

use super::cookies::set_session;
use super::documents::{
    AccountChangeDocument, AccountDocument, FirstAdminDocument, IssuedTokenDocument, NewAccountDocument,
    NewTokenDocument, PasswordChangeDocument, SessionDocument, SignInDocument, TokenDocument,
};
use super::identity::{Identity, TcpConnection, current_caller};
use super::texts;
use crate::app::App;
use crate::documents::{Answer, AnyPath};
use crate::json_response::json;
use crate::limits::FIXED;
use crate::problem::ProblemResponse;
use crate::problem_schemas::AccountProblems;
use crate::site::read_document;
use api::CredentialId;
use api::access::{
    AccountChange, AccountRefusal, AccountRefusalKind, AccountReply, AccountRequest, FirstAdmin,
    KNOWN_BROWSER_TIME, Secret,
};
use axum::Extension;
use axum::body::Bytes;
use axum::extract::State;
use axum::extract::rejection::BytesRejection;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;
use std::sync::Arc;

type Body = Result<Bytes, BytesRejection>;

/// Who asks, and whether people have to sign in.
#[utoipa::path(get, path = api::paths::SESSION_PATH, tag = "access", operation_id = "getSession",
    responses((status = 200, body = SessionDocument, description = "Who asks")))]
pub(crate) async fn session(
    State(app): State<Arc<App>>,
    Extension(identity): Extension<Identity>,
) -> Response {
    session_response(&app, &identity)
}

fn session_response(app: &App, identity: &Identity) -> Response {
    json(SessionDocument {
        is_demo: app.hub.access.is_demo,
        needs_first_admin: app.hub.access.needs_first_admin(),
        account: identity.account.clone(),
        role: identity.role.map(|role| role.name()),
    })
}

/// Begins a session. Its secret is in a cookie that scripts cannot read.
#[utoipa::path(post, path = api::paths::SESSION_PATH, tag = "access", operation_id = "signIn",
    request_body(content = SignInDocument, example = json!({ "account": "ada", "password": "correct horse battery" })),
    responses(
    (status = 200, body = SessionDocument, description = "Signed in", headers(("Set-Cookie" = String, description = "The session"))),
    AccountProblems
))]
pub(crate) async fn sign_in(
    State(app): State<Arc<App>>,
    Extension(connection): Extension<TcpConnection>,
    Extension(identity): Extension<Identity>,
    body: Body,
) -> Answer {
    let SignInDocument { account, password } = parse(body)?;
    if let Some(place) = connection.reserved {
        app.reserved_places.serve(place);
    }
    let password = Secret::new(password);
    begin_session(&app, &connection, &identity, AccountRequest::SignIn { account, password }).await
}

/// Makes the first admin, and begins a session.
#[utoipa::path(post, path = api::paths::FIRST_ADMIN_PATH, tag = "access", operation_id = "makeFirstAdmin",
    request_body(content = FirstAdminDocument, example = json!({ "link": "5e1f…", "account": "ada", "password": "correct horse battery" })),
    responses(
    (status = 200, body = SessionDocument, description = "The first admin is made and signed in", headers(("Set-Cookie" = String, description = "The session"))),
    AccountProblems
))]
pub(crate) async fn make_first_admin(
    State(app): State<Arc<App>>,
    Extension(connection): Extension<TcpConnection>,
    Extension(identity): Extension<Identity>,
    body: Body,
) -> Answer {
    let FirstAdminDocument { link, account, password } = parse(body)?;
    let first = FirstAdmin { link: Secret::new(link), account, password: Secret::new(password) };
    begin_session(&app, &connection, &identity, AccountRequest::MakeFirstAdmin(first)).await
}

async fn begin_session(
    app: &App,
    connection: &TcpConnection,
    identity: &Identity,
    request: AccountRequest,
) -> Answer {
    let AccountReply::SignedIn { secret, account, role, .. } = ask(app, request).await? else {
        return Err(ProblemResponse::unavailable(crate::texts::CORE_LOST_BEFORE_ANSWER));
    };
    let signed_in = Identity { account: Some(account), role: Some(role), ..identity.clone() };
    let mut response = session_response(app, &signed_in);
    response
        .headers_mut()
        .insert(header::SET_COOKIE, set_session(&secret, KNOWN_BROWSER_TIME, connection.is_tls));
    Ok(response)
}

/// Ends the session. The cookie stays, and is worth nothing but to tell that this browser was signed in before.
#[utoipa::path(delete, path = api::paths::SESSION_PATH, tag = "access", operation_id = "signOut",
    responses((status = 204, description = "Signed out"), AccountProblems))]
pub(crate) async fn sign_out(State(app): State<Arc<App>>) -> Answer {
    done(&app, AccountRequest::SignOut).await
}

/// Changes the password of whoever asks. All other sessions of the account end.
#[utoipa::path(put, path = api::paths::OWN_PASSWORD_PATH, tag = "access", operation_id = "changeOwnPassword",
    request_body(content = PasswordChangeDocument, example = json!({ "current": "correct horse battery", "new": "staple in the rain" })),
    responses((status = 204, description = "Changed"), AccountProblems))]
pub(crate) async fn change_own_password(State(app): State<Arc<App>>, body: Body) -> Answer {
    let PasswordChangeDocument { current, new } = parse(body)?;
    let (current, new) = (Secret::new(current), Secret::new(new));
    done(&app, AccountRequest::ChangeOwnPassword { current, new }).await
}

/// All accounts.
#[utoipa::path(get, path = api::paths::ACCOUNTS_PATH, tag = "access", operation_id = "listAccounts",
    responses((status = 200, body = [AccountDocument], description = "All accounts, by name"), AccountProblems))]
pub(crate) async fn list_accounts(State(app): State<Arc<App>>) -> Answer {
    match ask(&app, AccountRequest::ListAccounts).await? {
        AccountReply::Accounts(accounts) => {
            Ok(json(accounts.into_iter().map(AccountDocument::from).collect::<Vec<_>>()))
        }
        _ => Err(ProblemResponse::unavailable(crate::texts::CORE_LOST_BEFORE_ANSWER)),
    }
}

/// Makes an account.
#[utoipa::path(post, path = api::paths::ACCOUNTS_PATH, tag = "access", operation_id = "addAccount",
    request_body(content = NewAccountDocument, example = json!({ "account": "bob", "role": "operator", "password": "many rivers to cross" })),
    responses((status = 204, description = "Made"), AccountProblems))]
pub(crate) async fn add_account(State(app): State<Arc<App>>, body: Body) -> Answer {
    let NewAccountDocument { account, role, password } = parse(body)?;
    let password = Secret::new(password);
    done(&app, AccountRequest::AddAccount { account, role, password }).await
}

/// Changes an account.
#[utoipa::path(patch, path = api::paths::ACCOUNT_PATH, tag = "access", operation_id = "changeAccount",
    params(("account" = String, Path, description = "Name of the account")),
    request_body(content = AccountChangeDocument, example = json!({ "role": "viewer" })),
    responses((status = 204, description = "Changed"), AccountProblems))]
pub(crate) async fn change_account(State(app): State<Arc<App>>, account: AnyPath, body: Body) -> Answer {
    let account = account_name(account)?;
    let AccountChangeDocument { role, password, is_enabled, end_sessions } = parse(body)?;
    let changes = [
        role.map(AccountChange::Role),
        password.map(|password| AccountChange::Password(Secret::new(password))),
        is_enabled.map(AccountChange::IsEnabled),
        end_sessions.filter(|end| *end).map(|_| AccountChange::EndSessions),
    ];
    let mut changes = changes.into_iter().flatten();
    match (changes.next(), changes.next()) {
        (Some(change), None) => done(&app, AccountRequest::ChangeAccount { account, change }).await,
        _ => Err(ProblemResponse::malformed(texts::ONE_CHANGE)),
    }
}

/// Removes an account. Its sessions end.
#[utoipa::path(delete, path = api::paths::ACCOUNT_PATH, tag = "access", operation_id = "removeAccount",
    params(("account" = String, Path, description = "Name of the account")),
    responses((status = 204, description = "Removed"), AccountProblems))]
pub(crate) async fn remove_account(State(app): State<Arc<App>>, account: AnyPath) -> Answer {
    let account = account_name(account)?;
    done(&app, AccountRequest::RemoveAccount { account }).await
}

/// All tokens of programs that are valid, without their secrets.
#[utoipa::path(get, path = api::paths::TOKENS_PATH, tag = "access", operation_id = "listTokens",
    responses((status = 200, body = [TokenDocument], description = "All tokens"), AccountProblems))]
pub(crate) async fn list_tokens(State(app): State<Arc<App>>) -> Answer {
    match ask(&app, AccountRequest::ListTokens).await? {
        AccountReply::Tokens(tokens) => {
            Ok(json(tokens.into_iter().map(TokenDocument::from).collect::<Vec<_>>()))
        }
        _ => Err(ProblemResponse::unavailable(crate::texts::CORE_LOST_BEFORE_ANSWER)),
    }
}

/// Makes a token for a program. Its secret is in the answer, and is never shown again.
#[utoipa::path(post, path = api::paths::TOKENS_PATH, tag = "access", operation_id = "addToken",
    request_body(content = NewTokenDocument, example = json!({ "name": "historian", "role": "viewer", "days": 90 })),
    responses((status = 201, body = IssuedTokenDocument, description = "Made"), AccountProblems))]
pub(crate) async fn add_token(State(app): State<Arc<App>>, body: Body) -> Answer {
    let NewTokenDocument { name, role, days } = parse(body)?;
    match ask(&app, AccountRequest::AddToken { name, role, days }).await? {
        AccountReply::Token { secret, token } => {
            let secret = secret.reveal().to_owned();
            let issued = json(IssuedTokenDocument { secret, token: token.into() });
            Ok((StatusCode::CREATED, issued).into_response())
        }
        _ => Err(ProblemResponse::unavailable(crate::texts::CORE_LOST_BEFORE_ANSWER)),
    }
}

/// Ends a token.
#[utoipa::path(delete, path = api::paths::TOKEN_PATH, tag = "access", operation_id = "revokeToken",
    params(("id" = String, Path, description = "The token's id")),
    responses((status = 204, description = "It has ended"), AccountProblems))]
pub(crate) async fn revoke_token(State(app): State<Arc<App>>, id: AnyPath) -> Answer {
    let malformed = || ProblemResponse::malformed(texts::TOKEN_ID_MALFORMED);
    let id: Option<CredentialId> = id.ok().and_then(|id| id.0.parse().ok());
    done(&app, AccountRequest::RevokeToken(id.ok_or_else(malformed)?)).await
}

fn account_name(path: AnyPath) -> Result<String, ProblemResponse> {
    path.map(|name| name.0).map_err(|_| ProblemResponse::malformed(texts::ACCOUNT_NAME_MALFORMED))
}

fn parse<T: DeserializeOwned>(body: Body) -> Result<T, ProblemResponse> {
    let too_long = |_| ProblemResponse::new(StatusCode::PAYLOAD_TOO_LARGE, crate::texts::DOCUMENT_TOO_LONG);
    let malformed = |errors| ProblemResponse::malformed(texts::ACCOUNT_MALFORMED).with_fields(errors);
    read_document(&body.map_err(too_long)?).map_err(malformed)
}

async fn done(app: &App, request: AccountRequest) -> Answer {
    ask(app, request).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}

/// Asks the core, and waits for its answer.
async fn ask(app: &App, request: AccountRequest) -> Result<AccountReply, ProblemResponse> {
    let caller = current_caller().map_err(ProblemResponse::unavailable)?;
    let answer = app.hub.account(caller, request).map_err(ProblemResponse::unavailable)?;
    match tokio::time::timeout(FIXED.max_answer_wait, answer).await {
        Ok(Ok(reply)) => reply.map_err(problem),
        Ok(Err(_)) => Err(ProblemResponse::unavailable(crate::texts::CORE_LOST_BEFORE_ANSWER)),
        Err(_) => Err(ProblemResponse::new(StatusCode::GATEWAY_TIMEOUT, crate::texts::COMMAND_NOT_ANSWERED)),
    }
}

fn problem(AccountRefusal { kind, reason }: AccountRefusal) -> ProblemResponse {
    let status = match kind {
        AccountRefusalKind::NotSignedIn => StatusCode::UNAUTHORIZED,
        AccountRefusalKind::Forbidden => StatusCode::FORBIDDEN,
        AccountRefusalKind::NotFound => StatusCode::NOT_FOUND,
        AccountRefusalKind::Conflict => StatusCode::CONFLICT,
        AccountRefusalKind::Invalid => StatusCode::UNPROCESSABLE_ENTITY,
        AccountRefusalKind::Busy => StatusCode::TOO_MANY_REQUESTS,
        AccountRefusalKind::Unavailable => StatusCode::SERVICE_UNAVAILABLE,
    };
    ProblemResponse::new(status, reason).of_core()
}
