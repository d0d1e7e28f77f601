//! The example of the guide, which another program made.

use crate::read_site;
use std::path::Path;

#[test]
fn the_workshop_of_the_guide_is_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide/examples");
    let site = read_site(&folder.join("workshop.glb")).unwrap();
    let start = site.start();
    assert_eq!((start.position.x, start.position.y), (1.5, 4.2), "the dock of the sidecar");
    let round = site.route("round").unwrap();
    assert_eq!((round.waypoints.len(), round.speed), (13, 0.8));
    let (least, most) = site.solids().iter().map(|solid| solid.shape.bounds()).fold(
        ([f64::MAX; 3], [f64::MIN; 3]),
        |(least, most), (low, high)| {
            (
                [0, 1, 2].map(|axis| least[axis].min(low[axis])),
                [0, 1, 2].map(|axis| most[axis].max(high[axis])),
            )
        },
    );
    assert!((most[0] - least[0] - 16.6).abs() < 1e-3 && (most[2] - 3.2).abs() < 1e-3, "{least:?} {most:?}");
}
