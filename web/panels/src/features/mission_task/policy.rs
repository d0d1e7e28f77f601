//! The form of a failure policy: further tries, and what happens after the last one.

use super::texts;
use crate::select::select;
use crate::theme::Tokens;
use crate::widgets;
use egui::Ui;
use site_model::{AskDefault, FailurePolicy, FailureStep};
use vocab::Span;

/// What a new step of a policy has.
#[derive(Clone, Copy, Debug)]
struct NewQuestionConfig {
    /// How long a person is asked unless another time is chosen. Chosen: a quarter of an hour, in which a person who has something else to do looks at the screen.
    time: Span,
}

const NEW_QUESTION: NewQuestionConfig = NewQuestionConfig { time: Span::from_millis(15 * 60_000) };

/// Shows a policy. Returns another one once it is chosen.
pub(super) fn show(ui: &mut Ui, tokens: &Tokens, head: &str, policy: FailurePolicy) -> Option<FailurePolicy> {
    widgets::remark(ui, tokens, head);
    let mut chosen = None;
    let counts: Vec<String> = texts::RETRIES.iter().map(|count| texts::retries(*count)).collect();
    let steps: Vec<String> = texts::STEPS.iter().map(|step| (*step).to_owned()).collect();
    ui.horizontal_top(|ui| {
        let (name, shown) = (texts::of_policy(head, texts::FURTHER_TRIES), texts::retries(policy.retries));
        let full = ui.available_width();
        ui.vertical(|ui| {
            ui.set_width(96.0);
            if let Some(index) = select(ui, tokens, &name, texts::FURTHER_TRIES, &shown, &counts) {
                chosen = Some(FailurePolicy { retries: texts::RETRIES[index], ..policy });
            }
        });
        ui.vertical(|ui| {
            ui.set_width(full - 96.0 - ui.spacing().item_spacing.x);
            let (name, shown) =
                (texts::of_policy(head, texts::THEN), texts::STEPS[texts::step_index(policy.then)]);
            if let Some(index) = select(ui, tokens, &name, texts::THEN, shown, &steps) {
                chosen = Some(FailurePolicy { then: step_of(index, policy.then), ..policy });
            }
        });
    });
    if let FailureStep::Ask { time_limit, default } = policy.then {
        chosen = chosen.or(show_question(ui, tokens, head, (time_limit, default), policy));
    }
    chosen
}

/// How long a person is asked, and what happens without an answer.
fn show_question(
    ui: &mut Ui,
    tokens: &Tokens,
    head: &str,
    (time_limit, default): (Span, AskDefault),
    policy: FailurePolicy,
) -> Option<FailurePolicy> {
    let minutes = (time_limit.secs_f64() / 60.0).round() as i64;
    let times: Vec<String> = texts::ASK_MINUTES.iter().map(|minutes| texts::minutes(*minutes)).collect();
    let name = texts::of_policy(head, texts::ASK_TIME);
    if let Some(index) = select(ui, tokens, &name, texts::ASK_TIME, &texts::minutes(minutes), &times) {
        let time_limit = Span::from_millis(texts::ASK_MINUTES[index] * 60_000);
        return Some(FailurePolicy { then: FailureStep::Ask { time_limit, default }, ..policy });
    }
    let defaults: Vec<String> = texts::ASK_DEFAULTS.iter().map(|(name, _)| (*name).to_owned()).collect();
    let shown = texts::ASK_DEFAULTS.iter().find(|(_, it)| *it == default).map_or("", |(name, _)| name);
    let name = texts::of_policy(head, texts::ASK_DEFAULT);
    let index = select(ui, tokens, &name, texts::ASK_DEFAULT, shown, &defaults)?;
    let default = texts::ASK_DEFAULTS[index].1;
    Some(FailurePolicy { then: FailureStep::Ask { time_limit, default }, ..policy })
}

/// The step of a place in the list. A question keeps its time and default.
fn step_of(index: usize, before: FailureStep) -> FailureStep {
    match index {
        0 => FailureStep::Skip,
        1 => FailureStep::TryLater,
        2 => FailureStep::EndAtDock,
        3 => FailureStep::EndHere,
        _ if matches!(before, FailureStep::Ask { .. }) => before,
        _ => FailureStep::Ask { time_limit: NEW_QUESTION.time, default: AskDefault::Skip },
    }
}
