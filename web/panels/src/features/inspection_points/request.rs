//! The action of an inspection point: which one, and its parameters.

use super::texts;
use crate::feature_panel::PanelContext;
use crate::features::action_form::{TypedParameters, action_title};
use crate::select::select;
use egui::{Id, Ui};
use site_model::{ActionRequest, InspectionPoint, Parameters, actions_at_places};

/// Actions that have nothing to do with what is inspected.
const WITHOUT_TARGET: [&str; 2] = ["wait", "message"];

/// What is typed between frames.
#[derive(Debug, Default)]
pub(super) struct RequestFields {
    typed: TypedParameters,
}

impl RequestFields {
    /// Shows the fields. Returns the request once it is changed.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        point: &InspectionPoint,
    ) -> Option<ActionRequest> {
        let owner = Id::unique(("inspection point", point.id.0));
        self.typed.keep_only(owner);
        let tokens = cx.tokens;
        let actions: Vec<&str> = actions_at_places()
            .iter()
            .map(|action| action.name)
            .filter(|action| !WITHOUT_TARGET.contains(action))
            .collect();
        let titles: Vec<String> = actions.iter().map(|action| action_title(action)).collect();
        let shown = action_title(&point.request.action);
        if let Some(index) = select(ui, tokens, texts::ACTION, texts::ACTION, &shown, &titles) {
            let action = actions[index].to_owned();
            // The parameters of another action have other names.
            let request = ActionRequest { action, parameters: Parameters::new() };
            return Some(request).filter(|request| request.action != point.request.action);
        }
        let parameters = self.typed.show(ui, cx, owner, &point.request, true)?;
        Some(ActionRequest { parameters, ..point.request.clone() })
            .filter(|request| *request != point.request)
    }
}
