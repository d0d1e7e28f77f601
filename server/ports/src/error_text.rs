//! An error as a text for people.

use std::error::Error;

/// An error with its causes, as one clause without a full stop: the parts are joined by `": "`, the error itself first. A cause whose text the clause
/// already holds is left out, because some errors print their cause themselves.
pub fn error_with_causes(error: &dyn Error) -> String {
    let mut clause = error.to_string();
    let mut next = error.source();
    while let Some(cause) = next {
        let reason = cause.to_string();
        if !clause.contains(&reason) {
            clause = format!("{clause}: {reason}");
        }
        next = cause.source();
    }
    clause
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    enum Outer {
        #[error("the map could not be saved")]
        Quiet(#[source] Inner),
        #[error("the map could not be saved: {0}")]
        Repeating(#[source] Inner),
    }

    #[derive(Debug, thiserror::Error)]
    #[error("graph.g2o could not be written")]
    struct Inner(#[source] std::io::Error);

    fn inner() -> Inner {
        Inner(std::io::Error::other("the disk is full"))
    }

    const ALL: &str = "the map could not be saved: graph.g2o could not be written: the disk is full";

    #[test]
    fn an_error_is_a_clause_with_all_its_causes() {
        assert_eq!(error_with_causes(&Outer::Quiet(inner())), ALL);
    }

    #[test]
    fn a_cause_that_its_error_prints_is_not_repeated() {
        assert_eq!(error_with_causes(&Outer::Repeating(inner())), ALL);
    }
}
