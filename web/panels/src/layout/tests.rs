//! Cards in windows of all widths.

use crate::{Layout, Width};
use egui::{Rect, pos2, vec2};

#[test]
fn cards_keep_apart_and_inside_the_window() {
    for (width, height, expected) in
        [(1440.0, 900.0, Width::Wide), (1024.0, 768.0, Width::Medium), (390.0, 844.0, Width::Narrow)]
    {
        let window = Rect::from_min_size(pos2(0.0, 0.0), vec2(width, height));
        let layout = Layout::of(window);
        assert_eq!(layout.width, expected);
        for card in [layout.top, layout.rail, layout.card] {
            assert!(window.contains_rect(card), "{card:?} in {window:?}");
        }
        assert!(!layout.top.intersects(layout.card) && !layout.top.intersects(layout.rail));
        assert!(!layout.rail.intersects(layout.card));
    }
}

#[test]
fn the_free_part_of_the_scene_is_beside_an_open_drawer() {
    for (width, height) in [(1440.0, 900.0), (1024.0, 768.0), (820.0, 1180.0)] {
        let layout = Layout::of(Rect::from_min_size(pos2(0.0, 0.0), vec2(width, height)));
        let free = layout.free_beside(true, false);
        assert!(free.width() > 250.0 && layout.free.contains_rect(free), "{free:?}");
        for card in [layout.top, layout.rail, layout.card] {
            assert!(!free.intersects(card), "{free:?} and {card:?}");
        }
        assert!(layout.free_beside(false, false).contains_rect(free));
    }
}
