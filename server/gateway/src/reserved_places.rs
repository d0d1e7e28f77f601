//! Places for connections that come when all others are taken, so that somebody can still sign in and stop the robot.
//!
//! They are never full for a newcomer: it takes the place of another connection, of the address that has most of them, and of those the oldest. One of which the
//! core handles a sign-in, or a request of somebody who has signed in, goes last. So one address that floods the server loses its own connections only, and many addresses that send nothing lose theirs.

use std::collections::{BTreeMap, HashMap};
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::oneshot;

/// The places.
#[derive(Clone, Debug)]
pub(crate) struct ReservedPlaces {
    most: usize,
    taken: Arc<Mutex<TakenPlaces>>,
}

#[derive(Debug, Default)]
struct TakenPlaces {
    next: u64,
    /// In the order of their arrival.
    places: BTreeMap<ReservedPlaceId, Occupant>,
}

/// Names a connection at a reserved place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ReservedPlaceId(u64);

#[derive(Debug)]
struct Occupant {
    address: IpAddr,
    /// Whether the core handles its request.
    is_served: bool,
    /// Dropped when the connection has to go.
    _stay: oneshot::Sender<()>,
}

impl ReservedPlaces {
    /// This number of places.
    pub(crate) fn new(most: usize) -> Self {
        Self { most, taken: Arc::default() }
    }

    fn lock(&self) -> MutexGuard<'_, TakenPlaces> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A place for a connection from this address, if there are any; perhaps that of another one. The receiver ends when the connection has to go.
    pub(crate) fn claim(&self, address: IpAddr) -> Option<(ReservedPlace, oneshot::Receiver<()>)> {
        if self.most == 0 {
            return None;
        }
        let mut taken = self.lock();
        while taken.places.len() >= self.most {
            let leaving = taken.next_to_leave()?;
            taken.places.remove(&leaving);
        }
        let id = ReservedPlaceId(taken.next);
        taken.next += 1;
        let (stay, leave) = oneshot::channel();
        let address = address.to_canonical();
        taken.places.insert(id, Occupant { address, is_served: false, _stay: stay });
        drop(taken);
        Some((ReservedPlace { places: self.clone(), id }, leave))
    }

    /// The core handles a request of this connection.
    pub(crate) fn serve(&self, id: ReservedPlaceId) {
        if let Some(occupant) = self.lock().places.get_mut(&id) {
            occupant.is_served = true;
        }
    }
}

impl TakenPlaces {
    /// Who has to go for a newcomer.
    fn next_to_leave(&self) -> Option<ReservedPlaceId> {
        let mut counts: HashMap<IpAddr, usize> = HashMap::new();
        for occupant in self.places.values() {
            *counts.entry(occupant.address).or_default() += 1;
        }
        let rank = |(id, occupant): &(&ReservedPlaceId, &Occupant)| {
            (!occupant.is_served, counts[&occupant.address], std::cmp::Reverse(**id))
        };
        self.places.iter().max_by_key(rank).map(|(id, _)| *id)
    }
}

/// A reserved place. It is given back when it is dropped.
#[derive(Debug)]
pub(crate) struct ReservedPlace {
    places: ReservedPlaces,
    id: ReservedPlaceId,
}

impl ReservedPlace {
    /// The name of the connection that has it.
    pub(crate) fn id(&self) -> ReservedPlaceId {
        self.id
    }
}

impl Drop for ReservedPlace {
    fn drop(&mut self) {
        self.places.lock().places.remove(&self.id);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::sync::oneshot::error::TryRecvError;

    fn address(last: u8) -> IpAddr {
        [192, 0, 2, last].into()
    }

    fn has_to_go(leave: &mut oneshot::Receiver<()>) -> bool {
        leave.try_recv() == Err(TryRecvError::Closed)
    }

    #[test]
    fn a_flood_of_one_address_loses_its_own_places_only() {
        let places = ReservedPlaces::new(4);
        let (_place, mut leave) = places.claim(address(1)).expect("a place");
        let flood: Vec<_> = (0..100).filter_map(|_| places.claim(address(2))).collect();
        assert_eq!(flood.len(), 100);
        assert!(!has_to_go(&mut leave));
        assert_eq!(places.lock().places.len(), 4);
    }

    #[test]
    fn many_addresses_push_each_other_out_but_not_whom_the_core_serves() {
        let places = ReservedPlaces::new(4);
        let (served, mut leave_served) = places.claim(address(1)).expect("a place");
        places.serve(served.id());
        let (_silent, mut leave_silent) = places.claim(address(2)).expect("a place");
        let _flood: Vec<_> = (10..100).filter_map(|last| places.claim(address(last))).collect();
        assert!(has_to_go(&mut leave_silent) && !has_to_go(&mut leave_served));
    }

    #[test]
    fn a_place_is_given_back_and_none_is_given_where_there_are_none() {
        let places = ReservedPlaces::new(1);
        drop(places.claim(address(1)));
        assert!(places.lock().places.is_empty());
        assert!(ReservedPlaces::new(0).claim(address(1)).is_none());
    }
}
