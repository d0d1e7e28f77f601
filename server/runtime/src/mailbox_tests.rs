//! Order, replacement and waiting.

use super::*;
use std::sync::Arc;
use std::thread;
use std::time::Duration;
use vocab::Span;

fn notice(text: &str) -> Publication {
    Publication::Notice(Notice { at: Stamp::EPOCH, severity: Severity::Info, text: text.to_owned() })
}

fn estimate(nanos: i64) -> Publication {
    Publication::Estimate(Estimate { stamp: Stamp::EPOCH + Span::from_nanos(nanos), ..Estimate::default() })
}

#[test]
fn only_the_newest_estimate_and_scan_wait_and_everything_else_in_order() {
    let mailbox = Mailbox::default();
    for nanos in 1..=3 {
        mailbox.post(estimate(nanos));
        mailbox.post(notice(&nanos.to_string()));
        let stamp = Stamp::EPOCH + Span::from_nanos(nanos);
        mailbox.post(Publication::Scan(CorrectedScan { stamp, ..CorrectedScan::default() }));
    }
    let mail = mailbox.wait(Instant::now());
    assert_eq!(mail.ordered, ["1", "2", "3"].map(notice));
    assert_eq!(mail.estimate.map(|estimate| estimate.stamp.nanos()), Some(3));
    assert_eq!(mail.scan.map(|scan| scan.stamp.nanos()), Some(3));
    assert!(!mail.closed);
    assert!(mailbox.wait(Instant::now()).is_empty(), "everything was taken");
}

#[test]
fn a_waiting_publisher_is_woken_by_a_publication_and_by_the_end() {
    let mailbox = Arc::new(Mailbox::default());
    let never = Instant::now() + Duration::from_secs(3_600);
    let waiting = thread::spawn({
        let mailbox = Arc::clone(&mailbox);
        move || [mailbox.wait(never), mailbox.wait(never)]
    });
    mailbox.notice(Stamp::EPOCH, Severity::Info, "first".to_owned());
    // The first wait has returned once the publication is gone.
    while !mailbox.lock().ordered.is_empty() {
        thread::yield_now();
    }
    mailbox.close();
    let [first, second] = waiting.join().expect("no panic");
    assert_eq!(first.ordered, [notice("first")]);
    assert!(second.closed && second.is_empty());
}
