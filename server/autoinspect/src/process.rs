//! CPU time of this process's threads, and its memory.

use rustix::time::{ClockId, clock_gettime};
use std::fs;
use std::time::Duration;

/// CPU time of the calling thread so far.
pub fn thread_cpu_time() -> Duration {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(now.tv_sec.unsigned_abs(), now.tv_nsec.unsigned_abs() as u32)
}

/// Peak resident memory since the last call of [`reset_peak_memory`], bytes; zero if the system does not report it.
pub fn peak_memory() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes = peak.and_then(|text| text.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok());
    kibibytes.unwrap_or(0) * 1024
}

/// Resets the peak. If the system does not allow it, peaks count from the start of the process.
pub fn reset_peak_memory() {
    // 5 resets the peak resident set size; see proc(5), "clear_refs".
    let _ = fs::write("/proc/self/clear_refs", "5");
}
