//! What the example changes of a site. The whole way is tested with the program, in `server/autoinspect/tests/cli/example.rs`.

use super::*;
use site_model::{MissionId, Recurrence, Schedule, ScheduleId};

fn settings(name: &str, map: Option<MapId>) -> SiteSettings {
    SiteSettings { name: name.to_owned(), time_zone: "Europe/London".to_owned(), map }
}

#[test]
fn what_people_have_set_for_the_whole_site_stays_except_the_map() {
    let map = Some(MapId(Uuid::from_u128(1)));
    let example = || vec![Object::Settings(settings("Example hall", map))];
    let (id, mut site) = (EditId(Uuid::from_u128(2)), Site::default());
    let Change::Put { base: None, object } = &edit_of(&site, id, example()).changes[0] else {
        panic!("the site has no settings")
    };
    assert_eq!(*object, Object::Settings(settings("Example hall", map)));
    let own = site.put(id, Object::Settings(settings("Works", None)));
    site.apply(&own, id).expect("applies");
    let edit = edit_of(&site, id, example());
    let Change::Put { base, object } = &edit.changes[0] else { panic!("{edit:?}") };
    assert!(base.is_some());
    assert_eq!(*object, Object::Settings(settings("Works", map)));
}

#[test]
fn schedules_of_another_robot_s_site_are_held() {
    let recurrence =
        Recurrence::Every { first: missions_first(), interval: vocab::Span::from_millis(3_600_000) };
    let schedule =
        Schedule::new(ScheduleId(Uuid::nil()), "Hourly".to_owned(), MissionId(Uuid::nil()), recurrence);
    let mut objects = [Object::Settings(settings("Example hall", None)), Object::Schedule(schedule)];
    hold_schedules(&mut objects);
    let Object::Schedule(schedule) = &objects[1] else { panic!("{objects:?}") };
    assert!(schedule.is_paused);
}

fn missions_first() -> site_model::LocalDateTime {
    site_model::LocalDateTime {
        date: site_model::LocalDate { year: 2026, month: 11, day: 24 },
        time: site_model::LocalTime { hour: 11, minute: 0 },
    }
}
