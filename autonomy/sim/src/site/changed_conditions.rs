//! Sites of which something is not in its usual condition.

use super::changes;
use super::conditions::{ConditionChange, HINGE_WITHIN_M};
use super::{ChangedConditions, SimulatedSite};
use crate::shape::Solid;
use geometry::{Isometry, vec_from_plain, vec_to_plain};
use std::sync::Arc;
use vocab::Vec3;

impl SimulatedSite {
    /// The site with everything in its usual condition.
    pub fn usual(&self) -> &Self {
        self.conditions.as_ref().map_or(self, |changed| &changed.usual)
    }

    /// What is not in its usual condition. Truth for scorers only.
    pub fn condition_changes(&self) -> &[ConditionChange] {
        self.conditions.as_ref().map_or(&[], |changed| &changed.changes)
    }

    /// A point on the hinge of each door leaf, metres.
    pub fn door_hinges(&self) -> Vec<Vec3> {
        self.plan.door_leaves.iter().map(|leaf| vec_to_plain(&leaf.hinge)).collect()
    }

    /// The usual site with these changes and no others. What they name must be there, or nothing happens.
    pub(crate) fn with_conditions(&self, changes: Vec<ConditionChange>) -> Self {
        let usual = self.usual().clone();
        let mut plan = usual.plan.clone();
        let mut is_rebuilt = false;
        for (leaf, turn_rad) in turns(&usual, &changes) {
            let leaf = usual.plan.door_leaves[leaf].clone();
            let swung = changes::swung(&plan, &leaf, turn_rad);
            plan.solids[leaf.solids].copy_from_slice(&swung);
            is_rebuilt = true;
        }
        let site = if is_rebuilt { Self::from_plan(usual.name.clone(), plan) } else { usual.clone() };
        let walkable = usual.walkable.clone();
        Self { walkable, conditions: Some(Arc::new(ChangedConditions { usual, changes })), ..site }
    }

    /// The usual solids of each door leaf that is turned, and its motion from there.
    pub(crate) fn turned_leaves(&self) -> Vec<(&[Solid], Isometry)> {
        let usual = self.usual();
        let motion = |(leaf, turn_rad): (usize, f64)| {
            let leaf = &usual.plan.door_leaves[leaf];
            (&usual.plan.solids[leaf.solids.clone()], changes::rotation_about(&leaf.hinge, turn_rad))
        };
        turns(usual, self.condition_changes()).into_iter().map(motion).collect()
    }

    /// Whether all routes stay free when a door is turned.
    pub(crate) fn stays_free(&self, hinge: Vec3, turn_rad: f64) -> bool {
        let usual = self.usual();
        usual
            .door_leaf(hinge)
            .is_some_and(|leaf| changes::is_swing_free(&usual.plan, &usual.plan.door_leaves[leaf], turn_rad))
    }

    /// The number of the door leaf whose hinge is nearest to a point, within [`HINGE_WITHIN_M`].
    pub(crate) fn door_leaf(&self, hinge: Vec3) -> Option<usize> {
        let point = vec_from_plain(hinge);
        let away = self.plan.door_leaves.iter().map(|leaf| (leaf.hinge - point).norm());
        let (leaf, away_m) = away.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
        (away_m <= HINGE_WITHIN_M).then_some(leaf)
    }
}

/// The door leaves that changes turn, and by how much, radians.
fn turns(usual: &SimulatedSite, changes: &[ConditionChange]) -> Vec<(usize, f64)> {
    let turn = |change: &ConditionChange| match change {
        ConditionChange::DoorTurned { hinge, turn_rad } => Some((usual.door_leaf(*hinge)?, *turn_rad)),
        _ => None,
    };
    changes.iter().filter_map(turn).collect()
}
