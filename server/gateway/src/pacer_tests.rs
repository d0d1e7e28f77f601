use super::*;
use proptest::prelude::*;

const SCAN: Duration = Duration::from_millis(100);

fn open(max_hz: f32) -> (Pacer, Instant) {
    let mut pacer = Pacer::new(PacerConfig::default());
    pacer.set_rate(max_hz);
    (pacer, Instant::now())
}

#[test]
fn at_most_four_are_in_flight() {
    let (mut pacer, now) = open(1e9);
    let later = |i: u32| now + i * SCAN;
    for i in 0..4 {
        assert_eq!(pacer.permission(later(i)), Permission::Send);
        pacer.sent(later(i));
    }
    assert_eq!(pacer.permission(later(4)), Permission::AfterMessage);
    assert_eq!(pacer.acknowledged(2, later(4)), Ok(()));
    assert_eq!(pacer.unacknowledged.len(), 2);
    assert_eq!(pacer.permission(later(4)), Permission::Send);
}

#[test]
fn the_rate_is_kept_and_zero_or_nonsense_pauses() {
    let (mut pacer, now) = open(2.0);
    pacer.sent(now);
    assert_eq!(pacer.permission(now + SCAN), Permission::At(now + 5 * SCAN));
    assert_eq!(pacer.permission(now + 5 * SCAN), Permission::Send);
    for odd in [0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
        pacer.set_rate(odd);
        assert!(!pacer.wants_scans(), "{odd}");
        assert_eq!(pacer.permission(now + 50 * SCAN), Permission::AfterMessage);
    }
    for odd in [f32::INFINITY, f32::MIN_POSITIVE, f32::MAX] {
        pacer.set_rate(odd);
        assert!(pacer.wants_scans(), "{odd}");
    }
}

#[test]
fn frames_never_sent_cannot_be_acknowledged() {
    let (mut pacer, now) = open(10.0);
    assert_eq!(pacer.acknowledged(0, now), Err(UnknownFrame));
    assert_eq!(pacer.acknowledged(1, now), Err(UnknownFrame));
    pacer.sent(now);
    assert_eq!(pacer.acknowledged(2, now), Err(UnknownFrame));
    assert_eq!(pacer.acknowledged(1, now), Ok(()));
    assert_eq!(pacer.acknowledged(1, now), Ok(()), "twice does nothing");
}

/// Sends 10 scans a second for 30 s over a link that carries one frame per `carry` after `delay`, and returns frames
/// received per second and the age of the last frame on arrival.
fn simulate(delay: Duration, carry: Duration) -> (f64, Duration) {
    let (mut pacer, start) = open(10.0);
    let (mut link_free, mut age, mut received) = (start, Duration::ZERO, 0);
    let mut acknowledgements: VecDeque<(Instant, u64)> = VecDeque::new();
    let mut fresh = false;
    for millis in 0..30_000_u64 {
        let now = start + Duration::from_millis(millis);
        fresh |= millis % 100 == 0;
        while acknowledgements.front().is_some_and(|(at, _)| *at <= now) {
            let (_, sequence) = acknowledgements.pop_front().expect("just seen");
            pacer.acknowledged(sequence, now).expect("was sent");
            received += 1;
        }
        if fresh && pacer.permission(now) == Permission::Send {
            fresh = false;
            let sequence = pacer.sent(now);
            link_free = link_free.max(now) + carry;
            age = link_free + delay - now;
            acknowledgements.push_back((link_free + 2 * delay, sequence));
        }
    }
    (f64::from(received) / 30.0, age)
}

#[test]
fn a_good_link_gets_every_scan_near_or_far() {
    for delay in [1, 20, 150] {
        let (hz, _) = simulate(Duration::from_millis(delay), Duration::from_millis(2));
        assert!(hz > 9.5, "{hz} Hz at {delay} ms");
    }
}

#[test]
fn a_thin_link_gets_fewer_scans_rather_than_old_ones() {
    let carry = Duration::from_millis(400);
    let (hz, age) = simulate(Duration::from_millis(20), carry);
    assert!(hz > 1.8, "uses the link: {hz} Hz of 2.5");
    assert!(age < 3 * carry, "{age:?}: four under way would make it 1.6 s");
}

proptest! {
    #[test]
    fn never_more_in_flight_than_allowed_and_never_stuck(steps in prop::collection::vec((0_u64..400, any::<bool>()), 1..300)) {
        let (mut pacer, mut now) = open(30.0);
        for (wait, acknowledge) in steps {
            now += Duration::from_millis(wait);
            if acknowledge {
                let sequence = pacer.sequence;
                if sequence > 0 { prop_assert_eq!(pacer.acknowledged(sequence, now), Ok(())); }
            }
            if pacer.permission(now) == Permission::Send { pacer.sent(now); }
            prop_assert!(pacer.unacknowledged.len() as u64 <= MAX_UNACKNOWLEDGED);
            if pacer.unacknowledged.is_empty() {
                prop_assert_ne!(pacer.permission(now), Permission::AfterMessage);
            }
        }
    }
}
