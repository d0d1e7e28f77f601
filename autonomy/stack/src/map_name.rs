//! Names that people give to maps.

use vocab::MAX_MAP_NAME_CHARS;

/// The name of a map as it is saved, from what a person entered: without blanks round it, and cut to [`MAX_MAP_NAME_CHARS`]. None if nothing is left.
pub fn map_name(entered: &str) -> Option<String> {
    let name = entered.trim();
    (!name.is_empty()).then(|| name.chars().take(MAX_MAP_NAME_CHARS).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_trimmed_and_cut() {
        assert_eq!(map_name("  Hall \n"), Some("Hall".to_owned()));
        assert_eq!(map_name(" \t"), None);
        assert_eq!(map_name(&"ä".repeat(200)), Some("ä".repeat(MAX_MAP_NAME_CHARS)));
    }
}
