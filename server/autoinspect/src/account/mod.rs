//! `autoinspect account`: accounts and tokens on the robot's own console, for the first start and for recovery. It writes to the ledger in the data directory. A core
//! that runs notices the change within half a second.

mod password;

use crate::failure::Failure;
use crate::output::{print_human, print_json, print_line};
use crate::{summaries, texts, up};
use accounts::{AccountName, PasswordConfig, check_password, credential_id, hash, new_secret};
use api::access::{MAX_TOKEN_DAYS, Role};
use clap::{Args, Subcommand};
use ports::DataDir;
use runtime::audit_texts;
use serde_json::json;
use std::path::PathBuf;
use store::{Accounts, AuditEntry, Ledger, LedgerWriter, StoreError, StoredAccount, StoredCredential};
use vocab::{Span, Stamp};

/// Accounts of people and tokens of programs, on the robot's own console.
#[derive(Args, Debug)]
#[command(after_help = "EXAMPLES:
  autoinspect account link                          the address that makes the first admin
  autoinspect account add ada --role admin          asks for a password
  autoinspect account reset ada                     sets a new one, for somebody who has forgotten it
  autoinspect account token add historian --role viewer --days 90")]
pub struct AccountArgs {
    /// Data directory of the platform [default: the user's data directory].
    #[arg(long, global = true)]
    data: Option<PathBuf>,
    /// Print one JSON object as the last line.
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    command: AccountCommand,
}

const EXAMPLE_ADD: &str = "EXAMPLE:\n  autoinspect account add ada --role operator < password.txt";
const EXAMPLE_LIST: &str = "EXAMPLE:\n  autoinspect account list --json";
const EXAMPLE_RESET: &str = "EXAMPLE:\n  autoinspect account reset ada";
const EXAMPLE_REMOVE: &str = "EXAMPLE:\n  autoinspect account remove ada";
const EXAMPLE_LINK: &str = "EXAMPLE:\n  autoinspect account link --address http://robot7.plant.example:8080";

const EXAMPLE_FINGERPRINT: &str = "EXAMPLE:\n  autoinspect account fingerprint";

#[derive(Subcommand, Debug)]
enum AccountCommand {
    /// Make an account. Its password is asked for, or read from standard input.
    #[command(after_help = EXAMPLE_ADD)]
    Add {
        /// Its name.
        account: AccountName,
        /// viewer, operator or admin.
        #[arg(long, default_value = "operator")]
        role: Role,
    },
    /// List accounts and tokens.
    #[command(after_help = EXAMPLE_LIST)]
    List,
    /// Set a new password, and let the account sign in again. Its sessions end.
    #[command(after_help = EXAMPLE_RESET)]
    Reset {
        /// Name of the account.
        account: AccountName,
    },
    /// Remove an account. Its sessions end.
    #[command(after_help = EXAMPLE_REMOVE)]
    Remove {
        /// Name of the account.
        account: AccountName,
    },
    /// Print the address that makes the first admin.
    #[command(after_help = EXAMPLE_LINK)]
    Link {
        /// Address of the server for browsers.
        #[arg(long, default_value = "http://127.0.0.1:8080")]
        address: String,
    },
    /// Print the SHA-256 fingerprint of the robot's own certificate authority.
    #[command(after_help = EXAMPLE_FINGERPRINT)]
    Fingerprint,
    /// Tokens of programs.
    #[command(subcommand)]
    Token(TokenCommand),
}

#[derive(Subcommand, Debug)]
enum TokenCommand {
    /// Make a token, and print its secret, which is shown only now.
    #[command(after_help = "EXAMPLE:\n  autoinspect account token add historian --role viewer --days 90")]
    Add {
        /// Its name, for people.
        name: String,
        /// viewer, operator or admin.
        #[arg(long, default_value = "viewer")]
        role: Role,
        /// For how many days it is valid.
        #[arg(long, default_value_t = 90, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_TOKEN_DAYS)))]
        days: u32,
    },
    /// End all tokens of this name.
    #[command(after_help = "EXAMPLE:\n  autoinspect account token revoke historian")]
    Revoke {
        /// Name of the token.
        name: String,
    },
}

/// Runs the command.
pub fn run(args: &AccountArgs) -> Result<(), Failure> {
    let data = args.data.clone().unwrap_or_else(up::default_data_dir);
    if let AccountCommand::Link { address } = &args.command {
        let link = up::first_admin_link(&data, address.trim_end_matches('/'));
        print_line(&link.ok_or_else(|| Failure::failed(texts::NO_FIRST_ADMIN_LINK))?);
        return Ok(());
    }
    if let AccountCommand::Fingerprint = args.command {
        let fingerprint = gateway::authority_fingerprint(&DataDir::new(&data).tls());
        print_line(&fingerprint.ok_or_else(|| Failure::failed(texts::NO_AUTHORITY))?);
        return Ok(());
    }
    let mut ledger = Ledger::open_beside_core(&DataDir::new(&data).ledger()).map_err(Failure::usage)?;
    match &args.command {
        AccountCommand::Link { .. } | AccountCommand::Fingerprint => Ok(()),
        AccountCommand::List => list(&mut ledger, args.json),
        AccountCommand::Add { account, role } => {
            let password = hashed_password(account)?;
            change(&mut ledger, audit_texts::add_account(account, role), |writer, accounts, at| {
                if accounts.accounts.contains_key(account.as_str()) {
                    return Ok(Err(texts::account_exists(account.as_str())));
                }
                let new = StoredAccount {
                    role: *role,
                    password: password.clone(),
                    is_enabled: true,
                    created: at,
                    changed: at,
                };
                writer.put_account(account.as_str(), &new).map(Ok)
            })
        }
        AccountCommand::Reset { account } => {
            let password = hashed_password(account)?;
            change(&mut ledger, audit_texts::reset_password(account), |writer, accounts, at| {
                let Some(known) = accounts.accounts.get(account.as_str()) else {
                    return Ok(Err(texts::no_account(account.as_str())));
                };
                let password = password.clone();
                let changed = StoredAccount { password, is_enabled: true, changed: at, ..known.clone() };
                writer.put_account(account.as_str(), &changed)?;
                end(writer, accounts, at, |it| it.token_role.is_none() && it.owner == account.as_str())
                    .map(|_| Ok(()))
            })
        }
        AccountCommand::Remove { account } => {
            change(&mut ledger, audit_texts::remove_account(account), |writer, accounts, _| {
                if !accounts.accounts.contains_key(account.as_str()) {
                    return Ok(Err(texts::no_account(account.as_str())));
                }
                writer.remove_account(account.as_str()).map(Ok)
            })
        }
        AccountCommand::Token(TokenCommand::Add { name, role, days }) => {
            add_token(&mut ledger, args.json, name, *role, *days)
        }
        AccountCommand::Token(TokenCommand::Revoke { name }) => {
            change(&mut ledger, audit_texts::end_token(name), |writer, accounts, at| {
                let ended = end(writer, accounts, at, |it| it.token_role.is_some() && it.owner == *name)?;
                Ok(if ended == 0 { Err(texts::no_token(name)) } else { Ok(()) })
            })
        }
    }
}

/// A new password, hashed.
fn hashed_password(account: &AccountName) -> Result<String, Failure> {
    let password = password::read(account.as_str()).map_err(Failure::usage)?;
    let config = PasswordConfig::default();
    check_password(account, &password, &config).map_err(Failure::usage)?;
    hash(&password, &config).map_err(Failure::failed)
}

/// Changes accounts in one transaction, with an entry in the audit log. Nothing is changed if `make` gives a reason against it.
fn change(
    ledger: &mut Ledger,
    command: String,
    make: impl FnOnce(&LedgerWriter<'_>, &Accounts, Stamp) -> Result<Result<(), String>, StoreError>,
) -> Result<(), Failure> {
    let at = up::wall_clock();
    let refused = ledger.write(|writer| {
        let accounts = writer.accounts()?;
        let made = make(writer, &accounts, at)?;
        let outcome = if made.is_ok() { audit_texts::DONE } else { audit_texts::REFUSED }.to_owned();
        let entry =
            AuditEntry { by: None, address: None, command: audit_texts::on_console(&command), outcome };
        writer.put_audit_entry(&entry, at)?;
        Ok(made.err())
    });
    match refused.map_err(Failure::failed)? {
        Some(reason) => Err(Failure::usage(reason)),
        None => Ok(()),
    }
}

/// Ends the sessions and tokens that `is_meant` names, and returns their number.
fn end(
    writer: &LedgerWriter<'_>,
    accounts: &Accounts,
    at: Stamp,
    is_meant: impl Fn(&StoredCredential) -> bool,
) -> Result<usize, StoreError> {
    let open = accounts.credentials.iter().filter(|(_, it)| it.ended.is_none() && is_meant(it));
    let mut count = 0;
    for (id, credential) in open {
        writer.put_credential(*id, &StoredCredential { ended: Some(at), ..credential.clone() })?;
        count += 1;
    }
    Ok(count)
}

fn add_token(ledger: &mut Ledger, json: bool, name: &str, role: Role, days: u32) -> Result<(), Failure> {
    let secret = new_secret().map_err(Failure::failed)?;
    let id = credential_id(secret.reveal());
    let command = audit_texts::add_token(name, &role, days);
    change(ledger, command, |writer, _, at| {
        let token = StoredCredential {
            owner: name.to_owned(),
            token_role: Some(role),
            created: at,
            used: at,
            expires: at + Span::from_millis(i64::from(days) * 24 * 3_600_000),
            ended: None,
            address: None,
        };
        writer.put_credential(id, &token).map(Ok)
    })?;
    print_human(json, secret.reveal());
    print_json(json, &json!({ "id": id.to_string(), "secret": secret.reveal() }))
}

fn list(ledger: &mut Ledger, json: bool) -> Result<(), Failure> {
    let accounts = ledger.write(|writer| writer.accounts()).map_err(Failure::failed)?;
    let now = up::wall_clock();
    for (name, account) in &accounts.accounts {
        print_human(json, &summaries::account(name, account.role.name(), account.is_enabled));
    }
    let tokens = accounts.credentials.values().filter_map(|it| Some((it, it.token_role?)));
    let tokens: Vec<_> = tokens.filter(|(it, _)| it.ended.is_none() && now < it.expires).collect();
    for (token, role) in &tokens {
        let days = (token.expires - now).secs_f64() / 86_400.0;
        print_human(json, &summaries::token(&token.owner, role.name(), days));
    }
    let of_account = |(name, account): (&String, &StoredAccount)| json!({ "account": name, "role": account.role.name(), "is_enabled": account.is_enabled });
    let of_token = |(token, role): &(&StoredCredential, Role)| json!({ "name": token.owner, "role": role.name(), "expires": token.expires.nanos() });
    print_json(
        json,
        &json!({
            "accounts": accounts.accounts.iter().map(of_account).collect::<Vec<_>>(),
            "tokens": tokens.iter().map(of_token).collect::<Vec<_>>(),
        }),
    )
}
