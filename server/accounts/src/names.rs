//! Names of accounts and tokens.

use std::fmt;
use std::str::FromStr;

/// Longest name of an account, characters. Longer than names and e-mail addresses are in practice, short enough for a line.
const MAX_NAME_CHARS: usize = 60;

/// Name of an account: lower-case letters, digits and `.`, `_`, `-`, `@`. People may type it in any case.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AccountName(String);

impl AccountName {
    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for AccountName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Text that is no name of an account.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a name has 1 to {MAX_NAME_CHARS} letters a to z, digits, dots, hyphens, underscores and @, and begins with a letter or a digit"
)]
pub struct NameError;

impl FromStr for AccountName {
    type Err = NameError;
    fn from_str(text: &str) -> Result<Self, NameError> {
        let name = text.trim().to_ascii_lowercase();
        let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit();
        let is_allowed = |c: char| is_plain(c) || matches!(c, '.' | '_' | '-' | '@');
        let is_name =
            name.starts_with(is_plain) && name.len() <= MAX_NAME_CHARS && name.chars().all(is_allowed);
        if is_name { Ok(Self(name)) } else { Err(NameError) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_plain_and_have_one_case() {
        let parsed = |text: &str| text.parse::<AccountName>().map(|name| name.to_string());
        assert_eq!(parsed(" Ada.Lovelace@Site-7 "), Ok("ada.lovelace@site-7".to_owned()));
        for wrong in ["", " ", ".ada", "ada lovelace", "ädä", "ada/../root", "a\u{0}", &"a".repeat(61)] {
            assert_eq!(parsed(wrong), Err(NameError), "{wrong:?}");
        }
    }
}
