//! Names that people give to maps.

/// Parameters of [`map_name`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct MapNameConfig {
    /// Longest name of a map, characters; longer names are cut. Chosen: lists show fewer.
    max_chars: usize,
}

impl Default for MapNameConfig {
    fn default() -> Self {
        Self { max_chars: 120 }
    }
}

/// The name of a map as it is saved, from what a person entered: without blanks round it, and cut to 120 characters. None if nothing is left.
pub fn map_name(entered: &str) -> Option<String> {
    let name = entered.trim();
    (!name.is_empty()).then(|| name.chars().take(MapNameConfig::default().max_chars).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_trimmed_and_cut() {
        assert_eq!(map_name("  Hall \n"), Some("Hall".to_owned()));
        assert_eq!(map_name(" \t"), None);
        assert_eq!(map_name(&"ä".repeat(200)), Some("ä".repeat(MapNameConfig::default().max_chars)));
    }
}
