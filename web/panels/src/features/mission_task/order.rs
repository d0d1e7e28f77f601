//! Which tasks a task comes after or before, whatever the order of the mission.

use super::{numbered_title, push_edit, texts};
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::select::select;
use crate::{icon, widgets};
use client_model::constraints_against_list;
use egui::Ui;
use site_model::{Mission, Site, Task, TaskId, find_order_cycle};

/// The order constraints of a task: the list of them, each with what removes it, and two choices that add one.
pub(super) fn show(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, mission: &Mission, task: &Task) {
    let tokens = cx.tokens;
    widgets::remark(ui, tokens, texts::ORDER_HEAD);
    let of_task = mission.order_constraints.iter().filter(|pair| pair.contains(&task.id));
    for constraint in of_task {
        let other = if constraint[0] == task.id { constraint[1] } else { constraint[0] };
        let row = texts::order_row(constraint[1] == task.id, &numbered_title(site, mission, other));
        show_removal(ui, cx, mission, *constraint, &row);
    }
    let others: Vec<TaskId> = mission.tasks.iter().map(|it| it.id).filter(|id| *id != task.id).collect();
    if others.is_empty() {
        return;
    }
    let options: Vec<String> = others.iter().map(|id| numbered_title(site, mission, *id)).collect();
    ui.columns(2, |columns| {
        for (column, (ui, name)) in columns.iter_mut().zip([texts::ADD_AFTER, texts::ADD_BEFORE]).enumerate()
        {
            if let Some(index) = select(ui, tokens, name, name, texts::CHOOSE_TASK, &options) {
                let [first, second] =
                    if column == 0 { [others[index], task.id] } else { [task.id, others[index]] };
                push_edit(cx, cx.model.site.constraining_order(mission.id, first, second));
            }
        }
    });
}

/// What is wrong with the order constraints of a mission: a circle of them, or a list that does not meet them, each with what mends it.
pub(crate) fn show_problems(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, mission: &Mission) {
    let tokens = cx.tokens;
    if let Some(circle) = find_order_cycle(&mission.order_constraints) {
        widgets::tinted_box(ui, tokens, tokens.bad, |ui| {
            let titles: Vec<String> = circle.iter().map(|id| numbered_title(site, mission, *id)).collect();
            show_problem(ui, cx, &texts::circle(&titles));
            for (index, first) in circle.iter().enumerate() {
                let next = (index + 1) % circle.len();
                let row = texts::before_row(&titles[index], &titles[next]);
                show_removal(ui, cx, mission, [*first, circle[next]], &row);
            }
        });
        return;
    }
    // A mission that takes the shortest order meets them by itself.
    let against = constraints_against_list(mission);
    let Some([first, second]) = against.first() else { return };
    if mission.order != site_model::TaskOrder::AsListed {
        return;
    }
    widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
        let titles = [first, second].map(|id| numbered_title(site, mission, *id));
        show_problem(ui, cx, &texts::against_list(&titles));
        let mend = Button::new(texts::MEND_LIST).icon(icon::ARROWS_DOWN_UP).wide(ui);
        if mend.show(ui, tokens).clicked() {
            push_edit(cx, cx.model.site.listing_in_constrained_order(mission.id));
        }
    });
}

fn show_problem(ui: &mut Ui, cx: &PanelContext<'_>, sentence: &str) {
    let text = egui::RichText::new(sentence).size(crate::theme::BODY).color(cx.tokens.text);
    let response = ui.add(egui::Label::new(text).wrap());
    widgets::status_node(&response, texts::ORDER_PROBLEM, sentence);
}

/// A constraint, which a press removes.
fn show_removal(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    mission: &Mission,
    constraint: [TaskId; 2],
    row: &str,
) {
    let name = texts::remove_order(row);
    let button = Button::new(&name).text(row).icon(icon::X).kind(Kind::Quiet).wide(ui).left();
    if ui.push_id(constraint, |ui| button.show(ui, cx.tokens)).inner.clicked() {
        push_edit(cx, cx.model.site.freeing_order(mission.id, constraint));
    }
}
