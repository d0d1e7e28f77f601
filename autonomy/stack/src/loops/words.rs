//! Why a pair of keyframes is or is not a loop, in one sentence for people.

use mapping::{Decision, Evidence, RejectionReason, Verdict, VerificationConfig};

/// The reason for a decision.
pub(crate) fn reason(decision: &Decision, gates: &VerificationConfig) -> String {
    let agreeing = decision.agreeing;
    match decision.verdict {
        Verdict::Accepted if agreeing > 1 => format!("It fits, and {agreeing} loops agree with each other."),
        Verdict::Accepted => "It fits, and lies where the graph expects it.".to_owned(),
        Verdict::Held if decision.evidence.surprise.is_none() => {
            "It fits, but nothing else connects the two places.".to_owned()
        }
        Verdict::Held => format!(
            "It fits, but the graph does not confirm it: it waits for others to agree with it, {} so far.",
            agreeing.saturating_sub(1)
        ),
        Verdict::Dropped => "It fitted, but too few others agreed with it.".to_owned(),
        Verdict::Rejected(rejection) => rejected(rejection, &decision.evidence, gates),
    }
}

fn rejected(rejection: RejectionReason, evidence: &Evidence, gates: &VerificationConfig) -> String {
    let percent = |share: f64| (share * 100.0).round();
    let [a, b] = evidence.overlap;
    match rejection {
        RejectionReason::NoFit => "The clouds could not be fitted together at all.".to_owned(),
        RejectionReason::Overlap => format!(
            "Too little of the clouds lies on each other: {} % and {} %, where {} % and {} % are needed.",
            percent(a.max(b)),
            percent(a.min(b)),
            percent(gates.overlap[0]),
            percent(gates.overlap[1])
        ),
        RejectionReason::Residual => format!(
            "Surfaces lie {:.0} mm apart, where at most {:.0} mm are allowed.",
            evidence.residual * 1e3,
            gates.residual * 1e3
        ),
        RejectionReason::FreeSpaceViolation => format!(
            "One saw through {:.1} % of what the other saw, where at most {:.1} % are allowed.",
            evidence.through[0].max(evidence.through[1]) * 100.0,
            gates.through * 100.0
        ),
        RejectionReason::Ambiguous => format!("Another place fits {} % as well.", percent(evidence.rival)),
        RejectionReason::Degenerate => match evidence.blind {
            1 => "Along one direction nothing shows where the two places lie to each other.".to_owned(),
            blind => {
                format!("Along {blind} directions nothing shows where the two places lie to each other.")
            }
        },
    }
}
