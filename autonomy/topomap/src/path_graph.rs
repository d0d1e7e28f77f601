//! A graph of all paths: places about [`TopomapConfig::merge_distance_m`] apart, joined where a path leads straight from one to the next. Paths that come
//! back to the same places share them.

use crate::TopomapConfig;
use crate::corridor::Passage;
use crate::path::{PathStep, Sample};
use geometry::Vector3;
use ordered_float::OrderedFloat;
use pathfinding::directed::dijkstra::dijkstra_reach;
use std::collections::BTreeMap;

/// What a place is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlaceKind {
    /// On a path.
    Plain,
    /// One end of stairs.
    Portal,
    /// On a dock, and its number.
    Dock(usize),
    /// In front of a dock.
    DockApproach(usize),
}

/// A place of the graph.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub sample: Sample,
    pub kind: PlaceKind,
}

/// How two places are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LinkKind {
    /// Straight over the ground.
    Walk,
    /// By stairs. For both directions, from the place of the smaller number first: whether the robot walked them backward.
    Stairs([bool; 2]),
    /// From the place in front of a dock onto it.
    Dock,
}

/// A connection of two places, in both directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub kind: LinkKind,
    /// Number of times that it was walked.
    walks: u32,
}

/// Why a stretch of the path has no edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockedBy {
    /// Something stands there.
    Obstacle,
    /// No ground is known there.
    NoGround,
}

/// A stretch of the path that the map shows to be blocked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockedSegment {
    /// By what, where it begins to be.
    pub by: BlockedBy,
    /// Where it begins: the feet, metres, map frame.
    pub from_m: Vector3,
    /// Where it ends.
    pub to_m: Vector3,
}

/// The graph.
#[derive(Clone, Debug, Default)]
pub(crate) struct PathGraph {
    config: TopomapConfig,
    pub places: Vec<Place>,
    /// For each place: its neighbours.
    pub links: Vec<BTreeMap<usize, Link>>,
    pub blocked: Vec<BlockedSegment>,
}

impl PathGraph {
    /// Without places.
    pub fn new(config: &TopomapConfig) -> Self {
        Self { config: *config, ..Self::default() }
    }

    /// Adds a place.
    pub fn add(&mut self, sample: Sample, kind: PlaceKind) -> usize {
        self.places.push(Place { sample, kind });
        self.links.push(BTreeMap::new());
        self.places.len() - 1
    }

    /// Joins two places. Stairs stay stairs.
    pub fn join(&mut self, a: usize, b: usize, kind: LinkKind) {
        if a == b {
            return;
        }
        for (from, to) in [(a, b), (b, a)] {
            let link = self.links[from].entry(to).or_insert(Link { kind, walks: 0 });
            link.walks += 1;
            if let (LinkKind::Stairs(known), LinkKind::Stairs(new)) = (&mut link.kind, kind) {
                *known = [known[0] || new[0], known[1] || new[1]];
            }
        }
    }

    /// Removes all connections of a place.
    pub fn detach(&mut self, place: usize) {
        for next in self.links[place].keys().copied().collect::<Vec<_>>() {
            self.separate(place, next);
        }
    }

    fn separate(&mut self, a: usize, b: usize) -> Option<Link> {
        self.links[a].remove(&b);
        self.links[b].remove(&a)
    }

    /// Adds a walk. Linear in its samples times the places.
    pub fn add_walk(&mut self, walk: &[PathStep], passage: &Passage<'_>) {
        let mut last: Option<(usize, Sample)> = None;
        for step in walk {
            last = match *step {
                PathStep::Walk(sample) => {
                    let place = self.place_of(&sample, passage);
                    Some((self.walk_to(place, last, &sample, passage), sample))
                }
                PathStep::StairsBegin(sample) => {
                    let place = self.portal(&sample, passage);
                    Some((self.walk_to(place, last, &sample, passage), sample))
                }
                PathStep::StairsEnd { sample, is_backward } => {
                    let place = self.portal(&sample, passage);
                    if let Some((from, _)) = last {
                        let backward = if from < place { [is_backward, false] } else { [false, is_backward] };
                        self.join(from, place, LinkKind::Stairs(backward));
                    }
                    Some((place, sample))
                }
            };
        }
    }

    /// Joins the place of a sample with that of the sample before it. Returns the place at which the walk has arrived.
    fn walk_to(
        &mut self,
        place: usize,
        last: Option<(usize, Sample)>,
        sample: &Sample,
        passage: &Passage<'_>,
    ) -> usize {
        let Some((from, before)) = last.filter(|(from, _)| *from != place) else { return place };
        if self.try_join(from, place, passage) {
            return place;
        }
        // The straight line cuts a corner. The samples themselves become places.
        let corner = self.place_at(&before);
        if corner != from && !self.try_join(from, corner, passage) {
            self.mark_blocked(from, corner, passage);
        }
        if corner == place || self.try_join(corner, place, passage) {
            return place;
        }
        let arrived = self.place_at(sample);
        if !self.try_join(corner, arrived, passage) {
            self.mark_blocked(corner, arrived, passage);
        }
        if arrived != place {
            self.try_join(arrived, place, passage);
        }
        arrived
    }

    fn try_join(&mut self, a: usize, b: usize, passage: &Passage<'_>) -> bool {
        let is_free = self.links[a].contains_key(&b) || passage.is_free(&self.feet(a), &self.feet(b));
        if is_free {
            self.join(a, b, LinkKind::Walk);
        }
        is_free
    }

    fn mark_blocked(&mut self, from: usize, to: usize, passage: &Passage<'_>) {
        let (from_m, to_m) = (self.feet(from), self.feet(to));
        let by =
            if passage.floor.has_ground(&from_m, &to_m) { BlockedBy::Obstacle } else { BlockedBy::NoGround };
        let segment = BlockedSegment { by, from_m, to_m };
        if let Some(last) = self.blocked.last_mut().filter(|last| last.to_m == segment.from_m) {
            last.to_m = segment.to_m;
        } else if !self.blocked.contains(&segment) {
            self.blocked.push(segment);
        }
    }

    pub fn feet(&self, place: usize) -> Vector3 {
        self.places[place].sample.feet
    }

    /// The places within a distance of others, the nearest first.
    pub fn near(&self, feet: &Vector3, within_m: f64) -> Vec<usize> {
        let mut near: Vec<(f64, usize)> = (0..self.places.len())
            .filter(|place| (self.feet(*place).z - feet.z).abs() <= self.config.same_height_m)
            .map(|place| ((self.feet(place) - feet).xy().norm(), place))
            .filter(|(distance_m, _)| *distance_m <= within_m)
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.into_iter().map(|(_, place)| place).collect()
    }

    /// The place to which a sample belongs: the nearest one to which the robot can walk straight, or a new one.
    fn place_of(&mut self, sample: &Sample, passage: &Passage<'_>) -> usize {
        let config = &passage.floor.config;
        let belongs = |place: &usize| {
            let within_m = match self.places[*place].kind {
                PlaceKind::Dock(_) => config.dock_radius_m,
                PlaceKind::Plain | PlaceKind::Portal | PlaceKind::DockApproach(_) => config.merge_distance_m,
            };
            let feet = self.feet(*place);
            (feet - sample.feet).xy().norm() <= within_m
                && ((feet - sample.feet).norm() <= self.config.same_place_m
                    || passage.is_free(&sample.feet, &feet))
        };
        let found = self.near(&sample.feet, config.merge_distance_m).into_iter().find(belongs);
        found.unwrap_or_else(|| self.add(*sample, PlaceKind::Plain))
    }

    /// A place at a sample.
    fn place_at(&mut self, sample: &Sample) -> usize {
        let near = self.near(&sample.feet, self.config.same_place_m);
        let found = near.into_iter().find(|place| !matches!(self.places[*place].kind, PlaceKind::Dock(_)));
        found.unwrap_or_else(|| self.add(*sample, PlaceKind::Plain))
    }

    /// The place at one end of stairs.
    fn portal(&mut self, sample: &Sample, passage: &Passage<'_>) -> usize {
        // Half of the shortest landing, so that the ends of two flights stay apart.
        let near = self.near(&sample.feet, 2.0 * passage.floor.config.stairs_margin_m);
        let found = near.into_iter().find(|place| self.places[*place].kind == PlaceKind::Portal);
        found.unwrap_or_else(|| self.add(*sample, PlaceKind::Portal))
    }

    fn length_m(&self, a: usize, b: usize) -> f64 {
        (self.feet(a) - self.feet(b)).norm()
    }

    /// Whether two places are joined by a path of at most `max_m` without the link between them.
    fn has_detour(&self, from: usize, to: usize, max_m: f64) -> bool {
        let steps = |place: &usize| {
            let place = *place;
            let others = self.links[place].keys().copied().filter(move |next| (place, *next) != (from, to));
            others.map(move |next| (next, OrderedFloat(self.length_m(place, next))))
        };
        dijkstra_reach(&from, steps)
            .take_while(|reached| reached.total_cost.into_inner() <= max_m)
            .any(|reached| reached.node == to)
    }

    /// Removes links whose ends are joined by a short path anyhow: those walked least first, the longest first among them.
    pub fn remove_small_loops(&mut self, config: &TopomapConfig) {
        let mut links: Vec<(u32, f64, usize, usize)> = Vec::new();
        for (a, neighbours) in self.links.iter().enumerate() {
            for (b, link) in neighbours.range(a..).filter(|(_, link)| link.kind == LinkKind::Walk) {
                links.push((link.walks, self.length_m(a, *b), a, *b));
            }
        }
        links.sort_by(|x, y| x.0.cmp(&y.0).then(y.1.total_cmp(&x.1)).then((x.2, x.3).cmp(&(y.2, y.3))));
        for (_, length_m, a, b) in links {
            if self.has_detour(a, b, config.min_loop_m - length_m) {
                self.separate(a, b);
            }
        }
    }

    /// Removes dead ends that are shorter than [`TopomapConfig::min_dead_end_m`].
    pub fn remove_dead_ends(&mut self, config: &TopomapConfig) {
        for leaf in 0..self.places.len() {
            let mut chain = vec![leaf];
            let mut length_m = 0.0;
            let is_end = loop {
                let at = chain[chain.len() - 1];
                let before = chain.len().checked_sub(2).map(|index| chain[index]);
                let degree = self.links[at].len();
                let expected = if before.is_some() { 2 } else { 1 };
                if degree != expected || self.places[at].kind != PlaceKind::Plain {
                    break degree > 2 && before.is_some();
                }
                let Some(next) = self.links[at].keys().copied().find(|next| Some(*next) != before) else {
                    break false;
                };
                length_m += self.length_m(at, next);
                chain.push(next);
                if length_m >= config.min_dead_end_m {
                    break false;
                }
            };
            if is_end {
                for pair in chain.windows(2) {
                    self.separate(pair[0], pair[1]);
                }
            }
        }
    }

    /// Makes one junction of two that are near to each other, where all paths stay free.
    pub fn merge_junctions(&mut self, passage: &Passage<'_>) {
        for a in 0..self.places.len() {
            while let Some((keep, drop)) = self.mergeable(a, passage) {
                self.separate(keep, drop);
                for next in self.links[drop].keys().copied().collect::<Vec<_>>() {
                    if let Some(link) = self.separate(drop, next) {
                        self.join(keep, next, link.kind);
                    }
                }
            }
        }
    }

    /// A neighbour of a junction that is a junction as well and can become one with it: which place stays, and which goes.
    fn mergeable(&self, a: usize, passage: &Passage<'_>) -> Option<(usize, usize)> {
        let is_junction = |place: usize| self.links[place].len() > 2;
        let is_plain = |place: usize| {
            self.places[place].kind == PlaceKind::Plain
                && self.links[place].values().all(|link| link.kind == LinkKind::Walk)
        };
        if !is_junction(a) {
            return None;
        }
        let max_m = passage.floor.config.node_merge_m;
        let others = self.links[a].keys().copied();
        others
            .filter(|b| is_junction(*b) && self.length_m(a, *b) < max_m)
            .flat_map(|b| [(a, b), (b, a)])
            .find(|(keep, drop)| {
                let mut around = self.links[*drop].keys().filter(|next| **next != *keep);
                is_plain(*drop) && around.all(|next| passage.is_free(&self.feet(*keep), &self.feet(*next)))
            })
    }
}
