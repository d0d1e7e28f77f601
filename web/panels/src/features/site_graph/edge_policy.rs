//! What is tried in turn when an edge cannot be walked.

use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::number_field::{NumberField, TypedNumber};
use crate::select::select;
use crate::{icon, widgets};
use egui::Ui;
use site_model::{Edge, EdgeFailStep, ObjectId};
use vocab::Span;

/// Values of a new step.
struct NewStepConfig {
    /// Tries. Chosen: one, the fewest.
    tries: u8,
    /// Wait, seconds. Chosen: people who stand in a way have often gone in half a minute.
    wait_s: f64,
}

const CONFIG: NewStepConfig = NewStepConfig { tries: 1, wait_s: 30.0 };

/// What people may enter.
#[derive(Clone, Copy, Debug)]
struct PolicyLimitsConfig {
    /// Fewest and most tries. Chosen: a robot that failed as often does not succeed by itself.
    tries: [f64; 2],
    /// Shortest and longest wait, seconds. Chosen: up to an hour, after which a robot should rather be somewhere else.
    waits_s: [f64; 2],
    /// Most steps of a policy. Chosen: a person still sees what it does.
    max_steps: usize,
}

const LIMITS: PolicyLimitsConfig =
    PolicyLimitsConfig { tries: [1.0, 20.0], waits_s: [1.0, 3_600.0], max_steps: 8 };

/// Shows the steps. Returns them once they are changed.
pub(super) fn show(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedNumber,
    edge: &Edge,
) -> Option<Vec<EdgeFailStep>> {
    let tokens = cx.tokens;
    widgets::section_head(ui, tokens, texts::POLICY_HEAD);
    if edge.fail_policy.is_empty() {
        widgets::remark(ui, tokens, texts::NO_POLICY);
    }
    let kinds: Vec<String> = texts::FAIL_STEPS.iter().map(|kind| (*kind).to_owned()).collect();
    let mut steps = edge.fail_policy.clone();
    for (index, step) in edge.fail_policy.iter().enumerate() {
        let caption = texts::step_caption(index + 1);
        if let Some(kind) = select(ui, tokens, &caption, &caption, texts::fail_step(*step), &kinds) {
            steps[index] = step_of(kind);
        }
        if let Some(number) = show_number(ui, cx, typed, edge, index, *step) {
            steps[index] = number;
        }
        let name = texts::remove_row(&caption);
        if Button::new(&name).icon(icon::X).kind(Kind::Quiet).wide(ui).show(ui, tokens).clicked() {
            steps.remove(index);
        }
    }
    // What comes after these is never tried.
    let has_end = matches!(edge.fail_policy.last(), Some(EdgeFailStep::Replan | EdgeFailStep::Fail));
    let can_add = !has_end && edge.fail_policy.len() < LIMITS.max_steps;
    let add = Button::new(texts::ADD_STEP).icon(icon::PLUS).enabled(can_add).wide(ui);
    if add.show(ui, tokens).clicked() {
        steps.push(EdgeFailStep::Retry(CONFIG.tries));
    }
    (steps != edge.fail_policy).then_some(steps)
}

/// The number of a step, if it has one. Returns the step with another one.
fn show_number(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedNumber,
    edge: &Edge,
    index: usize,
    step: EdgeFailStep,
) -> Option<EdgeFailStep> {
    let (value, range, increment) = match step {
        EdgeFailStep::Retry(tries) => (f64::from(tries), LIMITS.tries, 1.0),
        EdgeFailStep::Wait(time) => (time.secs_f64(), LIMITS.waits_s, 10.0),
        EdgeFailStep::Replan | EdgeFailStep::Fail => return None,
    };
    let is_wait = matches!(step, EdgeFailStep::Wait(_));
    let name = texts::step_number(index + 1, is_wait);
    let field = NumberField {
        name: &name,
        object: ObjectId::Edge(edge.id),
        value: Some(value),
        hint: "",
        step: increment,
        decimals: 0,
        range,
    };
    let number = field.show(ui, cx, typed).flatten()?.round();
    Some(if is_wait {
        EdgeFailStep::Wait(Span::from_millis((number * 1e3) as i64))
    } else {
        EdgeFailStep::Retry(number as u8)
    })
}

/// The step of a place in [`texts::FAIL_STEPS`].
fn step_of(kind: usize) -> EdgeFailStep {
    match kind {
        0 => EdgeFailStep::Retry(CONFIG.tries),
        1 => EdgeFailStep::Wait(Span::from_millis((CONFIG.wait_s * 1e3) as i64)),
        2 => EdgeFailStep::Replan,
        _ => EdgeFailStep::Fail,
    }
}
