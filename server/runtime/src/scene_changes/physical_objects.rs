//! Of which thing each change is: the same thing keeps its id over many runs.

use changes::{
    Change as ObjectChange, IdentityConfig, KnownObject, ObjectSighting, UprightBox, identify_objects,
};
use geometry::vec_from_plain;
use object_identity::Descriptor;
use ports::FoundChange;
use site_model::{
    OrientedBox, PhysicalObject, PhysicalObjectId, SceneChange, SceneChangeKind, ShapeDescriptor,
    object_history,
};
use std::collections::BTreeMap;

/// The thing of each change that a comparison found and that is not known yet; `known` are all earlier changes in the frame of its map, `new_id` makes the id of a thing that is not known. Cubic in
/// the things that are away and in those that appeared.
pub fn physical_objects(
    known: &[&SceneChange],
    found: &[&FoundChange],
    config: &IdentityConfig,
    new_id: impl Fn(usize) -> PhysicalObjectId,
) -> Vec<PhysicalObject> {
    let mut things: BTreeMap<PhysicalObjectId, Vec<&SceneChange>> = BTreeMap::new();
    for change in known {
        if let Some(object) = change.physical_object {
            things.entry(object.id).or_default().push(change);
        }
    }
    let ids: Vec<PhysicalObjectId> = things.keys().copied().collect();
    let things: Vec<KnownObject> = things.into_values().map(known_object).collect();
    let sightings: Vec<ObjectSighting> = found.iter().map(|found| sighting(found)).collect();
    let identified = identify_objects(&things, &sightings, config);
    let object = |(number, (identification, found)): (usize, (_, &&FoundChange))| match identification {
        Some(changes::Identification { known, probability }) => {
            PhysicalObject { id: ids[known], probability }
        }
        None => PhysicalObject { id: new_id(number), probability: found.move_probability.unwrap_or(1.0) },
    };
    identified.into_iter().zip(found).enumerate().map(object).collect()
}

/// What is known of a thing by its changes.
fn known_object(changes: Vec<&SceneChange>) -> KnownObject {
    let stays = object_history(changes.iter().copied());
    let described = changes.iter().filter(|change| change.descriptor.is_some());
    let newest = described.max_by_key(|change| change.last_seen);
    KnownObject {
        places: stays.iter().map(|stay| upright_box(&stay.place)).collect(),
        is_there: stays.last().is_some_and(|stay| stay.until.is_none()),
        descriptor: newest.and_then(|change| descriptor(change.descriptor.as_ref())),
    }
}

fn sighting(found: &FoundChange) -> ObjectSighting {
    ObjectSighting {
        change: object_change(&found.kind),
        place: upright_box(&found.place),
        descriptor: descriptor(found.descriptor.as_ref()),
        move_probability: found.move_probability,
    }
}

fn descriptor(plain: Option<&ShapeDescriptor>) -> Option<Descriptor> {
    plain.map(|ShapeDescriptor { name, values }| Descriptor { name: name.clone(), values: values.clone() })
}

/// What became of an object, with its box.
pub fn object_change(kind: &SceneChangeKind) -> ObjectChange {
    match kind {
        SceneChangeKind::Appeared => ObjectChange::Appeared,
        SceneChangeKind::Removed => ObjectChange::Removed,
        SceneChangeKind::Moved { from } => ObjectChange::Moved { from: upright_box(from) },
    }
}

/// The same box.
pub fn upright_box(place: &OrientedBox) -> UprightBox {
    UprightBox { centre_m: vec_from_plain(place.centre_m), size_m: place.size_m, yaw_rad: place.yaw_rad }
}
