//! The draft of the site: what it changes, what that breaks, and its end: published or discarded.

mod row_kind;
mod rows;
#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::message::show_message;
use crate::widgets::{self, fact};
use crate::{icon, screens};
use client_model::{ClientCommand, DraftCommand};
use egui::Ui;
use row_kind::RowKind;
use rows::{DraftRow, rows_of};

/// The tab of the draft.
const DRAFT: Tab = Tab { screen: screens::SITE, name: texts::TAB, scrolls: true, row_spacing: 8.0 };
/// How much of a draft is listed.
#[derive(Clone, Copy, Debug)]
struct DraftListConfig {
    /// Largest number of objects that are listed at once. Chosen: the whole list is laid out in each frame, and nobody reads more.
    max_rows: usize,
    /// Largest number of fields that are listed of an object. Chosen: a card stays readable.
    max_fields: usize,
}

const LISTS: DraftListConfig = DraftListConfig { max_rows: 100, max_fields: 8 };

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct SiteDraftPanel {
    /// What the draft changes, with the revision of the site that it was compared with.
    rows: Option<(u64, Vec<DraftRow>)>,
}

impl FeaturePanel for SiteDraftPanel {
    fn update(&mut self, _ctx: &egui::Context, cx: &mut PanelContext<'_>) {
        let revision = cx.model.site.revision();
        if self.rows.as_ref().is_none_or(|(of, _)| *of != revision) {
            self.rows = Some((revision, rows_of(&cx.model.site)));
        }
    }

    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let edits_site =
            [screens::SITE, screens::MISSIONS, screens::SCHEDULE, screens::SETTINGS].contains(&cx.screen());
        let is_shown = cx.screen() == screens::SITE && cx.frame.tab_of(screens::SITE) == Some(DRAFT);
        if !cx.model.site.is_draft() || !edits_site || is_shown {
            return;
        }
        let sentence = texts::banner(self.rows().len());
        show_message(ui, cx.tokens, cx.tokens.warn, icon::PENCIL_SIMPLE, &sentence, |ui| {
            if Button::new(texts::SHOW).text(texts::SHOW_SHORT).show(ui, cx.tokens).clicked() {
                cx.frame.open_tab(DRAFT);
                cx.frame.drawer_open = true;
                cx.commands.push(ClientCommand::ShowScreen(screens::SITE));
            }
        });
    }

    fn tabs(&self) -> &'static [Tab] {
        &[DRAFT]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::HEAD);
        if cx.model.site.site().is_none() {
            return widgets::remark(ui, tokens, texts::LOADING);
        }
        if !cx.model.site.is_draft() {
            widgets::sentence(ui, tokens, texts::EXPLANATION);
            let begin = Button::new(texts::BEGIN).icon(icon::PENCIL_SIMPLE);
            if begin.kind(Kind::Primary).wide(ui).show(ui, tokens).clicked() {
                send(cx, DraftCommand::Begin);
            }
            return;
        }
        let rows = self.rows();
        let conflicts = rows.iter().filter(|row| row.theirs.is_some()).count();
        fact(ui, tokens, texts::CHANGES, &rows.len().to_string());
        if conflicts > 0 {
            widgets::sentence(ui, tokens, &texts::conflicts(conflicts));
        }
        let can_publish = !rows.is_empty() && conflicts == 0;
        let publish = Button::new(texts::PUBLISH).icon(icon::UPLOAD_SIMPLE).kind(Kind::Primary);
        if publish.enabled(can_publish).wide(ui).show(ui, tokens).clicked() {
            send(cx, DraftCommand::Publish);
        }
        let (end, kind) =
            if rows.is_empty() { (texts::END, Kind::Plain) } else { (texts::DISCARD, Kind::Danger) };
        if Button::new(end).kind(kind).hint(texts::DISCARD_HINT).wide(ui).show(ui, tokens).clicked() {
            send(cx, DraftCommand::Discard);
        }
        if rows.is_empty() {
            widgets::remark(ui, tokens, texts::EMPTY);
        }
        for row in rows.iter().take(LISTS.max_rows) {
            show_row(ui, cx, row);
        }
        if rows.len() > LISTS.max_rows {
            widgets::remark(ui, tokens, &texts::more(rows.len() - LISTS.max_rows));
        }
    }
}

impl SiteDraftPanel {
    fn rows(&self) -> &[DraftRow] {
        self.rows.as_ref().map_or(&[], |(_, rows)| rows)
    }
}

/// An object: what becomes of it, field by field, what that breaks, and the choice where somebody else has changed it too.
fn show_row(ui: &mut Ui, cx: &mut PanelContext<'_>, row: &DraftRow) {
    let tokens = cx.tokens;
    let (sign, colour) = match row.kind {
        RowKind::Added => (icon::PLUS, tokens.good),
        RowKind::Changed => (icon::PENCIL_SIMPLE, tokens.accent),
        RowKind::Removed => (icon::TRASH, tokens.bad),
    };
    let colour = if row.theirs.is_some() { tokens.warn } else { colour };
    widgets::tinted_box(ui, tokens, colour, |ui| {
        ui.spacing_mut().item_spacing.y = 4.0;
        let name = texts::row(row.kind, &row.name);
        let is_in_scene = row.selection.is_some() && row.kind != RowKind::Removed;
        let head = Button::new(&name).icon(sign).kind(Kind::Quiet).enabled(is_in_scene).left();
        if head.wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::Select(row.selection));
        }
        for change in row.fields.iter().take(LISTS.max_fields) {
            widgets::sentence(ui, tokens, &texts::field(change));
        }
        if row.fields.len() > LISTS.max_fields {
            widgets::remark(ui, tokens, &texts::more_fields(row.fields.len() - LISTS.max_fields));
        }
        if !row.breaks.is_empty() {
            widgets::remark(ui, tokens, &texts::breaks(&row.breaks));
        }
        let Some(theirs) = &row.theirs else { return };
        widgets::sentence(ui, tokens, texts::THEIRS);
        for change in theirs.iter().take(LISTS.max_fields) {
            widgets::sentence(ui, tokens, &texts::field(change));
        }
        ui.horizontal(|ui| {
            let width = 0.5 * (ui.available_width() - ui.spacing().item_spacing.x);
            for (name, short, keep_mine) in [
                (texts::keep_mine(&row.name), texts::MINE, true),
                (texts::take_theirs(&row.name), texts::THEIRS_SHORT, false),
            ] {
                let button = Button::new(&name).text(short).size(width, crate::theme::TOUCH);
                if button.slim().show(ui, tokens).clicked() {
                    send(cx, DraftCommand::Resolve { object: row.id, keep_mine });
                }
            }
        });
    });
}

fn send(cx: &mut PanelContext<'_>, command: DraftCommand) {
    cx.commands.push(ClientCommand::Draft(command));
}
