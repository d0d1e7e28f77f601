//! The form of an action, drawn from the schema of its parameters. Tasks, inspection points and edges use it.

mod problem;
#[cfg(test)]
mod tests;
mod texts;
mod units;

pub(crate) use problem::show_problem;
pub(crate) use texts::{DELETED_DOCK, NEAREST_DOCK, action_title, parameter_problem};
pub(crate) use units::shown_unit;

use crate::feature_panel::PanelContext;
use crate::select::{select, show_caption};
use crate::{TextInput, TextInputKind, widgets};
use client_model::{ParameterField, ParameterKind};
use egui::{Id, Ui};
use site_model::{ActionRequest, Dock, Parameter, Parameters, Site};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Longest text in a field for a number, characters.
const NUMBER_CHARS: u32 = 16;
/// Longest text in other fields, characters.
const TEXT_CHARS: u32 = 400;
/// Characters from which a text has a field of several lines.
const LINE_CHARS: usize = 80;

/// Parameters that aim the camera. They have no field where a target aims it.
const AIM: [&str; 2] = ["pan_rad", "tilt_rad"];

/// Texts that are typed and not taken yet, by the owner of the form and the name of the parameter.
#[derive(Debug, Default)]
pub(crate) struct TypedParameters(BTreeMap<(u64, String), String>);

impl TypedParameters {
    /// Shows the fields of an action. `owner` tells the form from others. `has_target`: whether a target aims the camera. Returns the parameters once one of them is
    /// changed.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        owner: Id,
        request: &ActionRequest,
        has_target: bool,
    ) -> Option<Parameters> {
        let mut changed = None;
        let is_used = |field: &&Arc<ParameterField>| !(has_target && AIM.contains(&field.name.as_str()));
        let forms = Arc::clone(cx.model.site.action_forms());
        for field in forms.fields(&request.action).iter().filter(is_used) {
            let value = match &field.kind {
                ParameterKind::Bool => show_switch(ui, cx, field, &request.parameters),
                ParameterKind::Choice(choices) => show_choice(ui, cx, field, choices, &request.parameters),
                ParameterKind::Dock => show_dock(ui, cx, field, &request.parameters),
                ParameterKind::Number(..) | ParameterKind::Integer(..) | ParameterKind::Text(..) => {
                    self.show_typed(ui, cx, owner, field, &request.parameters)
                }
            };
            if let Some(value) = value {
                let mut parameters = request.parameters.clone();
                match value {
                    Some(value) => parameters.insert(field.name.clone(), value),
                    None => parameters.remove(&field.name),
                };
                changed = Some(parameters);
            }
        }
        changed
    }

    /// Forgets what was typed in the forms of others.
    pub(crate) fn keep_only(&mut self, owner: Id) {
        self.0.retain(|(of, _), _| *of == owner.value());
    }

    /// A field for a number or a text. What is typed is taken when the field is left or Enter pressed, and only if nothing is wrong with it.
    fn show_typed(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        owner: Id,
        field: &ParameterField,
        parameters: &Parameters,
    ) -> Option<Option<Parameter>> {
        let tokens = cx.tokens;
        let (unit, scale) = shown_unit(field);
        let given = parameters.get(&field.name).map(|value| shown(value, scale)).unwrap_or_default();
        let key = (owner.value(), field.name.clone());
        let mut text = self.0.get(&key).cloned().unwrap_or_else(|| given.clone());
        let caption = texts::caption(&field.title, unit);
        show_caption(ui, tokens, &caption);
        let hint = field.default.as_ref().map(|value| shown(value, scale)).unwrap_or_default();
        let input = TextInput::new(("parameter", owner, &field.name), &caption).hint(&hint);
        let input = match field.kind {
            ParameterKind::Text(_, max) if max > LINE_CHARS => input.paragraph(3).max_length(TEXT_CHARS),
            ParameterKind::Text(..) => input.max_length(TEXT_CHARS),
            _ => input.kind(TextInputKind::Number).max_length(NUMBER_CHARS),
        };
        let response = input.show(ui, tokens, cx.text_inputs, &mut text);
        if response.changed {
            self.0.insert(key.clone(), text.clone());
        }
        let parsed = parse(&text, field, scale);
        let problem = parsed.as_ref().ok().and_then(|value| {
            let mut tried = parameters.clone();
            match value {
                Some(value) => tried.insert(field.name.clone(), value.clone()),
                None => tried.remove(&field.name),
            };
            field.problem(&tried)
        });
        let problem = problem.or_else(|| parsed.as_ref().err().copied());
        if let Some(problem) = problem {
            let sentence = parameter_problem(&field.title, unit, scale, problem);
            show_problem(ui, tokens, &sentence);
        } else if !field.description.is_empty() {
            widgets::remark(ui, tokens, &field.description);
        }
        let is_left = response.lost_focus || response.submitted;
        if is_left && problem.is_none() {
            self.0.remove(&key);
            return parsed.ok().filter(|_| text != given);
        }
        None
    }
}

fn show_switch(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    field: &ParameterField,
    parameters: &Parameters,
) -> Option<Option<Parameter>> {
    let value = parameters.get(&field.name).or(field.default.as_ref());
    let is_on = value == Some(&Parameter::Bool(true));
    show_caption(ui, cx.tokens, &field.title);
    let mut chosen = None;
    widgets::choice(ui, cx.tokens, &[(texts::YES, true), (texts::NO, false)], is_on, |yes| {
        chosen = Some(Some(Parameter::Bool(yes)));
    });
    chosen
}

fn show_choice(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    field: &ParameterField,
    choices: &[String],
    parameters: &Parameters,
) -> Option<Option<Parameter>> {
    let value = parameters.get(&field.name).or(field.default.as_ref());
    let chosen = value.map(|value| shown(value, 1.0)).unwrap_or_default();
    let index = select(ui, cx.tokens, &field.title, &field.title, &chosen, choices)?;
    Some(Some(Parameter::Text(choices[index].clone())))
}

/// The docks of the site by their names. The first choice is the nearest one, which is no value.
fn show_dock(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    field: &ParameterField,
    parameters: &Parameters,
) -> Option<Option<Parameter>> {
    let docks: Vec<_> = cx.model.site.site().into_iter().flat_map(Site::docks).collect();
    let given = parameters.get(&field.name);
    let is_given = |dock: &&&Dock| given == Some(&Parameter::Text(dock.id.to_string()));
    let shown = match (given, docks.iter().find(is_given)) {
        (None, _) => NEAREST_DOCK,
        (Some(_), Some(dock)) => &dock.name,
        (Some(_), None) => DELETED_DOCK,
    };
    let names = docks.iter().map(|dock| dock.name.clone());
    let options: Vec<String> = std::iter::once(NEAREST_DOCK.to_owned()).chain(names).collect();
    let index = select(ui, cx.tokens, &field.title, &field.title, shown, &options)?;
    Some(index.checked_sub(1).map(|index| Parameter::Text(docks[index].id.to_string())))
}

/// The text of a value in the shown unit.
fn shown(value: &Parameter, scale: f64) -> String {
    match value {
        Parameter::Text(text) => text.clone(),
        Parameter::Integer(number) => texts::number(*number as f64 * scale),
        Parameter::Number(number) => texts::number(number * scale),
        Parameter::Bool(yes) => (if *yes { texts::YES } else { texts::NO }).to_owned(),
        Parameter::List(_) | Parameter::Map(_) => String::new(),
    }
}

/// The value of a text; `None` if it is empty, so that the default counts.
fn parse(
    text: &str,
    field: &ParameterField,
    scale: f64,
) -> Result<Option<Parameter>, client_model::ParameterProblem> {
    let text = text.trim();
    if text.is_empty() {
        return Ok(None);
    }
    let wrong = client_model::ParameterProblem::WrongType;
    match &field.kind {
        ParameterKind::Number(..) => {
            let number: f64 = text.replace(',', ".").parse().map_err(|_| wrong)?;
            let value = number / scale;
            let is_whole = value.fract() == 0.0 && value.abs() < 1e9;
            Ok(Some(if is_whole { Parameter::Integer(value as i64) } else { Parameter::Number(value) }))
        }
        ParameterKind::Integer(..) => Ok(Some(Parameter::Integer(text.parse().map_err(|_| wrong)?))),
        _ => Ok(Some(Parameter::Text(text.to_owned()))),
    }
}
