//! Incidents: failures and interventions, around which recordings are kept longer.

use crate::texts;
use messages::{CommandKind, GoalStatus, Input, LocalisationState, Publication, Severity};
use vocab::Stamp;

/// Something that somebody may want to look into later.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Incident {
    /// When it happened.
    pub at: Stamp,
    /// What happened, in one sentence.
    pub text: String,
}

/// Finds incidents in what the stack gets and publishes: stopped motion, failed goals, lost localisation, and errors that people are told.
#[derive(Debug, Default)]
pub struct IncidentDetector {
    is_localised: bool,
}

impl IncidentDetector {
    /// An intervention among the inputs.
    pub fn of_input(&self, at: Stamp, input: &Input) -> Option<Incident> {
        match input {
            Input::Command(command) if command.kind == CommandKind::StopMotion => {
                Some(Incident { at, text: texts::MOTION_STOPPED.to_owned() })
            }
            _ => None,
        }
    }

    /// A failure among the publications.
    pub fn of_publication(&mut self, at: Stamp, publication: &Publication) -> Option<Incident> {
        let text = match publication {
            Publication::Goal(goal) if matches!(goal.status, GoalStatus::Failed { .. }) => {
                texts::GOAL_FAILED.to_owned()
            }
            Publication::Localisation(state) => {
                let was_localised = self.is_localised;
                self.is_localised = matches!(state, LocalisationState::Localised { .. });
                let is_lost = was_localised && matches!(state, LocalisationState::Relocalising { .. });
                is_lost.then(|| texts::LOCALISATION_LOST.to_owned())?
            }
            Publication::Notice(notice) if notice.severity == Severity::Error => notice.text.clone(),
            _ => return None,
        };
        Some(Incident { at, text })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::MapId;

    #[test]
    fn only_the_loss_of_a_known_pose_is_an_incident() {
        let mut detector = IncidentDetector::default();
        let map = MapId(uuid::Uuid::from_u128(1));
        let relocalising = Publication::Localisation(LocalisationState::Relocalising { map, hypotheses: 0 });
        let localised = Publication::Localisation(LocalisationState::Localised { map, degradation: None });
        let mut is_incident = |publication| detector.of_publication(Stamp::EPOCH, publication).is_some();
        let found =
            [&relocalising, &localised, &localised, &relocalising, &relocalising].map(&mut is_incident);
        assert_eq!(found, [false, false, false, true, false]);
    }
}
