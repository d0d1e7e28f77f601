//! Passwords: which are accepted, and how they are hashed.
//!
//! Argon2id (RFC 9106). A hash takes 50 ms or more of a fast core, so that passwords of a stolen ledger are dear to guess. Because of that cost only one thread hashes.

use crate::AccountName;
use argon2::password_hash::{PasswordHash, PasswordHasher, PasswordVerifier, SaltString};
use argon2::{Algorithm, Argon2, Params, Version};

/// Parameters of passwords and their hashes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PasswordConfig {
    /// Least length, characters. OWASP ASVS 5, 6.2.1 asks for 8 and recommends 15. Chosen between them.
    pub min_chars: usize,
    /// Greatest length, bytes: longer than any that people keep, and short enough to hash. Chosen: half a kilobyte.
    pub max_bytes: usize,
    /// Memory of one hash, KiB. OWASP recommends 19 MiB or more for Argon2id. That is the value.
    pub memory_kib: u32,
    /// Passes over that memory. Chosen: 6 took 47 ms on one core of an idle cloud machine of 2026, so 8 take more than 50 ms.
    pub passes: u32,
    /// Different characters that a password has at least. Chosen: enough to refuse one that repeats a word of four letters.
    pub min_different_chars: usize,
}

impl Default for PasswordConfig {
    fn default() -> Self {
        Self { min_chars: 12, max_bytes: 512, memory_kib: 19_456, passes: 8, min_different_chars: 5 }
    }
}

/// A password as it is stored: a string in the PHC format, which holds parameters and salt.
pub type HashedPassword = String;

/// Why a password is not accepted, or could not be hashed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PasswordError {
    /// Too short.
    #[error("a password has at least {0} characters; several words are easy to remember")]
    TooShort(usize),
    /// Too long.
    #[error("a password has at most {0} bytes")]
    TooLong(usize),
    /// It can be guessed from the name.
    #[error("the password may not contain the name of the account")]
    ContainsName,
    /// It consists of few different characters.
    #[error("the password repeats itself; use several words")]
    Repeats,
    /// The system has no random numbers, or a parameter is wrong.
    #[error("the password could not be hashed: {0}")]
    NotHashed(String),
}

/// Whether a new password is accepted.
///
/// # Errors
/// Why it is not.
pub fn check_password(
    account: &AccountName,
    password: &str,
    config: &PasswordConfig,
) -> Result<(), PasswordError> {
    let mut characters: Vec<char> = password.chars().collect();
    if characters.len() < config.min_chars {
        return Err(PasswordError::TooShort(config.min_chars));
    }
    if password.len() > config.max_bytes {
        return Err(PasswordError::TooLong(config.max_bytes));
    }
    // Names of one or two letters are in most passwords.
    if account.as_str().len() > 2 && password.to_ascii_lowercase().contains(account.as_str()) {
        return Err(PasswordError::ContainsName);
    }
    characters.sort_unstable();
    characters.dedup();
    if characters.len() < config.min_different_chars {
        return Err(PasswordError::Repeats);
    }
    Ok(())
}

fn hasher(config: &PasswordConfig) -> Result<Argon2<'static>, PasswordError> {
    let params = Params::new(config.memory_kib, config.passes, 1, None);
    let params = params.map_err(|error| PasswordError::NotHashed(error.to_string()))?;
    Ok(Argon2::new(Algorithm::Argon2id, Version::V0x13, params))
}

/// Hashes a password with a new salt. Takes at least 50 ms.
///
/// # Errors
/// When the system has no random numbers.
pub fn hash(password: &str, config: &PasswordConfig) -> Result<HashedPassword, PasswordError> {
    let mut salt = [0; 16];
    getrandom::fill(&mut salt).map_err(|error| PasswordError::NotHashed(error.to_string()))?;
    let failed = |error: argon2::password_hash::Error| PasswordError::NotHashed(error.to_string());
    let salt = SaltString::encode_b64(&salt).map_err(failed)?;
    let hash = hasher(config)?.hash_password(password.as_bytes(), &salt).map_err(failed)?;
    Ok(hash.to_string())
}

/// Whether a password is that of a hash. Takes at least 50 ms, whatever the answer; with `None`, for an account that does not exist, as long as with a hash.
pub fn verify(password: &str, hash: Option<&str>, config: &PasswordConfig) -> bool {
    let Some(hash) = hash else {
        // So that the time does not tell which accounts exist.
        let _ = self::hash(password, config);
        return false;
    };
    let Ok(hash) = PasswordHash::new(hash) else { return false };
    Argon2::default().verify_password(password.as_bytes(), &hash).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PASSWORD: &str = "correct horse battery";

    #[test]
    fn a_hash_says_what_work_it_is_and_knows_its_password() {
        let config = PasswordConfig::default();
        let hashed = hash(PASSWORD, &config).expect("a hash");
        assert!(hashed.starts_with("$argon2id$v=19$m=19456,t=8,p=1$"), "{hashed}");
        assert!(verify(PASSWORD, Some(&hashed), &config));
        assert!(!verify("correct horse batterx", Some(&hashed), &config));
        assert!(!verify(PASSWORD, None, &config) && !verify(PASSWORD, Some("damaged"), &config));
        assert_ne!(hash(PASSWORD, &config).expect("a hash"), hashed, "the salt differs");
    }

    #[test]
    fn passwords_that_can_be_guessed_are_refused() {
        let config = PasswordConfig::default();
        let ada: AccountName = "ada".parse().expect("a name");
        let refusal = |password: &str| check_password(&ada, password, &config).err();
        assert_eq!(refusal(PASSWORD), None);
        assert_eq!(refusal("ärger über öl 7"), None);
        assert_eq!(refusal("short"), Some(PasswordError::TooShort(12)));
        assert_eq!(refusal(&"abcdefgh".repeat(100)), Some(PasswordError::TooLong(512)));
        assert_eq!(refusal("I am ADA of the pumps"), Some(PasswordError::ContainsName));
        assert_eq!(refusal("111111111111"), Some(PasswordError::Repeats));
    }
}
