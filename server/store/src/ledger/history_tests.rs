//! Results of a year: the history of one inspection point is read in pages, whatever the number of all results.

use super::*;
use crate::Store;
use messages::{LedgerEvent, ResultRecord};
use site_model::{InspectionPointId, RunId};
use std::time::Instant;
use uuid::Uuid;
use vocab::Stamp;

const POINTS: u64 = 20;

fn point(index: u64) -> InspectionPointId {
    InspectionPointId(Uuid::from_u128(u128::from(1_000 + index)))
}

/// Writes this number of results, in turn of each point, with reports as long as those of thermal photos.
fn write(ledger: &mut Ledger, count: u64) {
    let covariance = vec![vec![1.234_567_890_123e-6; 6]; 6];
    let readings = ["centre", "lowest", "highest"].map(
        |name| serde_json::json!({ "name": format!("{name}_temperature"), "value": 21.437, "unit": "°C" }),
    );
    let value = serde_json::json!({ "place": { "covariance": covariance }, "readings": readings });
    for first in (0..count).step_by(1_000) {
        let events = first..count.min(first + 1_000);
        let written = ledger.write(|writer| {
            for number in events.clone() {
                let body = serde_json::json!({ "inspection_point": point(number % POINTS), "value": value });
                let (run, kind) =
                    (RunId(Uuid::from_u128(u128::from(number / POINTS))), "thermal_photo".to_owned());
                let (blob, body) = (Some([7; 32]), body.to_string());
                let record =
                    ResultRecord { run, step: (number % POINTS) as u32, attempt: 1, kind, blob, body };
                let at = Stamp::from_nanos(1_800_000_000_000_000_000 + number as i64 * 300_000_000_000);
                writer.put_event(&LedgerEvent::Result(record), at)?;
            }
            Ok(())
        });
        written.expect("written");
    }
}

/// Reads the whole history of a point in pages. Returns the number of its results, and the longest time of a page, ms.
fn read_history(ledger: &Ledger, of: InspectionPointId) -> (usize, f64) {
    let (mut before, mut count, mut longest_ms) = (None, 0, 0.0_f64);
    loop {
        let began = Instant::now();
        let page = ledger.point_results(of, before, 100).expect("read");
        longest_ms = longest_ms.max(began.elapsed().as_secs_f64() * 1e3);
        assert!(page.windows(2).all(|pair| pair[0].number > pair[1].number), "the newest first");
        assert!(page.iter().all(|result| result.body.contains(&of.to_string())));
        let Some(last) = page.last() else { return (count, longest_ms) };
        assert!(before.is_none_or(|before| page[0].number < before), "no result twice");
        (before, count) = (Some(last.number), count + page.len());
    }
}

#[test]
fn a_history_is_read_in_pages() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let (mut ledger, _) = store.open_ledger().expect("opens");
    write(&mut ledger, 5_000);
    assert_eq!(read_history(&ledger, point(3)).0, 250);
    assert_eq!(read_history(&ledger, InspectionPointId(Uuid::nil())).0, 0);
}

mod nightly {
    use super::*;

    /// The times are for docs; the machine is shared, so none is asserted.
    #[test]
    fn the_history_of_a_point_among_100_000_results_is_read_whole() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Store::open(dir.path()).expect("opens");
        let (mut ledger, _) = store.open_ledger().expect("opens");
        write(&mut ledger, 100_000);
        let began = Instant::now();
        let (count, longest_ms) = read_history(&ledger, point(3));
        let all_ms = began.elapsed().as_secs_f64() * 1e3;
        println!("100,000 results: 5,000 of one point in {all_ms:.0} ms, longest page {longest_ms:.2} ms");
        assert_eq!(count, 5_000);
    }
}
