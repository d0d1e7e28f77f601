//! A site that follows its map: when the robot uses another version of the map, such as one that was extended, patched, aligned or merged, everything that has a place in
//! the site moves with the keyframes near it (docs/maths/topomap.md, equation 4).
//!
//! A version is recognised by its keyframes: they have the times at which the robot was there, and nearly the same poses relative to each other.

use geometry::{Isometry, Vector3, isometry_from_pose, pose_from_isometry, vec_from_plain, vec_to_plain};
use site_model::{
    Anchor, Change, Edit, EditId, InspectionPoint, Node, NodeId, Object, ObjectId, Site, SiteSettings, Zone,
};
use std::collections::BTreeMap;
use vocab::{KeyframeId, MapId, Stamp};

/// Parameters of [`MapMotion::between`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowConfig {
    /// Least share of the keyframes of the smaller map that the other one must have. A patch replaces a part of them. Chosen: half.
    pub min_shared: f64,
    /// Least share of pairs of consecutive keyframes that must have kept their relative pose. Chosen: a loop closure or a patch changes few of them.
    pub min_kept: f64,
    /// Greatest change of a relative pose, metres and radians. Loop closures move keyframes a metre apart by centimetres. Chosen: ten times that.
    pub max_change_m: f64,
    /// The same for its rotation. Chosen: 11 degrees, far above what a loop closure turns.
    pub max_change_rad: f64,
    /// Smaller movements of an object are rounding, metres and radians. Chosen: a micrometre.
    pub same: f64,
}

impl Default for FollowConfig {
    fn default() -> Self {
        Self { min_shared: 0.5, min_kept: 0.9, max_change_m: 0.5, max_change_rad: 0.2, same: 1e-6 }
    }
}

/// Where the keyframes of one version of a map are in another one.
#[derive(Clone, Debug)]
pub struct MapMotion {
    config: FollowConfig,
    /// Of each keyframe that both have, by its number in the version before: its number in the new one, and its pose in both.
    keyframes: BTreeMap<KeyframeId, Moved>,
}

#[derive(Clone, Copy, Debug)]
struct Moved {
    id: KeyframeId,
    before: Isometry,
    after: Isometry,
}

/// What an edit of [`MapMotion::edit`] does.
#[derive(Clone, Debug, PartialEq)]
pub struct Following {
    /// The edit. It makes the new version the map of the site.
    pub edit: Edit,
    /// Nodes that move.
    pub moved_nodes: usize,
    /// How far the farthest of them moves, metres.
    pub max_distance_m: f64,
}

impl MapMotion {
    /// From the keyframes of both versions in the order of their numbers: the time and the pose of each. None if they are not versions of one map.
    pub fn between(
        before: &[(Stamp, Isometry)],
        after: &[(Stamp, Isometry)],
        config: FollowConfig,
    ) -> Option<Self> {
        let by_time: BTreeMap<Stamp, (KeyframeId, Isometry)> =
            (0..).zip(after).map(|(id, (stamp, pose))| (*stamp, (KeyframeId(id), *pose))).collect();
        let found = (0..).zip(before).filter_map(|(number, (stamp, before))| {
            let (id, after) = by_time.get(stamp)?;
            Some((KeyframeId(number), Moved { id: *id, before: *before, after: *after }))
        });
        let keyframes: BTreeMap<KeyframeId, Moved> = found.collect();
        let smaller = before.len().min(after.len());
        if keyframes.is_empty() || (keyframes.len() as f64) < config.min_shared * smaller as f64 {
            return None;
        }
        let moved: Vec<&Moved> = keyframes.values().collect();
        let pairs = moved.windows(2);
        let kept = pairs.clone().filter(|pair| {
            let (before, after) =
                (pair[0].before.inverse() * pair[1].before, pair[0].after.inverse() * pair[1].after);
            let change = before.inverse() * after;
            change.translation.vector.norm() <= config.max_change_m
                && change.rotation.angle() <= config.max_change_rad
        });
        let (kept, pairs) = (kept.count() as f64, pairs.count() as f64);
        (kept >= config.min_kept * pairs).then_some(Self { config, keyframes })
    }

    /// The edit after which everything in a site is where it belongs in the map `map`. Nodes move with their keyframes. Nodes without one, and corners of zones, move with the
    /// keyframe that was nearest; targets of inspection points with their nodes. Linear in the site times the keyframes.
    pub fn edit(&self, site: &Site, map: MapId, id: EditId) -> Following {
        let nodes: BTreeMap<NodeId, Node> =
            site.nodes().filter_map(|node| Some((node.id, self.moved_node(node)?))).collect();
        let distances = nodes.values().filter_map(|node| {
            let before = vec_from_plain(site.node(node.id)?.map_from_node.position);
            Some((vec_from_plain(node.map_from_node.position) - before).norm())
        });
        let max_distance_m = distances.fold(0.0, f64::max);
        let others = site.objects().filter_map(|versioned| match &versioned.object {
            Object::InspectionPoint(point) => {
                self.moved_point(site, &nodes, point).map(Object::InspectionPoint)
            }
            Object::Zone(zone) => self.moved_zone(zone).map(Object::Zone),
            _ => None,
        });
        let settings = site.settings().cloned().unwrap_or_else(|| SiteSettings::of_unnamed(map));
        let settings = Object::Settings(SiteSettings { map: Some(map), ..settings });
        let put = others.chain(nodes.values().cloned().map(Object::Node)).chain([settings]);
        let changes = put.map(|object| Change::Put { base: site.revision(object.id()), object });
        let mut changes: Vec<Change> = changes.collect();
        changes.retain(|change| match change {
            Change::Put { object, .. } => site.get(object.id()).is_none_or(|known| known.object != *object),
            Change::Remove { .. } => true,
        });
        let is_node = |change: &&Change| matches!(change.object_id(), ObjectId::Node(_));
        let moved_nodes = changes.iter().filter(is_node).count();
        Following { edit: Edit { id, changes }, moved_nodes, max_distance_m }
    }

    /// A node where it belongs now; none if it stays as it is.
    fn moved_node(&self, node: &Node) -> Option<Node> {
        let before = isometry_from_pose(&node.map_from_node)?;
        let anchor = node.anchor.and_then(|anchor| {
            let keyframe = self.keyframes.get(&anchor.keyframe)?;
            Some((keyframe, isometry_from_pose(&anchor.keyframe_from_node)?, anchor))
        });
        let (after, anchor) = match anchor {
            Some((keyframe, keyframe_from_node, anchor)) => {
                (keyframe.after * keyframe_from_node, Some(Anchor { keyframe: keyframe.id, ..anchor }))
            }
            None => (self.motion_at(&before.translation.vector)? * before, None),
        };
        let is_moved = self.is_moved(&before, &after);
        let map_from_node = if is_moved { pose_from_isometry(&after) } else { node.map_from_node };
        let moved = Node { map_from_node, anchor, ..node.clone() };
        (moved != *node).then_some(moved)
    }

    fn moved_point(
        &self,
        site: &Site,
        nodes: &BTreeMap<NodeId, Node>,
        point: &InspectionPoint,
    ) -> Option<InspectionPoint> {
        let target = vec_from_plain(point.target_m);
        let motion = match site.node(point.node) {
            Some(node) => {
                let before = isometry_from_pose(&node.map_from_node)?;
                isometry_from_pose(&nodes.get(&point.node)?.map_from_node)? * before.inverse()
            }
            None => self.motion_at(&target)?,
        };
        let after = motion.rotation * target + motion.translation.vector;
        let is_moved = (after - target).norm() > self.config.same;
        is_moved.then(|| InspectionPoint { target_m: vec_to_plain(&after), ..point.clone() })
    }

    /// A zone whose corners move with the keyframes that were nearest to them, on the floor of the zone.
    fn moved_zone(&self, zone: &Zone) -> Option<Zone> {
        let middle_m = zone.height_m.map(|[low, high]| (low + high) / 2.0);
        let mut zone_after = zone.clone();
        let (mut is_moved, mut lift_m) = (false, 0.0);
        for corner in &mut zone_after.corners_m {
            let before = Vector3::new(corner[0], corner[1], middle_m.unwrap_or_default());
            let motion = self.nearest(|keyframe| {
                let offset = keyframe - before;
                offset.xy().norm_squared() + middle_m.map_or(0.0, |_| offset.z * offset.z)
            })?;
            let after = motion.rotation * before + motion.translation.vector;
            is_moved |= (after - before).norm() > self.config.same;
            lift_m += (after.z - before.z) / zone.corners_m.len() as f64;
            *corner = [after.x, after.y];
        }
        zone_after.height_m = zone.height_m.map(|heights| heights.map(|height| height + lift_m));
        is_moved.then_some(zone_after)
    }

    /// How the map has moved at a place: with the keyframe that was nearest to it.
    fn motion_at(&self, place: &Vector3) -> Option<Isometry> {
        self.nearest(|keyframe| (keyframe - place).norm_squared())
    }

    fn nearest(&self, squared_distance: impl Fn(&Vector3) -> f64) -> Option<Isometry> {
        let distance = |moved: &Moved| squared_distance(&moved.before.translation.vector);
        let nearest = self.keyframes.values().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        Some(nearest.after * nearest.before.inverse())
    }

    fn is_moved(&self, before: &Isometry, after: &Isometry) -> bool {
        let offset = before.inverse() * after;
        offset.translation.vector.norm() > self.config.same || offset.rotation.angle() > self.config.same
    }
}
