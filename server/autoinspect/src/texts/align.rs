//! Errors of `autoinspect align` and `autoinspect merge`: maps that do not fit into each other.

use mapping::AlignmentError;
use std::path::Path;

/// A cloud in which too few scans of the map were recognised.
pub fn too_few_scans_recognised(map: &Path, recognised: usize) -> String {
    format!(
        "only {recognised} places of {} were recognised in the cloud; align it by points picked in both (--pair)",
        map.display()
    )
}

/// A cloud whose alignment is ambiguous.
pub fn ambiguous_alignment(map: &Path, recognised: usize, other: usize) -> String {
    format!(
        "the cloud fits into {} in two ways, with {recognised} and {other} places recognised; align it by points picked in both (--pair)",
        map.display()
    )
}

/// Point pairs that do not determine an alignment.
pub const TOO_FEW_PAIRS: &str = "two --pair or more are needed, of points that are not above each other";

/// Point pairs with an impossible result.
pub fn pairs_too_far(distance_km: f64) -> String {
    format!("the pairs place the cloud farther away than {distance_km:.0} km; check their coordinates")
}

/// Point pairs that no alignment fits.
pub fn pairs_contradict(rms_m: f64) -> String {
    format!(
        "the pairs contradict each other: after the best alignment they are {rms_m:.2} m apart in the mean; check their order, and --up"
    )
}

/// A point pair that cannot be parsed.
pub const INVALID_PAIR: &str =
    "a point and the same one in the other map are expected, like 12,3.5,0=1.2,4,0";

/// Two maps that cannot be merged.
pub fn alignment_error(error: &AlignmentError, map: &Path, first: &Path) -> String {
    let (map, first) = (map.display(), first.display());
    match error {
        AlignmentError::TooFew(0) => {
            format!("nothing of {map} was recognised in {first}; are they of the same site?")
        }
        AlignmentError::TooFew(count) => format!(
            "only {count} places of {map} were recognised in {first}, or all in one spot; walk some 15 m of the known part on the next round"
        ),
        AlignmentError::Ambiguous(count, runner_up) => format!(
            "{map} fits into {first} in two ways, with {count} and {runner_up} places recognised; walk a part on which they differ"
        ),
    }
}

/// Names of the two maps of an alignment in its errors.
pub const ALIGNED_MAP: &str = "the map";

pub const OTHER_MAP: &str = "the other map";
