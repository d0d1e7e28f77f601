//! Where the robot was lately, by its own estimate: what an action found belongs to the instant at which it was found.

use messages::{Estimate, LocalisationState};
use site_model::{LocalisationQuality, ReportPlace};
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use vocab::{Covariance6, MapId, Pose, Stamp};

#[derive(Default)]
struct Places {
    estimates: VecDeque<(Stamp, Pose, Covariance6)>,
    localisation: LocalisationState,
}

/// The last estimates, written by the control loop and read by the thread of actions.
pub struct RecentPlaces {
    max_estimates: usize,
    places: Mutex<Places>,
}

impl RecentPlaces {
    /// No estimates yet. The newest `max_estimates` are kept.
    pub fn new(max_estimates: usize) -> Self {
        Self { max_estimates, places: Mutex::default() }
    }

    /// A panic of the other thread leaves it usable: every change is a single step.
    fn lock(&self) -> MutexGuard<'_, Places> {
        self.places.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn update(&self, estimate: &Estimate) {
        let mut places = self.lock();
        if places.estimates.len() >= self.max_estimates {
            places.estimates.pop_front();
        }
        places.estimates.push_back((estimate.stamp, estimate.map_from_base, estimate.covariance));
    }

    pub fn update_localisation(&self, state: LocalisationState) {
        let mut places = self.lock();
        if map_of(&state) != map_of(&places.localisation) {
            // They are poses in another map.
            places.estimates.clear();
        }
        places.localisation = state;
    }

    /// The saved map in which the robot's pose is known.
    pub fn map(&self) -> Option<MapId> {
        match self.lock().localisation {
            LocalisationState::Localised { map, .. } => Some(map),
            _ => None,
        }
    }

    /// The place at an instant: the estimate nearest to it. None before the first one.
    pub fn at(&self, instant: Stamp) -> Option<ReportPlace> {
        let places = self.lock();
        let nearest =
            places.estimates.iter().min_by_key(|(stamp, ..)| (*stamp - instant).nanos().unsigned_abs());
        let (_, map_from_base, covariance) = nearest.copied()?;
        let quality = match places.localisation {
            LocalisationState::Idle => LocalisationQuality::NoSavedMap,
            LocalisationState::Loading { .. } | LocalisationState::Relocalising { .. } => {
                LocalisationQuality::Lost
            }
            LocalisationState::Localised { degradation: None, .. } => LocalisationQuality::Good,
            LocalisationState::Localised { degradation: Some(_), .. } => LocalisationQuality::Degraded,
        };
        Some(ReportPlace { map: map_of(&places.localisation), map_from_base, covariance, quality })
    }
}

fn map_of(state: &LocalisationState) -> Option<MapId> {
    match state {
        LocalisationState::Idle => None,
        LocalisationState::Loading { map }
        | LocalisationState::Relocalising { map, .. }
        | LocalisationState::Localised { map, .. } => Some(*map),
    }
}
