//! Sentences for people about loops, by key: why a pair of keyframes is or is not a loop, and why a command about a loop is refused. English.

use mapping::{
    GraphError, KeyframePair, LoopCommandError, LoopOutcome, LoopRecord, PairEvidence, RejectionReason,
    Verdict, VerificationConfig,
};

/// The reason for a decision.
pub(crate) fn reason(record: &LoopRecord, config: &VerificationConfig) -> String {
    let (agreeing, evidence) = (record.agreeing, &record.pair.evidence);
    match record.outcome {
        LoopOutcome::AcceptedByPerson => "A person accepted it.".to_owned(),
        LoopOutcome::RejectedByPerson => "A person rejected it.".to_owned(),
        LoopOutcome::Decided(Verdict::Accepted) if agreeing > 1 => {
            format!("It fits, and {agreeing} loops agree with each other.")
        }
        LoopOutcome::Decided(Verdict::Accepted) => "It fits, and lies where the graph expects it.".to_owned(),
        LoopOutcome::Decided(Verdict::Held) if evidence.mahalanobis_squared.is_none() => {
            "It fits, but nothing else connects the two places.".to_owned()
        }
        LoopOutcome::Decided(Verdict::Held) => format!(
            "It fits, but the graph does not confirm it: it waits for others to agree with it, {} so far.",
            agreeing.saturating_sub(1)
        ),
        LoopOutcome::Decided(Verdict::Dropped) => "It fitted, but too few others agreed with it.".to_owned(),
        LoopOutcome::Decided(Verdict::Rejected(reason)) => rejected(reason, evidence, config),
    }
}

fn rejected(reason: RejectionReason, evidence: &PairEvidence, config: &VerificationConfig) -> String {
    let percent = |share: f64| (share * 100.0).round();
    let [a, b] = evidence.overlap;
    match reason {
        RejectionReason::NoFit => "The clouds could not be fitted together at all.".to_owned(),
        RejectionReason::Overlap => format!(
            "Too little of the clouds lies on each other: {} % and {} %, where {} % and {} % are needed.",
            percent(a.max(b)),
            percent(a.min(b)),
            percent(config.min_overlap_better),
            percent(config.min_overlap_worse)
        ),
        RejectionReason::Residual => format!(
            "Surfaces lie {:.0} mm apart, where at most {:.0} mm are allowed.",
            evidence.residual_m * 1e3,
            config.max_residual_m * 1e3
        ),
        RejectionReason::FreeSpaceViolation => format!(
            "{:.1} % of one cloud stand in free space of the other, where at most {:.1} % are allowed.",
            evidence.free_space_violation[0].max(evidence.free_space_violation[1]) * 100.0,
            config.max_free_space_violation * 100.0
        ),
        RejectionReason::Ambiguous => {
            format!("Another place fits {} % as well.", percent(evidence.runner_up_ratio))
        }
        RejectionReason::Degenerate => match evidence.degenerate_directions {
            1 => "One direction of translation is not observed, and the graph does not know it either."
                .to_owned(),
            count => {
                format!(
                    "{count} directions of translation are not observed, and the graph does not know them either."
                )
            }
        },
    }
}

/// Why a person's command about a loop is refused.
pub(crate) fn refusal(error: &LoopCommandError) -> String {
    match error {
        LoopCommandError::GraphFailed(error) => graph_failed(error),
        LoopCommandError::AlreadyLoop(pair) => format!("{} are a loop already.", names(pair)),
        LoopCommandError::NotCompared(pair) => {
            format!("{} have not been compared yet. Propose them as a loop first.", names(pair))
        }
        LoopCommandError::NotRegistered(pair) => {
            let text = "could not be fitted together. Propose them again with a better guess";
            format!("{} {text}.", names(pair))
        }
        LoopCommandError::UnknownKeyframes(pair) => {
            format!("{} are not both on this map. Choose two that are.", names(pair))
        }
        LoopCommandError::NoLoop(pair) => {
            format!("{} are no loop, so there is nothing to reject.", names(pair))
        }
        LoopCommandError::Neighbours => {
            "Choose two keyframes that do not follow each other on the walk.".to_owned()
        }
    }
}

/// Why a person's proposal is refused.
pub(crate) fn proposal_refusal(error: &LoopCommandError) -> String {
    match error {
        LoopCommandError::AlreadyLoop(_) => format!("{} Reject it first.", refusal(error)),
        other => refusal(other),
    }
}

/// That loops are not closed any more.
pub(crate) fn graph_failed(error: &GraphError) -> String {
    format!(
        "Loops of this map are not closed any more, because its graph cannot be solved: {error}. Save it and begin another."
    )
}

fn names((from, to): &KeyframePair) -> String {
    format!("Keyframes {} and {}", from.0, to.0)
}

#[cfg(test)]
#[path = "loop_texts_tests.rs"]
mod tests;
