//! Puts a generated topological map into a site, in place of the one before.

use crate::GeneratedMap;
use site_model::{Change, Edit, EditId, NodeId, Object, ObjectId, Site, SiteSettings, TaskPlace};
use std::collections::{BTreeMap, BTreeSet};
use vocab::MapId;

/// An edit that makes a generated map the topological map of a site.
#[derive(Clone, Debug, PartialEq)]
pub struct Replacement {
    /// The edit. Without changes: the site has the same topological map already.
    pub edit: Edit,
    /// Nodes of the site before that stay although they were not generated.
    pub kept_nodes: usize,
}

impl GeneratedMap {
    /// The edit that makes this the topological map of a site, made from `map`. Nodes, edges and docks that were not generated are removed, except nodes that
    /// inspection points or tasks need, and the edges between nodes that stay. Linear in the site.
    pub fn replacement(&self, site: &Site, map: MapId, id: EditId) -> Replacement {
        let mut put: BTreeMap<ObjectId, Object> =
            self.objects().map(|object| (object.id(), object)).collect();
        if site.settings().and_then(|settings| settings.map) != Some(map) {
            let settings = site.settings().cloned().unwrap_or_else(|| SiteSettings::of_unnamed(map));
            put.insert(ObjectId::Settings, Object::Settings(SiteSettings { map: Some(map), ..settings }));
        }
        let is_generated = |id: ObjectId| put.contains_key(&id);
        let needed = needed_nodes(site);
        let kept: BTreeSet<NodeId> = site
            .nodes()
            .map(|node| node.id)
            .filter(|node| needed.contains(node) && !is_generated(ObjectId::Node(*node)))
            .collect();
        let stays = |node: NodeId| kept.contains(&node) || is_generated(ObjectId::Node(node));
        let mut removed: BTreeSet<ObjectId> = BTreeSet::new();
        for versioned in site.objects() {
            let is_removed = match &versioned.object {
                Object::Node(node) => !stays(node.id),
                Object::Edge(edge) => {
                    let joins_kept = kept.contains(&edge.from) || kept.contains(&edge.to);
                    !(is_generated(ObjectId::Edge(edge.id))
                        || joins_kept && stays(edge.from) && stays(edge.to))
                }
                Object::Dock(dock) => !is_generated(ObjectId::Dock(dock.id)),
                _ => false,
            };
            if is_removed {
                removed.insert(versioned.object.id());
            }
        }
        let blocks = site.edge_blocks().map(|block| block.edge);
        let of_removed = blocks.filter(|edge| removed.contains(&ObjectId::Edge(*edge)));
        let of_removed: Vec<ObjectId> = of_removed.map(ObjectId::EdgeBlock).collect();
        removed.extend(of_removed);
        let puts = put
            .into_values()
            .filter(|object| site.get(object.id()).is_none_or(|known| known.object != *object))
            .map(|object| Change::Put { base: site.revision(object.id()), object });
        let removals = removed
            .iter()
            .filter_map(|object| Some(Change::Remove { base: site.revision(*object)?, object: *object }));
        let changes = puts.chain(removals).collect();
        Replacement { edit: Edit { id, changes }, kept_nodes: kept.len() }
    }
}

/// Nodes that inspection points or tasks of missions refer to.
fn needed_nodes(site: &Site) -> BTreeSet<NodeId> {
    let of_points = site.objects().filter_map(|versioned| match &versioned.object {
        Object::InspectionPoint(point) => Some(point.node),
        _ => None,
    });
    let of_tasks = site.missions().flat_map(|mission| &mission.tasks).filter_map(|task| match &task.place {
        TaskPlace::Node { node, .. } => Some(*node),
        TaskPlace::InspectionPoint(_) | TaskPlace::ByAction { .. } => None,
    });
    of_points.chain(of_tasks).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use site_model::{ActionRequest, Edge, EdgeId, InspectionPoint, InspectionPointId, Node, NodeKind};
    use vocab::{Pose, Vec3};

    const MAP: MapId = MapId(uuid::Uuid::from_u128(1));

    fn node(number: u128) -> Node {
        Node {
            id: NodeId(uuid::Uuid::from_u128(number)),
            name: format!("N{number}"),
            kind: NodeKind::Waypoint,
            map_from_node: Pose::IDENTITY,
            anchor: None,
            tolerance: Default::default(),
            influence_area_m: Vec::new(),
            floor: 0,
            tags: Default::default(),
            properties: Default::default(),
        }
    }

    fn edge(from: u128, to: u128) -> Edge {
        let id = EdgeId(uuid::Uuid::from_u128(1_000 * from + to));
        Edge::walk(id, node(from).id, node(to).id)
    }

    fn generated(nodes: &[u128], edges: &[(u128, u128)]) -> GeneratedMap {
        GeneratedMap {
            nodes: nodes.iter().map(|number| node(*number)).collect(),
            edges: edges.iter().map(|(from, to)| edge(*from, *to)).collect(),
            ..GeneratedMap::default()
        }
    }

    fn id(number: u128) -> EditId {
        EditId(uuid::Uuid::from_u128(number))
    }

    fn replaced(site: &mut Site, with: &GeneratedMap) -> Replacement {
        let replacement = with.replacement(site, MAP, id(9));
        site.apply(&replacement.edit, id(10)).expect("of this state");
        replacement
    }

    fn names(site: &Site) -> Vec<&str> {
        site.nodes().map(|node| node.name.as_str()).collect()
    }

    #[test]
    fn an_empty_site_gets_the_map_and_all_objects_and_its_inverse_takes_them_back() {
        let mut site = Site::default();
        let made = generated(&[1, 2], &[(1, 2), (2, 1)]);
        let replacement = made.replacement(&site, MAP, id(9));
        let applied = site.apply(&replacement.edit, id(10)).expect("of this state");
        assert_eq!(site.settings().and_then(|settings| settings.map), Some(MAP));
        assert_eq!((names(&site).len(), site.edges().count()), (2, 2));
        assert!(made.replacement(&site, MAP, id(11)).edit.changes.is_empty(), "nothing to change");
        site.apply(&applied.inverse, id(12)).expect("of this state");
        assert_eq!(site.objects().len(), 0);
    }

    #[test]
    fn what_was_not_generated_goes_except_nodes_that_an_inspection_point_needs() {
        let mut site = Site::default();
        replaced(&mut site, &generated(&[1, 2, 3, 4], &[(1, 2), (2, 3), (3, 4)]));
        let point = InspectionPoint {
            id: InspectionPointId(uuid::Uuid::from_u128(50)),
            name: "Gauge".to_owned(),
            asset: None,
            node: node(3).id,
            target_m: Vec3::default(),
            request: ActionRequest { action: "photo".to_owned(), parameters: Default::default() },
            limits: None,
            gauge: None,
        };
        let edit = site.put(id(20), Object::InspectionPoint(point));
        site.apply(&edit, id(21)).expect("of this state");
        let replacement = replaced(&mut site, &generated(&[1, 2, 5], &[(1, 2), (2, 5)]));
        assert_eq!(replacement.kept_nodes, 1);
        assert_eq!(names(&site), ["N1", "N2", "N3", "N5"]);
        let ends: Vec<_> = site.edges().map(|edge| (edge.from, edge.to)).collect();
        let expected = [(1, 2), (2, 3), (2, 5)].map(|(from, to)| (node(from).id, node(to).id));
        assert_eq!(ends, expected, "the path to the kept node stays, that to the removed one goes");
    }

    #[test]
    fn a_generated_node_that_a_person_moved_is_put_back() {
        let mut site = Site::default();
        let made = generated(&[1], &[]);
        replaced(&mut site, &made);
        let mut moved = node(1);
        moved.map_from_node.position.x = 5.0;
        let edit = site.put(id(30), Object::Node(moved));
        site.apply(&edit, id(31)).expect("of this state");
        replaced(&mut site, &made);
        assert_eq!(site.node(node(1).id), Some(&node(1)));
    }
}
