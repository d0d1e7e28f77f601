//! Assets by their panel.

use crate::screens;
use crate::test_support::missions::{client, press, type_into, undo};
use client_model::Selection;
use egui_kittest::kittest::Queryable;

#[test]
fn an_asset_is_made_named_tagged_given_a_point_and_deleted() {
    let mut harness = client().on(screens::SITE).shown(1440.0, 2400.0);
    press(&mut harness, "Assets");
    press(&mut harness, "New asset");
    type_into(&mut harness, "Asset name", "Pump 3");
    type_into(&mut harness, "Tags", "cooling, hall 4");
    let asset = harness.state().model.site.assets()[0].clone();
    assert_eq!(asset.name, "Pump 3");
    assert_eq!(asset.tags.iter().collect::<Vec<_>>(), ["cooling", "hall 4"]);

    let point = harness.state().model.site.inspection_points()[0].id;
    press(&mut harness, "Inspection points");
    press(&mut harness, "Inspection point P2");
    press(&mut harness, "Asset");
    press(&mut harness, "Pump 3");
    assert_eq!(harness.state().model.site.points_of_asset(asset.id)[0].id, point);
    press(&mut harness, "Assets");
    press(&mut harness, "Select inspection point P2");
    assert_eq!(harness.state().model.selection(), Some(Selection::InspectionPoint(point)));

    press(&mut harness, "Assets");
    press(&mut harness, "Delete asset Pump 3");
    assert!(harness.state().model.site.assets().is_empty());
    assert_eq!(harness.state().model.site.inspection_points()[0].asset, None);
    undo(&mut harness);
    assert_eq!(harness.state().model.site.points_of_asset(asset.id).len(), 1);
}

#[test]
fn a_long_list_of_assets_is_searched_by_name_and_tag() {
    let mut harness = client().on(screens::SITE).shown(1440.0, 2400.0);
    press(&mut harness, "Assets");
    for _ in 0..8 {
        press(&mut harness, "New asset");
    }
    type_into(&mut harness, "Tags", "valve");
    type_into(&mut harness, "Find an asset", "VALV");
    assert!(harness.query_by_label("Asset Asset 8").is_some());
    assert!(harness.query_by_label("Asset Asset 1").is_none());
}
