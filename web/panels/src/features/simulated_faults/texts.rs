//! Texts of simulated faults, by key.

use api::SimulatedFault;
use vocab::Span;

pub(super) const HEAD: &str = "Simulated faults";
pub(super) const HINT: &str = "This robot is simulated. Inject a fault and watch how it recovers.";

/// What the button of a fault does.
pub(super) fn fault(fault: SimulatedFault) -> String {
    let seconds = |span: Span| format!("{:.0} s", span.secs_f64());
    match fault {
        SimulatedFault::CoverLidar(span) => format!("Cover the LiDAR for {}", seconds(span)),
        SimulatedFault::SilenceLidar(span) => format!("Cut off the LiDAR for {}", seconds(span)),
        SimulatedFault::SilenceImu(span) => format!("Cut off the IMU for {}", seconds(span)),
        SimulatedFault::SlipFeet(span) => format!("Let the feet slip for {}", seconds(span)),
        SimulatedFault::CarryAway => "Carry the robot away".to_owned(),
        SimulatedFault::End => "End all faults".to_owned(),
    }
}
