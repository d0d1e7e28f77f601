//! Texts of loops, by key.

use crate::format;
use api::{LoopSource, LoopVerdict};
use client_model::{LoopPair, LoopPick};
use vocab::KeyframeId;

pub(super) const TAB: &str = "Loops";

// The list.
pub(super) const ADD: &str = "Add a loop";
pub(super) const UNDO: &str = "Undo the decision";
pub(super) const UNDO_SHORT: &str = "Undo";
pub(super) const UNDO_NOTHING: &str = "Nothing was decided here yet.";
pub(super) const NONE: &str =
    "No loops yet. When the robot returns to a place, its scans there are compared automatically.";
pub(super) const SAVED_LOOPS: &str = "Closed loops";
pub(super) const SAVED_HINT: &str = "Loops can be examined and decided on while a map is being made. This map is finished; \
     its loops.json holds what was decided.";
pub(super) const LINK_LOST: &str = "The link to the robot is lost. It comes back by itself.";

// Proposing a loop.
pub(super) const GRAPH_DISTANCE: &str = "Apart in the graph";
pub(super) const INITIAL_GUESS: &str =
    "The pose from which the comparison starts. An error of one or two metres is small enough.";
pub(super) const GUESS_GRAPH: &str = "From the graph";
pub(super) const GUESS_SAME_POSITION: &str = "Same position";
pub(super) const ADJACENT: &str =
    "These keyframes follow each other and are joined already. Choose two others.";
pub(super) const PROPOSE: &str = "Propose";
pub(super) const PROPOSE_HINT: &str = "The two scans are compared; you then see the evidence, and decide.";
pub(super) const CANCEL: &str = "Cancel adding";
pub(super) const CANCEL_SHORT: &str = "Cancel";

// The evidence of one loop.
pub(super) const CLOSE: &str = "Close the loop's evidence";
pub(super) const SHOW_IN_SCENE: &str = "Show where it is";
pub(super) const VERDICT: &str = "Verdict";
pub(super) const UNKNOWN_DECISION: &str =
    "The decision on this loop is too old: the client no longer holds it.";
pub(super) const ACCEPT: &str = "Accept loop";
pub(super) const ACCEPT_SHORT: &str = "Accept";
pub(super) const REJECT: &str = "Reject loop";
pub(super) const REJECT_SHORT: &str = "Reject";
pub(super) const EFFECT_OF_REJECTING: &str =
    "Reject takes the edge out, and the map moves back to fit without it.";
pub(super) const EFFECT_OF_DECIDING: &str =
    "Accept joins the two places, and the map moves to fit. Reject stops waiting for loops that confirm it.";
pub(super) const EFFECT_OF_ACCEPTING: &str =
    "Accept joins the two places as they were found, and the map moves to fit.";
pub(super) const NOT_REGISTERED: &str =
    "The two scans could not be fitted together. Add the loop by hand from a better start.";
pub(super) const SCANS: &str = "Both scans";
pub(super) const OVERLAY_REGISTERED: &str = "As found";
pub(super) const OVERLAY_GRAPH: &str = "In the graph";
pub(super) const OVERLAY_OFF: &str = "Map only";
pub(super) const OLDER: &str = "older";
pub(super) const NEWER: &str = "newer";
pub(super) const SCANS_LOADING: &str = "Fetching the scans…";
pub(super) const NO_VALUE: &str = "nothing to measure";

/// A quantity of the evidence: its name, and what it means.
pub(super) type Quantity = (&'static str, &'static str);
pub(super) const OVERLAP: Quantity =
    ("Overlap", "Share of each scan that lies on the other's surfaces: newer on older, older on newer.");
pub(super) const RESIDUAL: Quantity =
    ("Residual", "Root mean square distance of the points from those surfaces.");
pub(super) const FREE_SPACE_VIOLATION: Quantity = (
    "Free-space violation",
    "Share of each scan that lies where the other scan saw free space. A wall makes that impossible.",
);
pub(super) const RUNNER_UP: Quantity =
    ("Runner-up", "How well the best other pose fits, as a share of this one.");
pub(super) const CORRECTION: Quantity =
    ("Correction", "From where the comparison started to where it ended.");
pub(super) const SOURCE: Quantity = ("Found by", "Why the two keyframes were compared.");

pub(super) fn head(pair: LoopPair) -> String {
    format!("Loop {}", self::pair(pair))
}

/// Two keyframes: `58 → 111`, the older first.
pub(super) fn pair(pair: LoopPair) -> String {
    format!("{} → {}", pair.from.0, pair.to.0)
}

pub(super) fn verdict(verdict: LoopVerdict) -> &'static str {
    match verdict {
        LoopVerdict::Accepted => "Accepted",
        LoopVerdict::Held => "Under test",
        LoopVerdict::Rejected => "Rejected",
        LoopVerdict::Dropped => "Not confirmed",
    }
}

/// A verdict, and whether a person gave it.
pub(super) fn verdict_and_author(verdict: LoopVerdict, by_hand: bool) -> String {
    format!("{}{}", self::verdict(verdict), if by_hand { " by hand" } else { "" })
}

/// Value of the verdict in the accessible tree.
pub(super) fn verdict_value(verdict: &str, reason: &str) -> String {
    format!("{verdict}. {reason}")
}

/// Name of the number of loops with a verdict.
pub(super) fn count(verdict: LoopVerdict) -> String {
    format!("{} loops", self::verdict(verdict))
}

/// Name of a row of the list.
pub(super) fn row(pair: LoopPair, verdict: LoopVerdict, reason: &str) -> String {
    format!("Loop {}: {}. {reason}", self::pair(pair), self::verdict(verdict).to_lowercase())
}

/// The verdict at the right end of a row.
pub(super) fn row_verdict(verdict: LoopVerdict, by_hand: bool) -> String {
    format!("{}{}", if by_hand { "by hand · " } else { "" }, self::verdict(verdict).to_lowercase())
}

pub(super) fn undo_hint(pair: LoopPair, accepted: bool) -> String {
    let decision = if accepted { "accepting" } else { "rejecting" };
    format!("Takes back {decision} {}. Ctrl Z", self::pair(pair))
}

pub(super) fn comparing(pair: LoopPair) -> String {
    format!("Comparing keyframes {}…", self::pair(pair))
}

pub(super) fn control_needed(holder: &str) -> String {
    format!("{holder} controls the robot. Take control to decide on loops.")
}

/// What the operator does next to add a loop.
pub(super) fn step(pick: LoopPick) -> String {
    match pick {
        LoopPick::First => "Step 1 of 3: click a keyframe on the map.".to_owned(),
        LoopPick::Second(first) => {
            format!("Step 2 of 3: click another keyframe that saw the same place as keyframe {}.", first.0)
        }
        LoopPick::Both(both) => format!("Step 3 of 3: propose keyframes {} as a loop.", pair(both)),
    }
}

/// One of the two scans in the legend.
pub(super) fn keyframe(keyframe: KeyframeId, age: &str) -> String {
    format!("Keyframe {}, {age}", keyframe.0)
}

/// Why two keyframes were compared. The likeness of the same scan is 100 %.
pub(super) fn source(source: LoopSource) -> String {
    match source {
        LoopSource::Geometry => "near in the graph".to_owned(),
        LoopSource::Appearance(distance) => {
            format!("likeness {:.0} %", 100.0 * (1.0 - distance.clamp(0.0, 1.0)))
        }
        LoopSource::Person => "a person".to_owned(),
    }
}

/// A share of each scan: `77 % and 63 %`.
pub(super) fn two_shares([newer, older]: [f32; 2]) -> String {
    format!("{} and {}", format::share(newer), format::share(older))
}

/// How well another pose fits: `none`, `42 % as good`.
pub(super) fn runner_up(ratio: f32) -> String {
    if ratio > 0.0 { format!("{:.0} % as good", ratio * 100.0) } else { "none".to_owned() }
}

/// A movement: `12 cm, 3.1°`.
pub(super) fn correction(distance_m: f64, angle_rad: f64) -> String {
    format!("{}, {:.1}°", format::accuracy(distance_m), angle_rad.to_degrees())
}
