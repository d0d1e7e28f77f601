//! How often somebody may try to sign in.
//!
//! Guessing is slowed for each address, and for each account from addresses and devices that have never signed in to it. There is no lock-out: whoever has signed in
//! to an account before from the same address or browser is not counted with strangers, so that nobody can keep an operator out by guessing.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::time::{Duration, Instant};

/// Parameters of a [`SignInThrottle`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrottleConfig {
    /// Failures in a row that an address may make. Chosen: a person who tries all his passwords needs fewer.
    pub address_burst: f64,
    /// Time after which an address may make one more. Chosen: a person types a password in about that time, so people notice nothing.
    pub address_period: Duration,
    /// Failures in a row that strangers may make for one account. Chosen: as [`Self::address_burst`].
    pub account_burst: f64,
    /// Time after which they may make one more: 1,440 guesses a day. Chosen: they do not find a password of [`crate::PasswordConfig::min_chars`] characters by guessing.
    pub account_period: Duration,
    /// Addresses and accounts that are remembered. The least used are forgotten first. Chosen: it bounds the memory to some hundred kilobytes.
    pub max_remembered: usize,
}

impl Default for ThrottleConfig {
    fn default() -> Self {
        Self {
            address_burst: 10.0,
            address_period: Duration::from_secs(5),
            account_burst: 10.0,
            account_period: Duration::from_secs(60),
            max_remembered: 4_096,
        }
    }
}

/// Failures that are still remembered, as a number that falls with time.
#[derive(Clone, Copy, Debug)]
struct Failures {
    count: f64,
    at: Instant,
}

impl Failures {
    fn now(&self, now: Instant, period: Duration) -> f64 {
        let passed = now.saturating_duration_since(self.at).as_secs_f64() / period.as_secs_f64();
        (self.count - passed).max(0.0)
    }
}

/// Whose failures are counted together.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    Address(Option<IpAddr>),
    /// An account, tried by strangers.
    Account(String),
}

/// Counts failures to sign in.
#[derive(Debug, Default)]
pub struct SignInThrottle {
    config: ThrottleConfig,
    failures: BTreeMap<Key, Failures>,
}

impl SignInThrottle {
    /// With these parameters.
    pub fn new(config: ThrottleConfig) -> Self {
        Self { config, failures: BTreeMap::new() }
    }

    /// How long somebody has to wait before the next try; `None`: it may be made now. `is_known`: this address or browser has signed in to the account before.
    pub fn wait(
        &self,
        address: Option<IpAddr>,
        account: &str,
        is_known: bool,
        now: Instant,
    ) -> Option<Duration> {
        self.keys(address, account, is_known)
            .into_iter()
            .filter_map(|key| {
                let (burst, period) = self.limits(&key);
                let over = self.failures.get(&key)?.now(now, period) + 1.0 - burst;
                (over > 0.0).then(|| period.mul_f64(over))
            })
            .max()
    }

    /// A try has failed.
    pub fn failed(&mut self, address: Option<IpAddr>, account: &str, is_known: bool, now: Instant) {
        for key in self.keys(address, account, is_known) {
            let (_, period) = self.limits(&key);
            let count = self.failures.get(&key).map_or(0.0, |failures| failures.now(now, period)) + 1.0;
            self.failures.insert(key, Failures { count, at: now });
        }
        while self.failures.len() > self.config.max_remembered {
            let period = |key: &Key| self.limits(key).1;
            let least = self
                .failures
                .iter()
                .min_by(|(a, x), (b, y)| x.now(now, period(a)).total_cmp(&y.now(now, period(b))));
            let Some(key) = least.map(|(key, _)| key.clone()) else { return };
            self.failures.remove(&key);
        }
    }

    /// A known browser is counted by itself, not with its address: others may be behind the same proxy.
    fn keys(&self, address: Option<IpAddr>, account: &str, is_known: bool) -> Vec<Key> {
        if is_known {
            return vec![Key::Account(format!("{account} known at {}", text(address)))];
        }
        vec![Key::Address(address), Key::Account(account.to_owned())]
    }

    fn limits(&self, key: &Key) -> (f64, Duration) {
        match key {
            Key::Address(_) => (self.config.address_burst, self.config.address_period),
            Key::Account(_) => (self.config.account_burst, self.config.account_period),
        }
    }
}

fn text(address: Option<IpAddr>) -> String {
    address.map_or_else(String::new, |address| address.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;

    fn address(last: u8) -> Option<IpAddr> {
        Some(IpAddr::V4(Ipv4Addr::new(10, 0, 0, last)))
    }

    #[test]
    fn guessing_is_slowed_and_time_forgives() {
        let (mut throttle, now) = (SignInThrottle::default(), Instant::now());
        for _ in 0..10 {
            assert_eq!(throttle.wait(address(1), "ada", false, now), None);
            throttle.failed(address(1), "ada", false, now);
        }
        let wait = throttle.wait(address(1), "ada", false, now).expect("too many");
        assert_eq!(wait, Duration::from_secs(60));
        assert_eq!(throttle.wait(address(1), "ada", false, now + wait), None);
        assert_eq!(throttle.wait(address(1), "bob", false, now), Some(Duration::from_secs(5)), "the address");
        assert_eq!(throttle.wait(address(2), "bob", false, now), None);
    }

    #[test]
    fn strangers_with_many_addresses_do_not_keep_a_known_browser_out() {
        let (mut throttle, now) = (SignInThrottle::default(), Instant::now());
        for stranger in 1..200 {
            throttle.failed(address(stranger), "ada", false, now);
        }
        assert!(throttle.wait(address(201), "ada", false, now).is_some());
        assert_eq!(throttle.wait(address(7), "ada", true, now), None);
    }

    #[test]
    fn few_are_remembered() {
        let config = ThrottleConfig { max_remembered: 10, ..ThrottleConfig::default() };
        let (mut throttle, now) = (SignInThrottle::new(config), Instant::now());
        for stranger in 1..100 {
            throttle.failed(address(stranger), &format!("account{stranger}"), false, now);
            throttle.failed(address(0), "ada", false, now);
        }
        assert_eq!(throttle.failures.len(), 10);
        assert!(throttle.wait(address(0), "ada", false, now).is_some(), "the busiest stays");
    }
}
