//! Connections of each address: one computer does not take the places of all.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Counts the connections of each address.
#[derive(Clone, Debug)]
pub(crate) struct AddressPlaces {
    most: usize,
    taken: Arc<Mutex<HashMap<IpAddr, usize>>>,
}

impl AddressPlaces {
    /// At most this number for each address.
    pub(crate) fn new(most: usize) -> Self {
        Self { most, taken: Arc::default() }
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<IpAddr, usize>> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A place, if the address has one left. It is given back when it is dropped.
    pub(crate) fn claim(&self, address: IpAddr) -> Option<AddressPlace> {
        let address = address.to_canonical();
        let mut taken = self.lock();
        let count = taken.entry(address).or_default();
        if *count >= self.most {
            return None;
        }
        *count += 1;
        drop(taken);
        Some(AddressPlace { places: self.clone(), address })
    }
}

/// A place of an address.
#[derive(Debug)]
pub(crate) struct AddressPlace {
    places: AddressPlaces,
    address: IpAddr,
}

impl Drop for AddressPlace {
    fn drop(&mut self) {
        let mut taken = self.places.lock();
        if let Some(count) = taken.get_mut(&self.address) {
            *count -= 1;
            if *count == 0 {
                taken.remove(&self.address);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_address_takes_its_share_and_gives_it_back() {
        let places = AddressPlaces::new(2);
        let [one, other]: [IpAddr; 2] = [[192, 0, 2, 1].into(), [192, 0, 2, 2].into()];
        let taken = [places.claim(one), places.claim("::ffff:192.0.2.1".parse().expect("an address"))];
        assert!(taken.iter().all(Option::is_some));
        assert!(places.claim(one).is_none() && places.claim(other).is_some());
        drop(taken);
        assert!(places.claim(one).is_some());
        assert!(places.lock().len() <= 1, "nothing is kept of addresses that have gone");
    }
}
