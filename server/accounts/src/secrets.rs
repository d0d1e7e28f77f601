//! Secrets of sessions, tokens and links.

use api::CredentialId;
use api::access::Secret;
use std::fmt::Write;

/// Length of a secret, bytes. Too many to guess, so that its plain hash can be kept.
const SECRET_BYTES: usize = 32;

/// The system has no random numbers.
#[derive(Debug, thiserror::Error)]
#[error("the system gave no random numbers: {0}")]
pub struct RandomError(#[from] getrandom::Error);

/// A new secret: 256 random bits as hexadecimal digits.
///
/// # Errors
/// When the system has no random numbers.
pub fn new_secret() -> Result<Secret, RandomError> {
    let mut bytes = [0; SECRET_BYTES];
    getrandom::fill(&mut bytes)?;
    let mut text = String::with_capacity(2 * SECRET_BYTES);
    for byte in bytes {
        // Writing to a string does not fail.
        let _ = write!(text, "{byte:02x}");
    }
    Ok(Secret::new(text))
}

/// What the server keeps of a secret: its BLAKE3.
pub fn credential_id(secret: &str) -> CredentialId {
    CredentialId(*blake3::hash(secret.as_bytes()).as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn secrets_differ_and_their_ids_do_not_tell_them() {
        let [first, second] = [new_secret(), new_secret()].map(|secret| secret.expect("random numbers"));
        assert_ne!(first, second);
        assert_eq!(first.reveal().len(), 2 * SECRET_BYTES);
        assert!(!format!("{first:?}").contains(first.reveal()));
        assert_ne!(credential_id(first.reveal()), credential_id(second.reveal()));
        assert_ne!(credential_id(first.reveal()).to_string(), first.reveal());
    }
}
