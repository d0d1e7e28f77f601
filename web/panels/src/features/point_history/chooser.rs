//! The choice of an inspection point: a button that unfolds all points, below the names of their assets if the site has assets.

use super::strip::ask;
use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::select::show_caption;
use crate::{theme, widgets};
use client_model::PointHistoryCommand;
use egui::{Popup, PopupCloseBehavior, ScrollArea, Ui};
use site_model::{Asset, InspectionPoint, Site};

/// Greatest height of the list, points. A longer one scrolls.
const MAX_LIST_HEIGHT: f32 = 360.0;

/// The points below a head.
struct Group<'a> {
    /// None: the site has no assets, so that there is nothing to tell apart.
    head: Option<&'a str>,
    points: Vec<&'a InspectionPoint>,
}

/// Shows the choice.
pub(super) fn show(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site) {
    let model = cx.model;
    let (points, assets) = (model.site.inspection_points(), model.site.assets());
    if points.is_empty() {
        return widgets::remark(ui, cx.tokens, texts::NO_POINTS);
    }
    show_caption(ui, cx.tokens, texts::POINT);
    let open = model.point_history.point();
    let named =
        open.map(|open| site.inspection_point(open).map_or(texts::DELETED_POINT, |point| &point.name));
    let width = ui.available_width();
    let button = Button::new(texts::POINT).text(named.unwrap_or(texts::CHOOSE)).caret().left();
    let button = button.size(width, theme::TOUCH).show(ui, cx.tokens);
    Popup::menu(&button)
        .close_behavior(PopupCloseBehavior::CloseOnClick)
        .accessible_name(texts::POINT)
        .width(width)
        .show(|ui| {
            ScrollArea::vertical().max_height(MAX_LIST_HEIGHT).show(ui, |ui| {
                ui.spacing_mut().item_spacing.y = 2.0;
                for group in grouped(&points, &assets) {
                    if let Some(head) = group.head {
                        widgets::remark(ui, cx.tokens, head);
                    }
                    for point in group.points {
                        let is_open = open == Some(point.id);
                        let entry = Button::new(&point.name).kind(Kind::Quiet).on(is_open).wide(ui).left();
                        if ui.push_id(point.id, |ui| entry.show(ui, cx.tokens)).inner.clicked() {
                            ask(cx, PointHistoryCommand::Open(point.id));
                        }
                    }
                }
            });
        });
}

/// The points of each asset that has any, then those without one.
fn grouped<'a>(points: &[&'a InspectionPoint], assets: &[&'a Asset]) -> Vec<Group<'a>> {
    let of = |wanted: &dyn Fn(&InspectionPoint) -> bool| -> Vec<&'a InspectionPoint> {
        points.iter().copied().filter(|point| wanted(point)).collect()
    };
    let is_known = |point: &InspectionPoint| assets.iter().any(|asset| point.asset == Some(asset.id));
    let mut groups: Vec<Group<'a>> = assets
        .iter()
        .map(|asset| {
            let points = of(&|point| point.asset == Some(asset.id));
            Group { head: Some(asset.name.as_str()), points }
        })
        .collect();
    let head = (!assets.is_empty()).then_some(texts::WITHOUT_ASSET);
    groups.push(Group { head, points: of(&|point| !is_known(point)) });
    groups.retain(|group| !group.points.is_empty());
    groups
}
