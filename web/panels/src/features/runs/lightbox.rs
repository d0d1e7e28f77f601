//! Pictures and spectra large, over everything but the top bar: one, or side by side with the last one of the same inspection point.

use super::pane::{CommonAxes, Pane, ReadNeedle, halves, show_pane};
use super::picture_paint::show_note;
use super::picture_view::{PictureView, ZOOM};
use super::result_view::{ResultView, result_views, viewable};
use super::{look, texts};
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::theme::{self, GAP, Tokens, Weight};
use crate::{Width, icon, layout, screens, widgets};
use client_model::ResultFileKind;
use client_model::{ClientCommand, StoredResult};
use egui::{Align, Context, Key, Layout, Order, Rect, Sense, Ui, pos2, vec2};
use missions::SiteZone;
use site_model::{ActionReport, MissionId, ReportFile, RunId, Site};

/// What is looked at.
#[derive(Debug, Default)]
pub(super) struct Lightbox {
    /// The run, its mission, and the number of the result.
    open: Option<(RunId, MissionId, u64)>,
    is_compared: bool,
    view: PictureView,
}

impl Lightbox {
    /// Looks at a result.
    pub(super) fn look_at(&mut self, run: RunId, mission: MissionId, number: u64) {
        self.open = Some((run, mission, number));
        self.view = PictureView::default();
    }

    /// Whether something is looked at.
    pub(super) fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Closes it. Returns whether it was open.
    pub(super) fn close(&mut self) -> bool {
        self.open.take().is_some()
    }

    /// Reads keys.
    pub(super) fn update(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        if cx.screen() != screens::RUNS {
            self.open = None;
        }
        let Some((run, mission, number)) = self.open else { return };
        cx.frame.is_covered = true;
        let (Some(site), Some(Ok(content))) = (cx.model.site.site(), cx.model.runs.content(run)) else {
            return;
        };
        let step = ctx.input(|input| {
            let pressed = |key| i64::from(input.key_pressed(key));
            pressed(Key::ArrowRight) - pressed(Key::ArrowLeft)
        });
        if step != 0 {
            let all = result_views(site, mission, content);
            self.go(&all, number, step);
        }
    }

    /// Shows it.
    pub(super) fn show(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        let Some((run, mission, number)) = self.open else { return };
        // Whether or not Escape has just closed it, it was meant for that.
        cx.frame.is_escape_consumed = true;
        let model = cx.model;
        let (Some(site), Some(Ok(content))) = (model.site.site(), model.runs.content(run)) else { return };
        let all = result_views(site, mission, content);
        let Some(at) = all.iter().position(|it| it.result.number == number) else {
            self.open = None;
            return;
        };
        let window = ctx.content_rect();
        let min = pos2(window.left() + GAP, cx.layout.top.bottom() + GAP);
        let rect = Rect::from_min_max(min, window.max - vec2(GAP, GAP));
        layout::area(texts::LIGHTBOX, Order::Foreground).fixed_pos(rect.min).show(ctx, |ui| {
            theme::card(cx.tokens).fill(cx.tokens.card.to_opaque()).show(ui, |ui| {
                let inside =
                    rect.size() - egui::Vec2::splat(2.0 * (f32::from(theme::PADDING) + cx.tokens.line_width));
                ui.set_min_size(inside);
                ui.set_max_size(inside);
                self.show_content(ui, cx, site, mission, &all, at);
            });
        });
    }

    fn show_content(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        site: &Site,
        mission: MissionId,
        all: &[ResultView],
        at: usize,
    ) {
        let result_view = &all[at];
        let zone = site.settings().map_or("UTC", |settings| settings.time_zone.as_str());
        let zone = SiteZone::new(zone).unwrap_or_else(|_| SiteZone::utc());
        let previous = self.previous(cx, result_view);
        self.show_head(ui, cx, mission, all, at);
        let facts_height = 24.0;
        let room = vec2(ui.available_width(), (ui.available_height() - facts_height - 8.0).max(80.0));
        let (rect, _) = ui.allocate_exact_size(room, Sense::hover());
        let taken = |result: &StoredResult| texts::date_and_time(zone.to_local(result.at));
        let mut panes = vec![Pane {
            file: result_view.file.clone(),
            kind: result_view.kind,
            caption: texts::this_run(&taken(&result_view.result)),
            needle: ReadNeedle::of(&result_view.report),
            aligned: None,
            changes: None,
        }];
        let earlier = match &previous {
            Some(Ok(Some((result, report)))) => viewable(report).map(|shown| (result, report, shown)),
            _ => None,
        };
        if let Some((result, report, (file, kind))) = &earlier {
            let age_s = (result_view.result.at.0 - result.at.0) as f64 * 1e-9;
            let caption = texts::before(&taken(result), age_s);
            let needle = ReadNeedle::of(report);
            panes.insert(
                0,
                Pane { file: file.clone(), kind: *kind, caption, needle, aligned: None, changes: None },
            );
        }
        let places = if self.is_compared { halves(rect, cx.layout.width).to_vec() } else { vec![rect] };
        let places_of_panes = if panes.len() < places.len() { &places[1..] } else { &places[..] };
        let axes = CommonAxes::of(cx, &panes);
        for (pane, place) in panes.iter().zip(places_of_panes) {
            show_pane(ui, cx, pane, *place, axes, &mut self.view);
        }
        if self.is_compared && earlier.is_none() {
            let has_point = result_view.result.details.inspection_point.is_some();
            show_note(ui, cx.tokens, places[0], &texts::no_previous(has_point, previous.as_ref()));
        }
        if !self.is_compared {
            self.show_arrows(ui, cx.tokens, rect, all, at);
        }
        let difference =
            earlier.as_ref().and_then(|(_, report, _)| texts::difference(report, &result_view.report));
        let facts = texts::exhibit_facts(&result_view.report, difference.as_deref());
        ui.add(
            egui::Label::new(egui::RichText::new(facts).size(theme::SMALL).color(cx.tokens.dim)).truncate(),
        );
    }

    /// The result before this one at its inspection point, fetched while it is compared. None: it is not compared, or not fetched yet.
    fn previous(
        &self,
        cx: &mut PanelContext<'_>,
        result_view: &ResultView,
    ) -> Option<Result<Option<(StoredResult, ActionReport)>, String>> {
        let (point, before) = (result_view.result.details.inspection_point?, result_view.result.number);
        if !self.is_compared {
            return None;
        }
        match cx.model.runs.previous(point, before) {
            None => {
                cx.commands.push(ClientCommand::OpenPrevious { point, before });
                None
            }
            Some(Err(sentence)) => Some(Err(sentence.clone())),
            Some(Ok(result)) => {
                Some(Ok(result.as_ref().and_then(|result| Some((result.clone(), result.report()?)))))
            }
        }
    }

    fn show_head(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        mission: MissionId,
        all: &[ResultView],
        at: usize,
    ) {
        let (tokens, result_view) = (cx.tokens, &all[at]);
        let is_wide = cx.layout.width != Width::Narrow;
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            ui.set_min_height(theme::TOUCH);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if Button::icon_only(texts::CLOSE, icon::X).kind(Kind::Quiet).show(ui, tokens).clicked() {
                    self.open = None;
                }
                let name = texts::open_file(&result_view.file.name, &result_view.title);
                let open = Button::icon_only(&name, icon::DOWNLOAD_SIMPLE).kind(Kind::Quiet);
                if open.show(ui, tokens).clicked() {
                    open_blob(ui, &result_view.file);
                }
                if result_view.kind != ResultFileKind::Spectrum && is_wide {
                    self.show_zoom(ui, tokens);
                }
                let compare = Button::new(texts::COMPARE).icon(icon::SQUARE_HALF).on(self.is_compared);
                if compare
                    .slim()
                    .size(if is_wide { 172.0 } else { 120.0 }, theme::TOUCH)
                    .show(ui, tokens)
                    .clicked()
                {
                    self.is_compared = !self.is_compared;
                }
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    for (name, sign, step) in
                        [(texts::PREVIOUS, icon::CARET_LEFT, -1), (texts::NEXT, icon::CARET_RIGHT, 1)]
                    {
                        let button = Button::icon_only(name, sign).enabled(can_go(all, at, step));
                        if button.show(ui, tokens).clicked() {
                            self.go(all, result_view.result.number, step);
                        }
                    }
                    let value =
                        texts::result_view(at + 1, all.len(), &result_view.title, &result_view.action);
                    let title = (result_view.title.as_str(), theme::LARGE, Weight::SemiBold, tokens.text);
                    let mission = look::mission_name(cx.model, mission);
                    let rest = texts::exhibit_rest(at + 1, all.len(), &result_view.action, &mission);
                    let rest = (rest.as_str(), theme::BODY, Weight::Regular, tokens.dim);
                    let parts = if is_wide { vec![title, rest] } else { vec![title] };
                    widgets::status_line(ui, texts::PICTURE, &value, &parts);
                });
            });
        });
    }

    fn show_zoom(&mut self, ui: &mut Ui, tokens: &Tokens) {
        // From right to left.
        for (name, sign, factor) in [
            (texts::WHOLE, icon::CORNERS_OUT, None),
            (texts::ZOOM_IN, icon::PLUS, Some(ZOOM.step_factor)),
            (texts::ZOOM_OUT, icon::MINUS, Some(1.0 / ZOOM.step_factor)),
        ] {
            let is_possible =
                factor.is_some_and(|factor| factor > 1.0) || self.view != PictureView::default();
            let button = Button::icon_only(name, sign).kind(Kind::Quiet).enabled(is_possible);
            if button.show(ui, tokens).clicked() {
                match factor {
                    // Any pane will do: the middle stays the middle.
                    Some(factor) => {
                        let pane = Rect::from_min_size(pos2(0.0, 0.0), vec2(400.0, 300.0));
                        self.view.zoom_by(factor, pane.center(), pane, vec2(400.0, 300.0));
                    }
                    None => self.view = PictureView::default(),
                }
            }
        }
    }

    /// Large buttons at both sides, for fingers.
    fn show_arrows(&mut self, ui: &mut Ui, tokens: &Tokens, rect: Rect, all: &[ResultView], at: usize) {
        for (key, sign, step, x) in [
            ("back", icon::CARET_LEFT, -1, rect.left() + 34.0),
            ("on", icon::CARET_RIGHT, 1, rect.right() - 34.0),
        ] {
            if !can_go(all, at, step) {
                continue;
            }
            let place = Rect::from_center_size(pos2(x, rect.center().y), vec2(52.0, 88.0));
            let response = ui.interact(place, ui.scope_id().with(key), Sense::click());
            let opacity = if response.hovered() { 0.85 } else { 0.45 };
            ui.painter().rect_filled(
                place,
                f32::from(theme::CARD_RADIUS),
                tokens.card.gamma_multiply(opacity),
            );
            crate::paint::icon_at(ui, place.center(), sign, 24.0, tokens.text);
            if response.clicked() {
                self.go(all, all[at].result.number, step);
            }
        }
    }

    fn go(&mut self, all: &[ResultView], number: u64, step: i64) {
        let at = all.iter().position(|it| it.result.number == number).and_then(|at| i64::try_from(at).ok());
        let next = at.and_then(|at| usize::try_from(at + step).ok()).and_then(|next| all.get(next));
        if let (Some(next), Some((_, _, open))) = (next, &mut self.open) {
            *open = next.result.number;
            self.view = PictureView::default();
        }
    }
}

/// Opens a file in a tab of its own.
pub(super) fn open_blob(ui: &Ui, file: &ReportFile) {
    let address = api::paths::BLOB_PATH.replace("{hash}", &file.blob.to_string());
    ui.ctx().open_url(egui::OpenUrl::new_tab(address));
}

fn can_go(all: &[ResultView], at: usize, step: i64) -> bool {
    if step < 0 { at > 0 } else { at + 1 < all.len() }
}
