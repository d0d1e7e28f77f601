use super::*;
use crate::{decode, encode};
use proptest::prelude::*;
use site_model::{Asset, AssetId, Change, Object};
use uuid::Uuid;

fn asset(number: u128, name: &str) -> Object {
    Object::Asset(Asset {
        id: AssetId(Uuid::from_u128(number)),
        name: name.to_owned(),
        tags: Default::default(),
    })
}

fn edit_id(number: u128) -> EditId {
    EditId(Uuid::from_u128(number))
}

fn assembled(state: &SiteState) -> (SiteState, usize) {
    let mut parts = SiteParts::new(Arc::new(state.clone()));
    let mut assembly = SiteAssembly::default();
    for count in 1.. {
        let part = parts.next_part();
        let bytes = encode(&part);
        assert!(bytes.len() < SITE_PART_BYTES + MAX_OBJECT_BYTES, "{} bytes", bytes.len());
        if let Some(whole) = assembly.add(&decode(&bytes).expect("a part")) {
            assert!(part.is_last);
            return (whole, count);
        }
    }
    unreachable!("a site has a last part");
}

#[test]
fn a_site_of_any_size_is_the_same_after_its_parts() {
    let mut state = SiteState::default();
    assert_eq!(assembled(&state), (SiteState::default(), 1));
    let long = "x".repeat(1_000);
    let put = |number| Change::Put { base: None, object: asset(number, &long) };
    let edit = Edit { id: edit_id(1), changes: (0..1_000).map(put).collect() };
    assert!(state.apply(&SiteChanged { revision: 1, by: None, edit }));
    let remove = |number| {
        let object = ObjectId::Asset(AssetId(Uuid::from_u128(number)));
        Change::Remove { base: Revision(1), object }
    };
    let edit = Edit { id: edit_id(2), changes: (500..1_000).map(remove).collect() };
    assert!(state.apply(&SiteChanged { revision: 2, by: None, edit }));
    let (whole, parts) = assembled(&state);
    assert_eq!(whole, state);
    assert!((2..5).contains(&parts), "{parts}");
}

#[test]
fn parts_out_of_order_make_no_site() {
    let part = |revision, index, is_last| SitePart { revision, index, is_last, ..SitePart::default() };
    let mut assembly = SiteAssembly::default();
    assert_eq!(assembly.add(&part(1, 1, true)), None);
    assert_eq!(assembly.add(&part(1, 0, false)), None);
    assert_eq!(assembly.add(&part(2, 1, true)), None, "of another site");
    assert_eq!(assembly.add(&part(1, 0, false)), None);
    assert_eq!(assembly.add(&part(1, 2, true)), None, "one is missing");
    assert_eq!(assembly.add(&part(3, 0, false)), None);
    assert_eq!(assembly.add(&part(3, 1, true)).map(|state| state.revision), Some(3));
}

#[test]
fn only_the_next_change_is_applied() {
    let change = |revision, name: &str, base| {
        let changes = vec![Change::Put { base, object: asset(1, name) }];
        SiteChanged { revision, by: None, edit: Edit { id: edit_id(revision.into()), changes } }
    };
    let mut state = SiteState::default();
    assert!(!state.apply(&change(2, "a", None)));
    assert!(state.apply(&change(1, "a", None)));
    assert!(!state.apply(&change(1, "a", None)));
    assert!(!state.apply(&change(2, "b", Some(Revision(7)))), "it does not fit");
    assert!(state.apply(&change(2, "b", Some(Revision(1)))));
    assert_eq!((state.revision, state.site.objects().len()), (2, 1));
}

proptest! {
    /// Messages from outside must not take more stack than there is.
    #[test]
    fn deeply_nested_parameters_are_refused(depth in 1_000_usize..100_000) {
        // A list of one list of one list.
        let bytes: Vec<u8> = [4, 1].into_iter().cycle().take(2 * depth).collect();
        prop_assert!(decode::<site_model::Parameter>(&bytes).is_err());
    }
}
