//! Picking corresponding points, and how well they agree.

use crate::testing::*;
use crate::*;
use api::Command;
use uuid::Uuid;
use vocab::{MapId, Vec3};

#[test]
fn points_are_picked_in_one_map_and_the_other_in_turn_and_may_be_taken_back() {
    let mut client = TestClient::connected();
    let [map, onto, third] = [1, 2, 3].map(|number| MapId(Uuid::from_u128(number)));
    let at = |x: f64| Vec3::new(x, 0.5 * x * x, 1.0);
    client.command(ClientCommand::AlignMap { map, reference: None });
    client.command(ClientCommand::AddAlignmentPoint(at(0.0)));
    assert!(client.model.alignment().is_some_and(|align| align.unpaired.is_none()), "onto which?");
    client.command(ClientCommand::AlignMap { map, reference: Some(onto) });
    for number in 0..2 {
        assert_eq!(client.model.viewed_map(), Some(map));
        client.command(ClientCommand::AddAlignmentPoint(at(f64::from(number))));
        assert_eq!(client.model.viewed_map(), Some(onto));
        client.command(ClientCommand::AddAlignmentPoint(at(f64::from(number) + 10.0)));
    }
    client.command(ClientCommand::AddAlignmentPoint(at(9.0)));
    client.command(ClientCommand::Undo);
    assert_eq!(client.model.viewed_map(), Some(map));
    client.command(ClientCommand::Undo);
    assert_eq!(client.model.viewed_map(), Some(onto));
    let picked = client.model.alignment().map(|align| (align.points_in(map), align.points_in(onto)));
    assert_eq!(picked, Some((vec![at(0.0), at(1.0)], vec![at(10.0)])));
    client.command(ClientCommand::ViewMap(Some(map)));
    client.command(ClientCommand::AddAlignmentPoint(at(5.0)));
    assert!(client.model.alignment().is_some_and(|align| align.pairs.len() == 1), "its like is asked for");
    client.command(ClientCommand::ViewMap(Some(onto)));
    client.command(ClientCommand::AddAlignmentPoint(at(12.0)));
    client.take_effects();
    client.command(ClientCommand::StartAlignment);
    let commands = client.take_commands();
    let [Command::AlignMap { map: laid, onto: frame, pairs, .. }] = commands.as_slice() else {
        panic!("{commands:?}")
    };
    assert_eq!((*laid, *frame), (map, onto));
    assert_eq!(*pairs, [[at(0.0), at(10.0)], [at(1.0), at(12.0)]]);
    let work = client.model.alignment().and_then(|align| align.job).expect("under way");
    client.command(ClientCommand::AddAlignmentPoint(at(6.0)));
    client.command(ClientCommand::Undo);
    let pairs = |client: &TestClient| client.model.alignment().map(|align| align.pairs.len());
    assert_eq!(pairs(&client), Some(2), "nothing changes meanwhile");
    let reason = "It was cancelled.".to_owned();
    client.event(api::Event::Import(api::Import::Failed { upload: work, name: String::new(), reason }));
    client.take_effects();
    client.command(ClientCommand::StartAlignment);
    assert_eq!((pairs(&client), client.take_commands().len()), (Some(2), 1), "once more");
    let work = client.model.alignment().and_then(|align| align.job).expect("under way");
    client.event(api::Event::Import(api::Import::Done { upload: work, map: third }));
    assert_eq!(client.model.alignment(), None);

    client.command(ClientCommand::AlignMap { map, reference: Some(onto) });
    client.command(ClientCommand::ViewMap(Some(third)));
    assert_eq!(client.model.alignment(), None, "something else is viewed");
    client.command(ClientCommand::AlignMap { map, reference: Some(onto) });
    client.command(ClientCommand::CancelAlignment);
    assert_eq!((client.model.alignment(), client.model.viewed_map()), (None, Some(map)));
}

fn alignment(pairs: Vec<[Vec3; 2]>) -> AlignmentDraft {
    let [map, reference] = [1, 2].map(|number| MapId(Uuid::from_u128(number)));
    AlignmentDraft { map, reference: Some(reference), pairs, unpaired: None, job: None }
}

#[test]
fn the_residual_is_what_no_heading_and_translation_removes() {
    let (sin, cos) = 0.7_f64.sin_cos();
    let moved = |x: f64, y: f64, z: f64| {
        [Vec3::new(x, y, z), Vec3::new(cos * x - sin * y + 4.0, sin * x + cos * y - 9.0, z + 1.5)]
    };
    let mut exact = alignment(vec![moved(0.0, 0.0, 0.0), moved(5.0, 1.0, 0.4), moved(-2.0, 7.0, 2.0)]);
    assert!(exact.rms_residual_m().is_some_and(|residual| residual < 1e-9));
    exact.pairs[1][1].z += 0.3;
    // The mean of the three height differences is removed: 0.3 * sqrt(2) / 3 remains.
    let expected = 0.3 * 2_f64.sqrt() / 3.0;
    assert!(exact.rms_residual_m().is_some_and(|residual| (residual - expected).abs() < 1e-9));
    assert_eq!(alignment(vec![moved(1.0, 1.0, 0.0)]).rms_residual_m(), None);
    assert_eq!(alignment(vec![moved(1.0, 1.0, 0.0), moved(1.0, 1.0, 3.0)]).rms_residual_m(), None);
}
