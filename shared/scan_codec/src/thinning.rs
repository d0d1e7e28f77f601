//! Leaves columns out of a sweep.

use messages::Scan;

/// Keeps every `step`th column of a sweep, beginning with column `phase`, so that `step` successive sweeps with successive phases hold all columns. A new column
/// begins with a channel that is not above the previous one; without channels every point is a column.
pub fn thin(scan: &mut Scan, step: usize, phase: usize) {
    let step = step.max(1);
    let is_full = |length: usize| length == 0 || length == scan.xyz.len();
    if step == 1
        || !is_full(scan.intensity.len())
        || !is_full(scan.offset_ns.len())
        || !is_full(scan.ring.len())
    {
        return;
    }
    let mut column = 0;
    let keeps: Vec<bool> = (0..scan.xyz.len())
        .map(|index| {
            let begins = index > 0 && scan.ring.get(index).is_none_or(|ring| *ring <= scan.ring[index - 1]);
            column += usize::from(begins);
            column % step == phase % step
        })
        .collect();
    retain(&mut scan.xyz, &keeps);
    retain(&mut scan.intensity, &keeps);
    retain(&mut scan.offset_ns, &keeps);
    retain(&mut scan.ring, &keeps);
}

/// Keeps the marked elements; the capacity shrinks too, because sweeps wait in queues.
fn retain<T: Copy>(column: &mut Vec<T>, keeps: &[bool]) {
    *column = column.iter().zip(keeps).filter(|(_, keeps)| **keeps).map(|(value, _)| *value).collect();
}
