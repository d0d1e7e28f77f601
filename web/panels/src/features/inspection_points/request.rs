//! The action of an inspection point: which one, and its parameters as JSON.

use super::texts;
use crate::TextInput;
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::widgets;
use client_model::{parameters_from_json, parameters_to_json};
use egui::Ui;
use site_model::{ACTION_CATALOGUE, ActionRequest, InspectionPoint, InspectionPointId, Parameters};

/// Longest text of the parameters, characters.
const MAX_PARAMETER_CHARS: u32 = 2_000;
/// Actions that do not look at a target.
const WITHOUT_TARGET: [&str; 2] = ["wait", "message"];

/// What is typed between frames.
#[derive(Debug, Default)]
pub(super) struct RequestFields {
    /// The parameters that are typed for a point whose parameters are those of the text before.
    typed: Option<(InspectionPointId, String, String)>,
}

impl RequestFields {
    /// Shows the fields. Returns the request once it is changed.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        point: &InspectionPoint,
    ) -> Option<ActionRequest> {
        let tokens = cx.tokens;
        let mut changed = None;
        widgets::section_head(ui, tokens, texts::ACTION_HEAD);
        let choices: Vec<(&str, &str)> = ACTION_CATALOGUE
            .iter()
            .filter(|action| !WITHOUT_TARGET.contains(&action.name))
            .map(|action| (action.title, action.name))
            .collect();
        for pair in choices.chunks(2) {
            widgets::choice(ui, tokens, pair, point.request.action.as_str(), |action| {
                // The parameters of another action have other names.
                changed = Some(ActionRequest { action: action.to_owned(), parameters: Parameters::new() });
            });
        }
        let present = parameters_to_json(&point.request.parameters);
        if self.typed.as_ref().is_none_or(|(of, before, _)| *of != point.id || *before != present) {
            self.typed = Some((point.id, present.clone(), present.clone()));
        }
        let (_, _, typed) = self.typed.as_mut()?;
        let field = TextInput::new(("parameters", point.id.0), texts::PARAMETERS).paragraph(3);
        field.max_length(MAX_PARAMETER_CHARS).show(ui, tokens, cx.text_inputs, typed);
        if *typed != present {
            match parameters_from_json(typed) {
                Ok(parameters) => {
                    if Button::new(texts::APPLY).wide(ui).show(ui, tokens).clicked() {
                        changed = Some(ActionRequest { parameters, ..point.request.clone() });
                    }
                }
                Err(reason) => {
                    widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
                        widgets::sentence(ui, tokens, &texts::not_json(&reason));
                    });
                }
            }
        }
        changed.filter(|request| *request != point.request)
    }
}
