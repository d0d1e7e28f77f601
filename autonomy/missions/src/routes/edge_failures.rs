//! What is done about an edge that could not be traversed: the steps of its fail policy.

use super::active_route::Leg;
use super::executor::RouteExecutor;
use super::interface::{RouteEffect, RouteView};
use crate::graph::next_block;
use crate::runs::RouteGoalResult;
use crate::texts;
use site_model::{Edge, EdgeBlock, EdgeFailStep, EdgeId, ReachFailure};
use std::collections::BTreeMap;
use vocab::Stamp;

impl RouteExecutor {
    /// Follows the edge's policy: tries again, waits, takes another route, or gives up.
    ///
    /// `reason`: why, for people; none: the route was blocked.
    pub(super) fn handle_blocked_edge(
        &mut self,
        at: Stamp,
        id: EdgeId,
        reason: Option<&str>,
        view: &RouteView<'_>,
    ) {
        let Some(active) = &mut self.active else { return };
        let edge = view.site.edge(id);
        let step = edge.map_or(EdgeFailStep::Replan, |edge| policy_step(edge, active.edge_failures));
        active.edge_failures += 1;
        match step {
            EdgeFailStep::Retry(_) => self.walk_edge(at, id, view),
            EdgeFailStep::Wait(time) => self.stand(at, Leg::Wait { edge: id, until: at + time }),
            EdgeFailStep::Fail => self.end(RouteGoalResult::Failed(ReachFailure::PathBlocked)),
            EdgeFailStep::Replan => {
                active.edge_failures = 0;
                let back = edge.and_then(|edge| {
                    view.site.edges().find(|back| (back.from, back.to) == (edge.to, edge.from))
                });
                for blocked in [Some(id), back.map(|back| back.id)].into_iter().flatten() {
                    self.block(at, blocked, reason, view);
                }
                self.forget_place();
                self.next_leg(at, view);
            }
        }
    }

    fn block(&mut self, at: Stamp, edge: EdgeId, reason: Option<&str>, view: &RouteView<'_>) {
        let known = view.site.edge_blocks().find(|block| block.edge == edge);
        let previous = self.blocks.get(&edge).or(known);
        let reason = match (reason, view.map_from_base) {
            (Some(reason), _) => reason.to_owned(),
            (None, Some(pose)) => texts::path_blocked(pose.position),
            (None, None) => texts::PATH_BLOCKED.to_owned(),
        };
        let block = next_block(edge, previous, at, reason, &self.config.blocks);
        self.effects.push(RouteEffect::Block(block.clone()));
        self.blocks.insert(edge, block);
        // The site shows the block before it, if there was one, until it has this one.
        self.shown_blocks.remove(&edge);
    }

    /// Forgets the blocks that a person has lifted. Returns whether there were any. Linear in the blocks.
    pub(super) fn forget_lifted_blocks(&mut self, view: &RouteView<'_>) -> bool {
        let before = self.blocks.len();
        if before == 0 {
            return false;
        }
        let shown: BTreeMap<EdgeId, &EdgeBlock> =
            view.newest.edge_blocks().map(|block| (block.edge, block)).collect();
        let was_shown = std::mem::take(&mut self.shown_blocks);
        self.blocks.retain(|edge, _| shown.contains_key(edge) || !was_shown.contains(edge));
        let is_shown = |(edge, block): &(&EdgeId, &EdgeBlock)| {
            was_shown.contains(edge) || shown.get(edge).is_some_and(|it| it.until == block.until)
        };
        self.shown_blocks = self.blocks.iter().filter(is_shown).map(|(edge, _)| *edge).collect();
        self.blocks.len() < before
    }
}

/// The step of an edge's policy after this number of failures. Without a policy, and at its end, another route is taken.
fn policy_step(edge: &Edge, failures: u32) -> EdgeFailStep {
    let steps = edge.fail_policy.iter().flat_map(|step| match step {
        EdgeFailStep::Retry(times) => std::iter::repeat_n(*step, usize::from(*times)),
        step => std::iter::repeat_n(*step, 1),
    });
    let index = usize::try_from(failures).unwrap_or(usize::MAX);
    steps.into_iter().nth(index).unwrap_or(EdgeFailStep::Replan)
}
