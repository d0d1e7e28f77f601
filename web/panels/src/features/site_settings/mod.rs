//! What holds for the whole site: its name and time zone; and what is told of robot and data.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::name_field::MAX_NAME_CHARS;
use crate::widgets::{self, fact};
use crate::{TextInput, TextInputKind, format, icon, screens};
use client_model::{ClientCommand, SiteEdit};
use egui::Ui;
use missions::SiteZone;
use site_model::{Object, Site, SiteSettings};

/// The tab of settings.
const SETTINGS: Tab = Tab { screen: screens::SETTINGS, name: texts::TAB, scrolls: true, row_spacing: 8.0 };
/// How many time zones are listed.
#[derive(Clone, Copy, Debug)]
struct ZoneListConfig {
    /// Time zones that are listed at once. Chosen: they fit without scrolling.
    max_zones: usize,
}

const LISTS: ZoneListConfig = ZoneListConfig { max_zones: 12 };
/// Time zone of a site that nobody has told one.
const UTC: &str = "UTC";

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct SiteSettingsPanel {
    /// The name that is typed, with the one that it replaces.
    typed: Option<(String, String)>,
    /// What is typed to find a time zone.
    zone_search: String,
    /// Whether another time zone is chosen.
    is_choosing_zone: bool,
}

impl FeaturePanel for SiteSettingsPanel {
    fn tabs(&self) -> &'static [Tab] {
        &[SETTINGS]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        widgets::head(ui, cx.tokens, texts::SITE_HEAD);
        match cx.model.site.site() {
            Some(site) => {
                let settings = settings_of(site);
                self.show_name(ui, cx, &settings);
                self.show_zone(ui, cx, &settings);
            }
            None => widgets::remark(ui, cx.tokens, texts::LOADING),
        }
        show_robot(ui, cx);
        show_data(ui, cx);
    }
}

/// The settings of a site, or those of a site that nobody has told anything.
fn settings_of(site: &Site) -> SiteSettings {
    site.settings().cloned().unwrap_or_else(|| SiteSettings {
        name: texts::UNNAMED_SITE.to_owned(),
        time_zone: UTC.to_owned(),
        map: None,
    })
}

fn put(cx: &mut PanelContext<'_>, settings: SiteSettings) {
    let edit = SiteEdit { put: vec![Object::Settings(settings)], removed: Vec::new() };
    cx.commands.push(ClientCommand::EditSite(edit));
}

impl SiteSettingsPanel {
    fn show_name(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, settings: &SiteSettings) {
        let tokens = cx.tokens;
        if self.typed.as_ref().is_none_or(|(_, replaced)| *replaced != settings.name) {
            self.typed = Some((settings.name.clone(), settings.name.clone()));
        }
        let Some((typed, _)) = &mut self.typed else { return };
        let field = TextInput::new("site name", texts::NAME).max_length(MAX_NAME_CHARS);
        let response = field.show(ui, tokens, cx.text_inputs, typed);
        let name = typed.trim().to_owned();
        let is_new = !name.is_empty() && name != settings.name;
        let rename = Button::new(texts::RENAME).enabled(is_new).wide(ui).show(ui, tokens);
        if is_new && (rename.clicked() || response.submitted) {
            put(cx, SiteSettings { name, ..settings.clone() });
        }
    }

    fn show_zone(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, settings: &SiteSettings) {
        let tokens = cx.tokens;
        fact(ui, tokens, texts::ZONE, &settings.time_zone);
        match SiteZone::new(&settings.time_zone) {
            Ok(zone) => {
                fact(ui, tokens, texts::SITE_TIME, &texts::clock(zone.to_local(cx.clock.utc)));
            }
            Err(error) => widgets::tinted_box(ui, tokens, tokens.bad, |ui| {
                widgets::sentence(ui, tokens, &texts::unknown_zone(&error.to_string()));
            }),
        }
        widgets::remark(ui, tokens, texts::ZONE_REMARK);
        let yours = cx.clock.zone.as_str();
        if yours != settings.time_zone && SiteZone::new(yours).is_ok() {
            let name = texts::use_zone(yours);
            if Button::new(&name).wide(ui).show(ui, tokens).clicked() {
                put(cx, SiteSettings { time_zone: yours.to_owned(), ..settings.clone() });
            }
        }
        let choose = Button::new(texts::CHOOSE_ZONE).icon(icon::CLOCK_COUNTDOWN).on(self.is_choosing_zone);
        if choose.wide(ui).show(ui, tokens).clicked() {
            self.is_choosing_zone = !self.is_choosing_zone;
            self.zone_search.clear();
        }
        if self.is_choosing_zone {
            self.show_zones(ui, cx, settings);
        }
    }

    /// The zones whose name has what is typed, each with its present time.
    fn show_zones(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, settings: &SiteSettings) {
        let tokens = cx.tokens;
        let field = TextInput::new("time zone", texts::FIND_ZONE).hint(texts::FIND_ZONE_HINT);
        field.kind(TextInputKind::Search).show(ui, tokens, cx.text_inputs, &mut self.zone_search);
        let wanted = self.zone_search.trim().to_lowercase().replace(' ', "_");
        let found: Vec<&str> = SiteZone::names()
            .filter(|name| name.to_lowercase().contains(&wanted))
            .take(LISTS.max_zones + 1)
            .collect();
        if found.is_empty() {
            widgets::remark(ui, tokens, texts::NO_ZONE_FOUND);
        }
        for name in found.iter().take(LISTS.max_zones) {
            let Ok(zone) = SiteZone::new(name) else { continue };
            let row = texts::zone_row(name, zone.to_local(cx.clock.utc));
            let accessible = texts::zone(name);
            let button = Button::new(&accessible).text(&row).left().kind(Kind::Quiet);
            let button = button.on(settings.time_zone == *name);
            if button.wide(ui).show(ui, tokens).clicked() {
                put(cx, SiteSettings { time_zone: (*name).to_owned(), ..settings.clone() });
                self.is_choosing_zone = false;
            }
        }
        if found.len() > LISTS.max_zones {
            widgets::remark(ui, tokens, texts::MORE_ZONES);
        }
    }
}

/// What the robot has told of itself.
fn show_robot(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let tokens = cx.tokens;
    widgets::section_head(ui, tokens, texts::ROBOT_HEAD);
    let Some(platform) = cx.model.platform.report() else {
        return widgets::remark(ui, tokens, texts::ROBOT_SILENT);
    };
    fact(ui, tokens, texts::ROBOT_NAME, &platform.robot);
    if let Some(site) = &platform.site {
        fact(ui, tokens, texts::SIMULATED_SITE, site);
    }
    for (limits, [forward, sideways, turn]) in
        [(&platform.manual_limits, texts::BY_HAND), (&platform.autonomous_limits, texts::BY_ITSELF)]
    {
        if let Some(limits) = limits {
            fact(ui, tokens, forward, &format::speed(limits.forward_m_s));
            fact(ui, tokens, sideways, &format::speed(limits.sideways_m_s));
            fact(ui, tokens, turn, &texts::turn_rate(limits.turn_rad_s));
        }
    }
    if let Some(body) = &platform.body {
        let lengths_m =
            [body.footprint_radius_m, body.clearance_height_m, body.standing_height_m, body.step_height_m];
        for (name, length_m) in texts::BODY.into_iter().zip(lengths_m) {
            fact(ui, tokens, name, &format::accuracy(length_m));
        }
        let head = &body.camera_head;
        fact(ui, tokens, texts::PAN, &texts::angles([-head.pan_max_rad, head.pan_max_rad]));
        fact(ui, tokens, texts::TILT, &texts::angles([head.tilt_min_rad, head.tilt_max_rad]));
        fact(ui, tokens, texts::VIEW, &texts::angle(head.field_of_view_rad));
        fact(ui, tokens, texts::ZOOM, &texts::zoom(head.zoom_max));
    }
    widgets::remark(ui, tokens, texts::PROFILE_REMARK);
}

/// What is stored, and the room that is left.
fn show_data(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let tokens = cx.tokens;
    widgets::section_head(ui, tokens, texts::DATA_HEAD);
    if let Some(platform) = cx.model.platform.report() {
        let free_bytes = platform.disk_free_bytes;
        if let Some(disk) = platform.disk {
            let used_bytes = disk.total_bytes.saturating_sub(free_bytes);
            fact(ui, tokens, texts::USED_DISK, &texts::bytes_of(used_bytes, disk.total_bytes));
            let recordings = texts::bytes_of(disk.recordings_bytes, disk.max_recordings_bytes);
            fact(ui, tokens, texts::RECORDINGS, &recordings);
            widgets::remark(ui, tokens, texts::RECORDINGS_REMARK);
        }
        fact(ui, tokens, texts::FREE_DISK, &format::bytes(free_bytes));
    }
    let maps = cx.model.maps().list().unwrap_or_default();
    let bytes: u64 = maps.iter().map(|map| map.bytes).sum();
    fact(ui, tokens, texts::MAPS, &texts::maps(maps.len(), bytes));
    if let Some(site) = cx.model.site.site() {
        let mission_count = site.missions().count();
        fact(ui, tokens, texts::PLAN, &texts::plan(mission_count, site.schedules().count()));
        fact(ui, tokens, texts::NODES, &site.nodes().count().to_string());
    }
    for (name, sign, command) in [
        (texts::SAVE, icon::DOWNLOAD_SIMPLE, ClientCommand::SavePlanFile),
        (texts::LOAD, icon::UPLOAD_SIMPLE, ClientCommand::LoadPlanFile),
    ] {
        if Button::new(name).icon(sign).wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(command);
        }
    }
}
