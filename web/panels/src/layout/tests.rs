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
