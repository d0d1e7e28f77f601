//! Where the robot's body touches solids and people, by the truth. For scorers.

use crate::people::People;
use geometry::Vector3;
use vocab::{Span, Stamp, Vec3};

/// A touch belongs to the last one with the same thing if that was at most this long ago.
const SAME_CONTACT: Span = Span::from_millis(500);
/// The robot has caused a contact with a person if it moved towards them faster than this, m/s. A robot that stands still only sways.
const CAUSED_SPEED_M_S: f64 = 0.05;

/// What the robot touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactWith {
    /// A solid of the site, other than floors and ceilings.
    Solid,
    /// A person, by their number.
    Person(u32),
}

/// The beginning of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The instant.
    pub at: Stamp,
    /// The thing.
    pub with: ContactWith,
    /// The base, site frame, metres.
    pub position: Vec3,
    /// Speed of the robot towards the thing, m/s.
    pub closing_m_s: f64,
    /// Whether the robot moved into it. Otherwise a person walked into the robot.
    pub is_by_robot: bool,
}

/// The robot's body at an instant.
pub(crate) struct TouchingBody {
    /// The base, site frame, metres.
    pub(crate) position: Vector3,
    /// Velocity of the base, site frame, m/s.
    pub(crate) velocity: Vector3,
    /// Centres and radii of the spheres that the body consists of, site frame, metres.
    pub(crate) spheres: [(Vector3, f64); 2],
    /// Whether a solid has stopped it or turned it aside.
    pub(crate) touches_solid: bool,
}

/// The contacts so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contacts {
    begun: Vec<Contact>,
    /// Things that are touched, and when that was last.
    touched: Vec<(ContactWith, Stamp)>,
}

impl Contacts {
    /// Looks at the present instant.
    pub(crate) fn update(&mut self, at: Stamp, body: &TouchingBody, people: &People) {
        self.touched.retain(|(_, last)| at - *last <= SAME_CONTACT);
        if body.touches_solid {
            let closing_m_s = body.velocity.xy().norm();
            self.touch(at, ContactWith::Solid, body, closing_m_s, true);
        }
        for (person, place) in people.touched_by(&body.spheres) {
            let towards = (place - body.position).xy().try_normalize(1e-6).unwrap_or_default();
            let closing_m_s = body.velocity.xy().dot(&towards);
            let is_by_robot = closing_m_s > CAUSED_SPEED_M_S;
            self.touch(at, ContactWith::Person(person), body, closing_m_s, is_by_robot);
        }
    }

    fn touch(
        &mut self,
        at: Stamp,
        with: ContactWith,
        body: &TouchingBody,
        closing_m_s: f64,
        is_by_robot: bool,
    ) {
        if let Some((_, last)) = self.touched.iter_mut().find(|(known, _)| *known == with) {
            *last = at;
            return;
        }
        self.touched.push((with, at));
        let position = geometry::vec_to_plain(&body.position);
        self.begun.push(Contact { at, with, position, closing_m_s, is_by_robot });
    }

    /// The contacts that have begun since the last call.
    pub(crate) fn take(&mut self) -> Vec<Contact> {
        std::mem::take(&mut self.begun)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::site::{SimulatedSite, SiteName};
    use geometry::RngTree;

    /// A body whose hull reaches the middle of a person, at this velocity.
    fn body_at(place: &Vector3, velocity: Vector3) -> TouchingBody {
        let position = place - Vector3::x() * 0.3 + Vector3::z() * 0.5;
        let spheres = [(position + Vector3::z() * 0.1, 0.36), (position + Vector3::z() * 0.35, 0.28)];
        TouchingBody { position, velocity, spheres, touches_solid: false }
    }

    #[test]
    fn whoever_moves_into_the_other_has_caused_the_contact() {
        let people = People::new(&SimulatedSite::new(SiteName::B1), 1, RngTree::new(1));
        let place = people.positions()[0];
        for (velocity, is_by_robot) in [
            (Vector3::x() * 0.5, true),
            (Vector3::zeros(), false),
            (Vector3::x() * -0.5, false),
            (Vector3::y() * 0.5, false),
        ] {
            let mut contacts = Contacts::default();
            contacts.update(Stamp::EPOCH, &body_at(&place, velocity), &people);
            let found = contacts.take();
            assert_eq!(found.len(), 1, "{found:?}");
            assert_eq!((found[0].with, found[0].is_by_robot), (ContactWith::Person(0), is_by_robot));
        }
        let away = place + Vector3::y() * 2.0;
        let mut contacts = Contacts::default();
        contacts.update(Stamp::EPOCH, &body_at(&away, Vector3::zeros()), &people);
        assert!(contacts.take().is_empty());
    }

    #[test]
    fn touches_shortly_after_each_other_are_one_contact() {
        let people = People::default();
        let wall = TouchingBody { touches_solid: true, ..body_at(&Vector3::zeros(), Vector3::x()) };
        let mut contacts = Contacts::default();
        for milliseconds in [0, 10, 400, 800, 1_400] {
            contacts.update(Stamp::EPOCH + Span::from_millis(milliseconds), &wall, &people);
        }
        let begun: Vec<i64> =
            contacts.take().iter().map(|it| (it.at - Stamp::EPOCH).nanos() / 1_000_000).collect();
        assert_eq!(begun, [0, 1_400]);
    }
}
