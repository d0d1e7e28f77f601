//! Edits of inspection points as operators make them: each a step of undo.

use super::{SiteEdit, SiteFeature};
use crate::Selection;
use site_model::{ActionRequest, InspectionPoint, InspectionPointId, NodeId, Object, Parameters};
use std::collections::BTreeSet;
use vocab::Vec3;

/// The action of a new inspection point.
const FIRST_ACTION: &str = "photo";

impl SiteFeature {
    /// What a click on a point of the map does while a target is picked: with a node selected, a new inspection point that is looked at from there; with an
    /// inspection point selected, its new target. `None` with anything else.
    pub fn targeting(
        &self,
        selection: Option<Selection>,
        target_m: Vec3,
    ) -> Option<(InspectionPointId, SiteEdit)> {
        match selection? {
            Selection::Node(node) => Some(self.adding_inspection_point(node, target_m)),
            Selection::InspectionPoint(id) => {
                Some((id, self.changing_inspection_point(id, |point| point.target_m = target_m)))
            }
            _ => None,
        }
    }

    /// A new inspection point that takes a photo of a target, metres, map frame.
    pub fn adding_inspection_point(&self, node: NodeId, target_m: Vec3) -> (InspectionPointId, SiteEdit) {
        let id = InspectionPointId(self.new_id(0));
        let point = InspectionPoint {
            id,
            name: self.free_point_name(),
            asset: None,
            node,
            target_m,
            request: ActionRequest { action: FIRST_ACTION.to_owned(), parameters: Parameters::new() },
            limits: None,
        };
        (id, SiteEdit { put: vec![Object::InspectionPoint(point)], removed: Vec::new() })
    }

    /// An inspection point after a change.
    pub fn changing_inspection_point(
        &self,
        id: InspectionPointId,
        change: impl FnOnce(&mut InspectionPoint),
    ) -> SiteEdit {
        let mut edit = SiteEdit::default();
        if let Some(mut point) = self.site().and_then(|site| site.inspection_point(id)).cloned() {
            change(&mut point);
            edit.put.push(Object::InspectionPoint(point));
        }
        edit
    }

    /// All inspection points, by name.
    pub fn inspection_points(&self) -> Vec<&InspectionPoint> {
        let objects = self.site().into_iter().flat_map(|site| site.objects());
        let mut points: Vec<_> = objects
            .filter_map(|versioned| match &versioned.object {
                Object::InspectionPoint(point) => Some(point),
                _ => None,
            })
            .collect();
        points.sort_by(|a, b| a.name.cmp(&b.name).then(a.id.cmp(&b.id)));
        points
    }

    /// The first of the names `P1`, `P2` and so on that no inspection point has.
    fn free_point_name(&self) -> String {
        let names: BTreeSet<&str> =
            self.inspection_points().iter().map(|point| point.name.as_str()).collect();
        let free = (1..).map(|number| format!("P{number}")).find(|name| !names.contains(name.as_str()));
        free.unwrap_or_default()
    }
}

/// Parameters as JSON, for people who edit them.
pub fn parameters_to_json(parameters: &Parameters) -> String {
    serde_json::to_string(parameters).unwrap_or_default()
}

/// Parameters from the JSON that a person typed; nothing typed means none.
///
/// # Errors
/// What is wrong with it, one clause.
pub fn parameters_from_json(text: &str) -> Result<Parameters, String> {
    match text.trim() {
        "" => Ok(Parameters::new()),
        text => serde_json::from_str(text).map_err(|error| error.to_string()),
    }
}
