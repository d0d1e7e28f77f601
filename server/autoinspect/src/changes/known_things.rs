//! Things over many comparisons: what the result of an earlier comparison knows is carried on.

use super::document::{Document, Kind, Object};
use super::thing::{KnownThing, PlainDescriptor, Stay, ThingOfObject};
use changes::{Change, IdentityConfig, KnownObject, ObjectSighting, identify_objects};
use site_model::{ObjectStay, SceneChangeKind, record_stay};

/// The document with the things that its objects are, also of those that an earlier comparison knows.
pub fn following(mut document: Document, earlier: Option<Document>) -> Document {
    if let Some(earlier) = earlier {
        document.comparison = earlier.comparison.saturating_add(1);
        document.known = earlier.known;
    }
    identify(&mut document.known, &mut document.objects, document.comparison);
    document
}

/// Says of each object which thing it is, and adds its change to what is known.
fn identify(known: &mut Vec<KnownThing>, objects: &mut [Object], comparison: u32) {
    let things: Vec<KnownObject> = known.iter().map(known_object).collect();
    let sightings: Vec<ObjectSighting> = objects.iter().map(sighting).collect();
    let identified = identify_objects(&things, &sightings, &IdentityConfig::default());
    for (object, identification) in objects.iter_mut().zip(identified) {
        let (place, probability) = match identification {
            Some(found) => (found.known, found.probability),
            None => {
                let id = known.iter().map(|thing| thing.id).max().unwrap_or(0) + 1;
                known.push(KnownThing { id, history: Vec::new(), descriptor: None });
                (known.len() - 1, object.move_probability.unwrap_or(1.0))
            }
        };
        let thing = &mut known[place];
        let kind = match (object.kind, object.from) {
            (Kind::Appeared, _) => SceneChangeKind::Appeared,
            (Kind::Moved, Some(from)) => SceneChangeKind::Moved { from: from.oriented_box() },
            (Kind::Removed | Kind::Moved, _) => SceneChangeKind::Removed,
        };
        let mut stays: Vec<ObjectStay<u32>> = thing.history.iter().map(Stay::stay).collect();
        record_stay(&mut stays, &kind, &object.place.oriented_box(), comparison, probability);
        thing.history = stays.iter().map(Stay::new).collect();
        thing.descriptor = object.descriptor.clone().or(thing.descriptor.take());
        object.physical_object =
            Some(ThingOfObject { id: thing.id, probability, history: thing.history.clone() });
    }
}

fn known_object(thing: &KnownThing) -> KnownObject {
    KnownObject {
        places: thing.history.iter().map(|stay| stay.place.upright_box()).collect(),
        is_there: thing.history.last().is_some_and(|stay| stay.until.is_none()),
        descriptor: thing.descriptor.as_ref().map(PlainDescriptor::descriptor),
    }
}

fn sighting(object: &Object) -> ObjectSighting {
    let change = match (object.kind, &object.from) {
        (Kind::Appeared, _) => Change::Appeared,
        (Kind::Moved, Some(from)) => Change::Moved { from: from.upright_box() },
        (Kind::Removed | Kind::Moved, _) => Change::Removed,
    };
    ObjectSighting {
        change,
        place: object.place.upright_box(),
        descriptor: object.descriptor.as_ref().map(PlainDescriptor::descriptor),
        move_probability: object.move_probability,
    }
}

#[cfg(test)]
mod tests {
    use super::super::place::Place;
    use super::*;

    fn object(kind: Kind, x: f64) -> Object {
        let place = |x| Place { centre_m: [x, 0.0, 0.5], size_m: [0.6, 0.4, 1.0], yaw_rad: 0.0 };
        Object {
            id: 1,
            kind,
            place: place(x),
            points: 90,
            confidence: 0.99,
            from: None,
            move_probability: None,
            descriptor: None,
            physical_object: None,
        }
    }

    #[test]
    fn a_thing_is_known_again_in_a_later_comparison() {
        let mut known = Vec::new();
        identify(&mut known, &mut [object(Kind::Removed, 2.0)], 1);
        identify(&mut known, &mut [], 2);
        let mut later = [object(Kind::Appeared, 20.0)];
        identify(&mut known, &mut later, 4);
        let thing = later[0].physical_object.as_ref().expect("identified");
        assert!(thing.id == 1 && (0.5..1.0).contains(&thing.probability), "{thing:?}");
        let stays: Vec<_> =
            thing.history.iter().map(|stay| (stay.place.centre_m[0], stay.from, stay.until)).collect();
        assert_eq!(stays, [(2.0, None, Some(1)), (20.0, Some(4), None)]);
        assert_eq!(known.len(), 1);
        identify(&mut known, &mut [object(Kind::Removed, 50.0)], 5);
        assert_eq!(known.len(), 2);
    }
}
