//! The objects of a site, and how edits change them.

use crate::finite::is_finite;
use crate::{
    Alert, Applied, Change, Dock, Edge, EdgeBlock, EdgeId, Edit, EditError, EditId, InspectionPoint,
    InspectionPointId, Mission, MissionId, Monitor, MutexHold, Node, NodeId, Object, ObjectId, Revision,
    RevisionChange, SceneChange, Schedule, ScheduleId, SiteSettings, Task, TaskPlace, Versioned, Zone,
};
use std::collections::{BTreeMap, BTreeSet};

/// All objects of a site.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Site {
    objects: BTreeMap<ObjectId, Versioned>,
    /// Revisions at which objects were removed. An object that is put again goes on from there, so that no revision occurs twice.
    removed: BTreeMap<ObjectId, Revision>,
}

impl Site {
    /// A site of these objects, as a store has them. Of several with one id, the last counts.
    pub fn new(
        objects: impl IntoIterator<Item = Versioned>,
        removed: impl IntoIterator<Item = (ObjectId, Revision)>,
    ) -> Self {
        let objects = objects.into_iter().map(|versioned| (versioned.object.id(), versioned)).collect();
        Self { objects, removed: removed.into_iter().collect() }
    }

    /// All objects, in the order of their ids.
    pub fn objects(&self) -> impl ExactSizeIterator<Item = &Versioned> + Clone {
        self.objects.values()
    }

    /// Objects that were removed, with the revision of the removal.
    pub fn removed(&self) -> impl ExactSizeIterator<Item = (ObjectId, Revision)> {
        self.removed.iter().map(|(id, revision)| (*id, *revision))
    }

    /// An object with its revision.
    pub fn get(&self, id: ObjectId) -> Option<&Versioned> {
        self.objects.get(&id)
    }

    /// The revision of an object; none if there is no such object.
    pub fn revision(&self, id: ObjectId) -> Option<Revision> {
        self.get(id).map(|versioned| versioned.revision)
    }

    /// A node.
    pub fn node(&self, id: NodeId) -> Option<&Node> {
        match &self.get(ObjectId::Node(id))?.object {
            Object::Node(node) => Some(node),
            _ => None,
        }
    }

    /// An edge.
    pub fn edge(&self, id: EdgeId) -> Option<&Edge> {
        match &self.get(ObjectId::Edge(id))?.object {
            Object::Edge(edge) => Some(edge),
            _ => None,
        }
    }

    /// An inspection point.
    pub fn inspection_point(&self, id: InspectionPointId) -> Option<&InspectionPoint> {
        match &self.get(ObjectId::InspectionPoint(id))?.object {
            Object::InspectionPoint(point) => Some(point),
            _ => None,
        }
    }

    /// A mission.
    pub fn mission(&self, id: MissionId) -> Option<&Mission> {
        match &self.get(ObjectId::Mission(id))?.object {
            Object::Mission(mission) => Some(mission),
            _ => None,
        }
    }

    /// A schedule.
    pub fn schedule(&self, id: ScheduleId) -> Option<&Schedule> {
        match &self.get(ObjectId::Schedule(id))?.object {
            Object::Schedule(schedule) => Some(schedule),
            _ => None,
        }
    }

    /// All nodes, in the order of their ids.
    pub fn nodes(&self) -> impl Iterator<Item = &Node> {
        self.objects().filter_map(|versioned| match &versioned.object {
            Object::Node(node) => Some(node),
            _ => None,
        })
    }

    /// All edges, in the order of their ids.
    pub fn edges(&self) -> impl Iterator<Item = &Edge> {
        self.objects().filter_map(|versioned| match &versioned.object {
            Object::Edge(edge) => Some(edge),
            _ => None,
        })
    }

    /// All missions, in the order of their ids.
    pub fn missions(&self) -> impl Iterator<Item = &Mission> {
        self.objects().filter_map(|versioned| match &versioned.object {
            Object::Mission(mission) => Some(mission),
            _ => None,
        })
    }

    /// All blocks of edges, in the order of the edges.
    pub fn edge_blocks(&self) -> impl Iterator<Item = &EdgeBlock> {
        self.objects().filter_map(|versioned| match &versioned.object {
            Object::EdgeBlock(block) => Some(block),
            _ => None,
        })
    }

    /// All zones, in the order of their ids.
    pub fn zones(&self) -> impl Iterator<Item = &Zone> {
        self.objects().filter_map(|versioned| match &versioned.object {
            Object::Zone(zone) => Some(zone),
            _ => None,
        })
    }

    /// All docks, in the order of their ids.
    pub fn docks(&self) -> impl Iterator<Item = &Dock> {
        self.objects().filter_map(|versioned| match &versioned.object {
            Object::Dock(dock) => Some(dock),
            _ => None,
        })
    }

    /// All schedules, in the order of their ids.
    pub fn schedules(&self) -> impl Iterator<Item = &Schedule> {
        self.objects().filter_map(|versioned| match &versioned.object {
            Object::Schedule(schedule) => Some(schedule),
            _ => None,
        })
    }

    /// All monitors, in the order of their ids.
    pub fn monitors(&self) -> impl Iterator<Item = &Monitor> {
        self.objects().filter_map(|versioned| match &versioned.object {
            Object::Monitor(monitor) => Some(monitor),
            _ => None,
        })
    }

    /// All holds of groups of edges, in the order of their ids.
    pub fn mutex_holds(&self) -> impl Iterator<Item = &MutexHold> {
        self.objects().filter_map(|versioned| match &versioned.object {
            Object::MutexHold(hold) => Some(hold),
            _ => None,
        })
    }

    /// All changes of the scene, in the order of their ids.
    pub fn scene_changes(&self) -> impl Iterator<Item = &SceneChange> + Clone {
        self.objects().filter_map(|versioned| match &versioned.object {
            Object::SceneChange(change) => Some(change),
            _ => None,
        })
    }

    /// All alerts, in the order of their ids.
    pub fn alerts(&self) -> impl Iterator<Item = &Alert> {
        self.objects().filter_map(|versioned| match &versioned.object {
            Object::Alert(alert) => Some(alert),
            _ => None,
        })
    }

    /// What holds for the whole site.
    pub fn settings(&self) -> Option<&SiteSettings> {
        match &self.get(ObjectId::Settings)?.object {
            Object::Settings(settings) => Some(settings),
            _ => None,
        }
    }

    /// Applies an edit as a whole. Returns its inverse, named `inverse`, which changes the site back. Logarithmic in the site for each change.
    ///
    /// # Errors
    /// Why nothing was applied.
    pub fn apply(&mut self, edit: &Edit, inverse: EditId) -> Result<Applied, EditError> {
        self.check(edit)?;
        let mut applied =
            Applied { inverse: Edit { id: inverse, changes: Vec::new() }, revisions: Vec::new() };
        for change in &edit.changes {
            let object = change.object_id();
            let before = self.make(change);
            let after = self.revision(object);
            applied.revisions.push(RevisionChange { object, before: change.base(), after });
            applied.inverse.changes.extend(match (before, after) {
                (Some(before), base) => Some(Change::Put { base, object: before.object }),
                (None, Some(base)) => Some(Change::Remove { base, object }),
                // Nothing was there, and nothing is.
                (None, None) => None,
            });
        }
        Ok(applied)
    }

    /// Whether an edit could be applied.
    ///
    /// # Errors
    /// Why not.
    pub fn check(&self, edit: &Edit) -> Result<(), EditError> {
        self.edit_errors(edit).next().map_or(Ok(()), Err)
    }

    /// All reasons why an edit cannot be applied, in the order of its changes. None: it can.
    pub fn edit_errors(&self, edit: &Edit) -> impl Iterator<Item = EditError> {
        let mut changed = BTreeSet::new();
        edit.changes.iter().filter_map(move |change| {
            let object = change.object_id();
            if !changed.insert(object) {
                return Some(EditError::ChangedTwice(object));
            }
            let revision = self.revision(object);
            if change.base() != revision {
                return Some(EditError::Conflict { object, revision });
            }
            match change {
                Change::Put { object, .. } if !is_finite(object) => Some(EditError::NotFinite(object.id())),
                _ => None,
            }
        })
    }

    /// The revision that a change of this object would be given.
    pub fn next_revision(&self, object: ObjectId) -> Revision {
        let last = self.revision(object).or_else(|| self.removed.get(&object).copied()).unwrap_or_default();
        Revision(last.0 + 1)
    }

    /// Makes a change that was checked. Returns what was there before.
    fn make(&mut self, change: &Change) -> Option<Versioned> {
        let id = change.object_id();
        let revision = self.next_revision(id);
        match change {
            Change::Put { object, .. } => {
                self.removed.remove(&id);
                self.objects.insert(id, Versioned { revision, object: object.clone() })
            }
            Change::Remove { .. } => {
                self.removed.insert(id, revision);
                self.objects.remove(&id)
            }
        }
    }

    /// An edit that puts an object, whether or not one of its id is there.
    pub fn put(&self, id: EditId, object: Object) -> Edit {
        Edit { id, changes: vec![Change::Put { base: self.revision(object.id()), object }] }
    }

    /// An edit that removes an object and all that cannot be without it: with a node its edges and docks, with an edge its block. Tasks that refer to what is
    /// removed stay, and are problems of their missions, because only a person knows what to do instead.
    pub fn removal(&self, id: EditId, object: ObjectId) -> Edit {
        let mut removed = BTreeSet::from([object]);
        if let ObjectId::Node(node) = object {
            for Versioned { object, .. } in self.objects() {
                let depends = match object {
                    Object::Edge(edge) => edge.from == node || edge.to == node,
                    Object::Dock(dock) => dock.node == node || dock.approach == node,
                    _ => false,
                };
                if depends {
                    removed.insert(object.id());
                }
            }
        }
        let blocks: Vec<_> = removed
            .iter()
            .filter_map(|id| match id {
                ObjectId::Edge(edge) => Some(ObjectId::EdgeBlock(*edge)),
                _ => None,
            })
            .collect();
        removed.extend(blocks);
        let changes = removed
            .into_iter()
            .filter_map(|object| Some(Change::Remove { base: self.revision(object)?, object }));
        Edit { id, changes: changes.collect() }
    }

    /// The missions with a task that refers to this object, directly or by an inspection point. Linear in the tasks.
    pub fn missions_that_need(&self, object: ObjectId) -> BTreeSet<MissionId> {
        let missions =
            self.missions().filter(|mission| mission.tasks.iter().any(|task| task_needs(self, task, object)));
        missions.map(|mission| mission.id).collect()
    }
}

/// Whether a task refers to an object, directly or by its inspection point.
fn task_needs(site: &Site, task: &Task, object: ObjectId) -> bool {
    match &task.place {
        TaskPlace::InspectionPoint(point) => {
            object == ObjectId::InspectionPoint(*point)
                || site.inspection_point(*point).is_some_and(|it| object == ObjectId::Node(it.node))
        }
        place @ (TaskPlace::Node { .. } | TaskPlace::ByAction { .. }) => place.object() == Some(object),
    }
}
