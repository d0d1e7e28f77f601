//! Monitors by their panel.

use crate::screens;
use crate::test_support::missions::{client, press, type_into, undo};
use crate::test_support::{TestClient, click};
use client_model::ClientCommand;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use site_model::{Monitor, MonitorCondition, MonitorResponse, Resumption};

/// The tab of monitors, of a site with a mission.
fn shown<'a>() -> Harness<'a, TestClient> {
    let client = client();
    let (_, edit) = client.model.site.adding_mission();
    let client = client.command(ClientCommand::EditSite(edit)).on(screens::SETTINGS);
    let mut harness = client.shown(1440.0, 1600.0);
    press(&mut harness, "Monitors");
    harness
}

fn monitor(harness: &Harness<'_, TestClient>, index: usize) -> Monitor {
    harness.state().model.site.monitors()[index].0.clone()
}

/// Chooses an entry of a list that a button unfolds.
fn choose(harness: &mut Harness<'_, TestClient>, list: &str, entry: &str) {
    press(harness, list);
    press(harness, entry);
}

#[test]
fn the_built_in_battery_monitor_is_changed_and_given_its_values_back() {
    let mut harness = shown();
    press(&mut harness, "Monitor Battery low");
    assert!(harness.query_by_label_contains("Battery charge below 20 %").is_some());
    type_into(&mut harness, "Below (%)", "35");
    press(&mut harness, "Less: Until above (%)");
    let condition = MonitorCondition::Below { threshold: 0.35, release: 0.75 };
    assert_eq!(monitor(&harness, 0).condition, condition);
    // What ends it is never below what begins it.
    type_into(&mut harness, "Until above (%)", "10");
    let condition = MonitorCondition::Below { threshold: 0.35, release: 0.35 };
    assert_eq!(monitor(&harness, 0).condition, condition);
    press(&mut harness, "Ends");
    let dropped = MonitorResponse::GoToDock { afterwards: Resumption::Drop };
    assert_eq!(monitor(&harness, 0).response, dropped);
    press(&mut harness, "It is watched");
    assert!(!monitor(&harness, 0).is_enabled);
    undo(&mut harness);
    assert!(monitor(&harness, 0).is_enabled);
    press(&mut harness, "Use the built-in values of Battery low");
    let built_in = MonitorCondition::Below { threshold: 0.2, release: 0.8 };
    assert_eq!(monitor(&harness, 0).condition, built_in);
    undo(&mut harness);
    assert_eq!(monitor(&harness, 0).response, dropped);
}

#[test]
fn a_new_monitor_blocks_missions_and_can_do_all_else() {
    let mut harness = shown();
    press(&mut harness, "New monitor");
    assert_eq!(monitor(&harness, 2).response, MonitorResponse::BlockMissions);
    choose(&mut harness, "What happens", "A mission interrupts");
    assert!(matches!(monitor(&harness, 2).response, MonitorResponse::Interrupt { .. }));
    choose(&mut harness, "What happens", "People are told");
    assert_eq!(monitor(&harness, 2).response, MonitorResponse::Notify);
    press(&mut harness, "Silent");
    press(&mut harness, "More: Silent for (s)");
    let MonitorCondition::Silent(time) = monitor(&harness, 2).condition else { panic!("not silent") };
    assert_eq!(time.secs_f64(), 65.0);
    choose(&mut harness, "Signal", "Charge beyond the way to a dock");
    assert_eq!(monitor(&harness, 2).signal, "battery.reserve");
    click(&mut harness, "Monitor Monitor 1");
    assert!(harness.query_by_label("Signal").is_none(), "folded");
    press(&mut harness, "Monitor Monitor 1");
    press(&mut harness, "Delete monitor Monitor 1");
    assert_eq!(harness.state().model.site.monitors().len(), 2);
    undo(&mut harness);
    assert_eq!(harness.state().model.site.monitors().len(), 3);
}
