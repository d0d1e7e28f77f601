//! Why a robot on a route stands and waits.

use super::active_route::Leg;
use super::interface::RouteView;
use site_model::{EdgeId, MutexHold, RouteActionPlace, RouteWait};

/// Who holds the group of an edge now, if somebody does.
pub(super) fn hold_of<'a>(edge: EdgeId, view: &RouteView<'a>) -> Option<&'a MutexHold> {
    let group = view.site.edge(edge)?.mutex_group.as_ref()?;
    view.newest.mutex_holds().find(|hold| hold.group == *group)
}

/// Why a robot stands for a leg; none: it walks.
pub(super) fn waits_for(leg: Leg, view: &RouteView<'_>) -> Option<RouteWait> {
    match leg {
        Leg::Charge { .. } => Some(RouteWait::Charge),
        Leg::Wait { edge, until } => Some(RouteWait::Retry { edge, until }),
        Leg::WaitForBlock { until } => Some(RouteWait::Block { until }),
        Leg::WaitForPlace { .. } => Some(RouteWait::Place),
        Leg::WaitForHold { edge } => {
            let MutexHold { group, holder, .. } = hold_of(edge, view)?.clone();
            Some(RouteWait::Hold { edge, group, holder })
        }
        Leg::Act { edge, stage, index, .. } => {
            let index = u32::try_from(index).unwrap_or(u32::MAX);
            Some(RouteWait::Action(RouteActionPlace::Edge { edge, stage, index }))
        }
        Leg::ToGraph(_)
        | Leg::Edge(_)
        | Leg::IntoPose(_)
        | Leg::OutOfDock(_)
        | Leg::OntoDock
        | Leg::BackOff(_) => None,
    }
}
