//! The next run that schedules begin, for the top bar of every screen.

use super::plan_cache::{MINUTE_NS, UTC};
use super::texts;
use crate::feature_panel::PanelContext;
use crate::icon;
use crate::next_run_texts::NextRunTexts;
use crate::status_line::{StatusDetail, StatusLine};
use crate::theme::{self, Weight};
use client_model::plan_schedules;
use missions::SiteZone;
use site_model::{Site, Utc};

/// Parameters of the search for the next run.
struct NextRunConfig {
    /// How far it is looked ahead, days. Chosen: a weekly schedule has one within it.
    outlook_days: i64,
}

const CONFIG: NextRunConfig = NextRunConfig { outlook_days: 7 };

/// The next run, computed once for each change of the site and each minute.
#[derive(Debug, Default)]
pub(super) struct NextRun {
    computed_for: Option<(u64, i64)>,
}

impl NextRun {
    /// Brings what the frame shows up to date.
    pub(super) fn update(&mut self, cx: &mut PanelContext<'_>) {
        let Some(site) = cx.model.site.site() else { return };
        let now = cx.clock.utc;
        let key = (cx.model.site.revision(), now.0.div_euclid(MINUTE_NS));
        if self.computed_for.replace(key) != Some(key) {
            cx.frame.next_run = next_run(site, now);
        }
    }
}

fn next_run(site: &Site, now: Utc) -> Option<NextRunTexts> {
    let zone_name = site.settings().map_or(UTC, |settings| settings.time_zone.as_str());
    let zone = SiteZone::new(zone_name).unwrap_or_else(|_| SiteZone::utc());
    let until = Utc(now.0 + CONFIG.outlook_days * 24 * 60 * MINUTE_NS);
    let plan = plan_schedules(site, &zone, Utc(now.0 + 1), until);
    let next = plan.occurrences.iter().find(|it| it.is_planned())?;
    let schedule = site.schedule(next.schedule)?.name.clone();
    let (at, today) = (zone.to_local(next.due), zone.to_local(now).date);
    Some(NextRunTexts { at: texts::next_run(at, today), schedule })
}

/// The status in the top bar; `None` where nothing is planned or there is no room.
pub(crate) fn next_run_status(cx: &PanelContext<'_>, detail: StatusDetail) -> Option<StatusLine> {
    let next = cx.frame.next_run.as_ref().filter(|_| detail >= StatusDetail::Normal)?;
    let value = format!("{} {}", next.at, next.schedule);
    let line = StatusLine::new(texts::NEXT_RUN, &value).hint(texts::next_run_hint(&value));
    let line = if detail == StatusDetail::Full {
        line.text(texts::NEXT_RUN, cx.tokens.dim)
    } else {
        line.icon(icon::CALENDAR_DOTS, cx.tokens.dim)
    };
    let shown = if detail == StatusDetail::Full { &value } else { &next.at };
    Some(line.part(shown, theme::BODY, Weight::Medium, cx.tokens.text))
}
