//! The table that is printed.

/// One program on one walk.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Site of the walk.
    pub site: String,
    /// Seed of the walk.
    pub seed: u64,
    /// Name of the program or variant.
    pub who: String,
    /// Scans processed.
    pub scans: u64,
    /// Length of the walk, metres.
    pub path: f64,
    /// Absolute trajectory error after rigid alignment, metres RMSE; `None` when it failed.
    pub error: Option<f64>,
    /// Greatest vertical error after alignment, metres, where known.
    pub vertical: Option<f64>,
    /// Mean CPU time per scan, milliseconds.
    pub cpu_ms: f64,
    /// 99th percentile of the time per scan, milliseconds.
    pub p99_ms: f64,
    /// Peak resident memory, MB.
    pub peak_mb: f64,
    /// Error message, or empty.
    pub note: String,
}

/// Time between sweeps of the simulated LiDAR, milliseconds.
const SWEEP_MS: f64 = 100.0;

/// Prints the names of the columns. `x real` is the duration of a sweep divided by its CPU time.
#[allow(clippy::print_stdout, reason = "the table is this program's output")]
pub fn print_header() {
    println!(
        "{:<8}{:>5}  {:<18}{:>7}{:>9}{:>10}{:>10}{:>10}{:>9}{:>9}{:>8}{:>9}",
        "site",
        "seed",
        "odometry",
        "scans",
        "path m",
        "error m",
        "drift %",
        "height m",
        "cpu ms",
        "p99 ms",
        "x real",
        "MB"
    );
}

/// Prints one row.
#[allow(clippy::print_stdout, reason = "the table is this program's output")]
pub fn print(row: &Row) {
    let metres = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| format!("{v:.4}"));
    let drift = row
        .error
        .filter(|_| row.path > 0.0)
        .map_or_else(|| "-".to_owned(), |e| format!("{:.3}", 100.0 * e / row.path));
    let times_real = if row.cpu_ms > 0.0 { format!("{:.1}", SWEEP_MS / row.cpu_ms) } else { "-".to_owned() };
    println!(
        "{:<8}{:>5}  {:<18}{:>7}{:>9.1}{:>10}{:>10}{:>10}{:>9.2}{:>9.2}{:>8}{:>9.0}  {}",
        row.site,
        row.seed,
        row.who,
        row.scans,
        row.path,
        metres(row.error),
        drift,
        metres(row.vertical),
        row.cpu_ms,
        row.p99_ms,
        times_real,
        row.peak_mb,
        row.note
    );
}
