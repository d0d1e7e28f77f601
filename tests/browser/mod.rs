//! Tests of the product in a real browser.

mod alerts;
mod every_screen;
mod example;
mod first_day;
mod harness;
mod importing;
mod mapping;
mod missions;
mod operating;
mod own_building;
mod scene_changes;
mod sign_in;
mod site_editor;
