//! Tests of the product in a real browser.

mod harness;
mod importing;
mod mapping;
mod missions;
mod operating;
mod own_building;
