//! Placement of the tags of scene labels: beside their point, clear of cards and of each other.

use egui::{Align2, Pos2, Rect, Vec2, vec2};

/// Radius of the ring around a selected label, to the middle of its line, points.
pub(super) const RING_RADIUS: f32 = 14.0;
/// Width of the ring's line, points.
pub(super) const RING_WIDTH: f32 = 2.0;

/// Parameters of [`LabelPlacer`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LabelPlacementConfig {
    /// Distance between the label's point and the nearest edge of its tag, points. Where the thing on the screen is larger, the tag is beside it. Chosen: the ring of a
    /// selected label fits between.
    pub(crate) tag_distance: f32,
    /// Distance that a tag keeps from cards and from the edge of the window, points. Chosen: the grid of distances of the cards.
    pub(crate) margin: f32,
    /// Radius of the ring around a selected label, to the outer edge of its line, points. It is that of the ring that is drawn.
    pub(crate) ring_radius: f32,
}

impl Default for LabelPlacementConfig {
    fn default() -> Self {
        Self { tag_distance: 17.0, margin: 4.0, ring_radius: RING_RADIUS + 0.5 * RING_WIDTH }
    }
}

/// Places the labels of a frame one after the other, the most important first.
#[derive(Clone, Debug)]
pub(crate) struct LabelPlacer {
    config: LabelPlacementConfig,
    window: Rect,
    cards: Vec<Rect>,
    /// Tags, and things that no tag may hide.
    taken: Vec<Rect>,
}

impl LabelPlacer {
    /// - `window`: the area of the scene, points.
    /// - `cards`: the rectangles that cover the scene, points.
    pub(crate) fn new(config: LabelPlacementConfig, window: Rect, cards: Vec<Rect>) -> Self {
        Self { config, window, cards, taken: Vec::new() }
    }

    /// Whether a card covers a point.
    pub(crate) fn is_covered(&self, at: Pos2) -> bool {
        self.cards.iter().any(|card| card.contains(at))
    }

    /// Whether the ring around a point is clear of all cards.
    pub(crate) fn has_room_for_ring(&self, at: Pos2) -> bool {
        let ring = Rect::from_center_size(at, Vec2::splat(2.0 * self.config.ring_radius));
        !self.cards.iter().any(|card| card.intersects(ring))
    }

    /// Keeps the tags that are placed from now on off this rectangle, points.
    pub(crate) fn keep_clear(&mut self, rect: Rect) {
        self.taken.push(rect);
    }

    /// The rectangle of a tag of this size for a label whose thing covers `body` on the screen: below it, else above, to the right or to the
    /// left. None if the middle of the thing is covered or no position is free. Points.
    pub(crate) fn place(&mut self, body: Rect, size: Vec2) -> Option<Rect> {
        let at = body.center();
        if self.is_covered(at) {
            return None;
        }
        let distance =
            (0.5 * body.size() + Vec2::splat(self.config.margin)).max(Vec2::splat(self.config.tag_distance));
        let candidates = [
            (Align2::CENTER_TOP, vec2(0.0, distance.y)),
            (Align2::CENTER_BOTTOM, vec2(0.0, -distance.y)),
            (Align2::LEFT_CENTER, vec2(distance.x, 0.0)),
            (Align2::RIGHT_CENTER, vec2(-distance.x, 0.0)),
        ];
        let placed = candidates
            .into_iter()
            .map(|(anchor, offset)| anchor.anchor_size(at + offset, size))
            .find(|rect| self.is_free(*rect))?;
        self.taken.push(placed);
        Some(placed)
    }

    fn is_free(&self, rect: Rect) -> bool {
        let kept_clear = rect.expand(self.config.margin);
        self.window.contains_rect(kept_clear)
            && !self.cards.iter().any(|card| card.intersects(kept_clear))
            && !self.taken.iter().any(|taken| taken.intersects(rect))
    }
}

/// Rectangles of everything that floats over the scene, from the last frame: cards, bars, menus. Tooltips are left out, because they come
/// and go with the pointer.
pub(crate) fn covering_rects(ctx: &egui::Context) -> Vec<Rect> {
    ctx.memory(|memory| {
        let layers = memory.areas().visible_layer_ids();
        let floats = |order| matches!(order, egui::Order::Middle | egui::Order::Foreground);
        layers
            .iter()
            .filter(|layer| floats(layer.order))
            .filter_map(|layer| memory.area_rect(layer.id))
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    const SIZE: Vec2 = vec2(80.0, 20.0);

    fn placer(cards: Vec<Rect>) -> LabelPlacer {
        let window = Rect::from_min_max(Pos2::ZERO, pos2(1000.0, 800.0));
        LabelPlacer::new(LabelPlacementConfig::default(), window, cards)
    }

    fn point(x: f32, y: f32) -> Rect {
        Rect::from_center_size(pos2(x, y), Vec2::ZERO)
    }

    fn card(min: [f32; 2], max: [f32; 2]) -> Rect {
        Rect::from_min_max(min.into(), max.into())
    }

    #[test]
    fn a_tag_is_below_its_point_where_there_is_room() {
        let tag = placer(Vec::new()).place(point(500.0, 400.0), SIZE).unwrap();
        assert_eq!((tag.center().x, tag.top()), (500.0, 417.0));
    }

    #[test]
    fn a_tag_moves_away_from_cards_and_the_window_edge() {
        let cards = vec![card([600.0, 0.0], [1000.0, 800.0]), card([0.0, 700.0], [1000.0, 800.0])];
        let mut placer = placer(cards.clone());
        let clear = |tag: Rect| cards.iter().all(|card| !card.intersects(tag));
        let above = placer.place(point(300.0, 680.0), SIZE).unwrap();
        assert!(above.bottom() < 680.0 && clear(above), "{above}");
        let left = placer.place(point(570.0, 300.0), SIZE).unwrap();
        assert!(left.right() < 570.0 && clear(left), "{left}");
        let right = placer.place(point(6.0, 300.0), SIZE).unwrap();
        assert!(right.left() > 6.0, "{right}");
    }

    #[test]
    fn a_label_under_a_card_has_neither_tag_nor_ring() {
        let mut placer = placer(vec![card([600.0, 0.0], [1000.0, 800.0])]);
        assert_eq!(placer.place(point(610.0, 400.0), SIZE), None);
        assert!(placer.is_covered(pos2(610.0, 400.0)));
        assert!(!placer.has_room_for_ring(pos2(590.0, 400.0)), "half of it would be covered");
        assert!(placer.has_room_for_ring(pos2(580.0, 400.0)));
    }

    #[test]
    fn tags_avoid_each_other_and_are_left_out_where_all_is_taken() {
        let mut placer = placer(Vec::new());
        let at = point(500.0, 400.0);
        let tags: Vec<Rect> = std::iter::from_fn(|| placer.place(at, SIZE)).collect();
        assert_eq!(tags.len(), 4);
        for (index, tag) in tags.iter().enumerate() {
            assert!(tags[..index].iter().all(|other| !other.intersects(*tag)));
        }
    }

    #[test]
    fn no_tag_hides_a_thing_that_is_kept_clear_at_any_zoom() {
        for side in [28.0, 90.0, 300.0, 700.0] {
            let mut placer = placer(Vec::new());
            let robot = Rect::from_center_size(pos2(500.0, 400.0), Vec2::splat(side));
            placer.keep_clear(robot);
            let goal = placer.place(point(500.0, 380.0), SIZE);
            let tags = [placer.place(robot, SIZE), goal];
            assert!(tags.into_iter().flatten().all(|tag| !tag.intersects(robot)), "{side} {tags:?}");
            assert!(tags[0].is_some(), "the robot has its own tag: {side}");
        }
    }
}
