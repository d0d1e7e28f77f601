//! Tests of the product in a real browser.

mod example;
mod harness;
mod importing;
mod mapping;
mod missions;
mod operating;
mod own_building;
mod site_editor;
