//! Limits on what one client may use. Every queue, buffer and wait of this crate has its bound here.

use std::time::{Duration, Instant};

/// Bounds on clients. The defaults suit a robot on a site network; tests shorten the waits.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// TCP connections at a time, WebSockets included. Further ones take a reserved place. Chosen: 64 clients with two sockets and some downloads each, twice.
    pub connections: usize,
    /// Connections beyond those, over which somebody may sign in, ask who is signed in, or stop motion, with one request each. Chosen: under a flood of 4,000 connections a
    /// second from many addresses each has 64 ms for its request.
    pub reserved_connections: usize,
    /// Control sockets at a time; the same number applies to stream sockets. Further ones are refused with a sentence. Chosen: more people than look at one robot.
    pub clients: usize,
    /// TCP connections at a time from one address, so that one computer does not take all. Chosen: half, because a site may be behind one address.
    pub connections_of_address: usize,
    /// Control sockets at a time of one account, so that one account does not take all. Chosen: more than the windows of one person, and less than half of
    /// [`Self::clients`].
    pub clients_of_account: usize,
    /// Time limit for the head of a request, and for an idle connection. Chosen: a browser sends it at once; slow links take seconds.
    pub header_timeout: Duration,
    /// Time without a message after which a WebSocket is closed. Chosen: clients send a ping more often than that.
    pub silence: Duration,
    /// Time without progress of a write after which a connection is closed. Chosen: as [`Self::silence`].
    pub write_stall: Duration,
    /// Bytes that all uploaded files may take together: two of the longest.
    pub uploads_bytes: u64,
    /// Mean rate of commands from one socket; a burst may hold twice as many. Stop motion is counted apart. Chosen: driving by hand is 10 a second, and the rest is for
    /// drags and repeats.
    pub commands_per_second: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: 512,
            reserved_connections: 256,
            clients: 64,
            connections_of_address: 256,
            clients_of_account: 24,
            header_timeout: Duration::from_secs(10),
            silence: Duration::from_secs(10),
            write_stall: Duration::from_secs(10),
            uploads_bytes: 2 * FIXED.max_upload_bytes,
            commands_per_second: 50.0,
        }
    }
}

/// Bounds that neither a site nor a test changes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FixedLimits {
    /// Age up to which a scan is live. LiDARs scan 2 to 20 times a second. Chosen: two of the slowest.
    pub(crate) max_live_scan_age: Duration,
    /// Memory of each WebSocket for bytes that it has read, and for bytes that it has not written yet. Longer messages take more while they are there. Chosen: 4 MB for
    /// all sockets at most, and large enough for common messages.
    pub(crate) socket_buffer_bytes: usize,
    /// Longest message on a control socket, bytes: the longest edit of the site. Chosen: 16 kB more for what is around it.
    pub(crate) max_client_message_bytes: usize,
    /// Longest message from a client on a stream socket, bytes. Chosen: the longest regular one is far shorter.
    pub(crate) max_stream_request_bytes: usize,
    /// Control sockets of which the first message is read at a time. It may be as long as any, and who sends it is not counted as a client yet. Chosen: 64 MB of memory
    /// at most.
    pub(crate) max_greetings_at_a_time: usize,
    /// Longest head of a request, bytes. Chosen: cookies of a browser fit.
    pub(crate) max_request_head_bytes: usize,
    /// Header fields in a request. Chosen: browsers send some twenty.
    pub(crate) max_request_headers: usize,
    /// Bytes that the kernel holds unsent for a client. The rest waits in this process, where newer state replaces older. Chosen: 0.13 s at 1 Mbit/s.
    pub(crate) max_unsent_bytes: u32,
    /// Answers and pongs that wait for one client. Chosen: as [`Self::max_pending_commands`].
    pub(crate) max_answers: usize,
    /// Commands of one client that the core has not answered. Chosen: 5 s of the greatest rate ([`Limits::commands_per_second`]).
    pub(crate) max_pending_commands: usize,
    /// Commands of all clients in the queue to the core. Chosen: the core takes them every 50 ms.
    pub(crate) max_queued_commands: usize,
    /// Stops of motion of all clients in their own queue to the core. One that waits has the effect of all. Chosen: one of each client.
    pub(crate) max_queued_stops: usize,
    /// Changes of the graph kept for clients that read slowly. A client further behind gets the whole graph. Chosen: some minutes of mapping.
    pub(crate) max_graph_changes: usize,
    /// Changes of the site kept for clients that read slowly. A client further behind gets the whole site. Chosen: some minutes of editing by several people.
    pub(crate) max_site_changes: usize,
    /// Bytes that they may take. Chosen: two of the longest edits.
    pub(crate) max_site_change_bytes: usize,
    /// Edits of one client that the core has not answered. Chosen: two transactions of the ledger.
    pub(crate) max_pending_edits: usize,
    /// Edits longer than this count as large, bytes. Chosen: edits by hand are shorter; programs that write whole maps are longer.
    pub(crate) large_edit_bytes: usize,
    /// Large edits of all clients that the core has not answered. Chosen: 16 MB of memory at most.
    pub(crate) max_large_edits: usize,
    /// Longest JSON document of an object of the site, bytes. Chosen: a mission of hundreds of tasks fits.
    pub(crate) max_object_json_bytes: usize,
    /// Longest JSON document of an edit of the site, bytes. Chosen: four times the binary form, because JSON is longer.
    pub(crate) max_edit_json_bytes: usize,
    /// Longest document of an edit that counts as short, bytes. Chosen: edits by hand and of small programs are shorter.
    pub(crate) max_short_edit_bytes: u64,
    /// Short edits over HTTP that are read at a time. Chosen: 8 MB of memory at most.
    pub(crate) max_short_edits_at_a_time: usize,
    /// Those of one account. Chosen: eight accounts that send slowly do not take all.
    pub(crate) max_short_edits_of_account: usize,
    /// Long edits over HTTP that are read at a time, one of an account. One takes three times its length while it is parsed. Chosen: so that an account that sends slowly leaves
    /// a place to another; 64 MB of memory at most.
    pub(crate) max_long_edits_at_a_time: usize,
    /// Values in the document of an edit, with 32 bytes and more for each once it is parsed. An edit of 4 MB has 500,000 numbers at most. Chosen: a fifth more.
    pub(crate) max_edit_values: usize,
    /// Longest time for the document of an edit: 16 MB at 4 Mbit/s. Chosen: slower links send edits in parts.
    pub(crate) max_edit_read_time: Duration,
    /// Least time between two whole graphs or sites that one client asks for. A client needs one after lost changes, which is rare; 5,000 keyframes are 0.5 MB. Chosen:
    /// 0.1 MB a second at most then.
    pub(crate) graph_answer_period: Duration,
    /// Decisions on loops in one event: about 40 kB. Chosen: a message that a slow link sends within a tenth of a second.
    pub(crate) max_loops_per_event: usize,
    /// Longest file from a client, bytes: about 400 million points. Chosen: larger than surveys that are exchanged as one file.
    pub(crate) max_upload_bytes: u64,
    /// Files that may wait to be imported. Chosen: they take space on the robot's disk.
    pub(crate) max_uploads_kept: usize,
    /// Bytes of an upload between two checks of the space on the disk. Chosen: far less than the space that is left free.
    pub(crate) space_check_bytes: u64,
    /// Longest JSON document from a client, bytes. The longest regular one holds a name. Chosen: far above that.
    pub(crate) max_json_bytes: usize,
    /// Entries of one page of a list over HTTP: a few hundred kB.
    pub(crate) max_page_entries: usize,
    /// Commands over HTTP that wait for the core's answer. Chosen: half of the sockets' clients.
    pub(crate) max_http_commands: usize,
    /// Longest wait for the core's answer to a command over HTTP. The disk lane may be saving a large map. Chosen: longer than that takes.
    pub(crate) max_answer_wait: Duration,
    /// Requests about accounts that wait for the core's answer. Those that hash passwords wait for each other there. Chosen: as the core's own queue.
    pub(crate) max_account_requests: usize,
    /// Time between two reports of used sessions to the core. Chosen: shorter than the minutes in which the ledger notes them.
    pub(crate) use_report_period: Duration,
    /// Time between two reports of refusals to the core. Chosen: people who look at the audit log do not notice it.
    pub(crate) journal_report_period: Duration,
    /// Uploads at a time. Chosen: the disk is shared with recordings.
    pub(crate) max_uploads_at_a_time: usize,
    /// Runs that are downloaded at a time. Chosen: for the same reason.
    pub(crate) max_downloads_at_a_time: usize,
    /// Chunks of a downloaded run that wait for the client, each of [`Self::file_chunk_bytes`] at most. Chosen: the disk goes on reading while the client takes one.
    pub(crate) max_download_chunks: usize,
    /// Longest time for which a client that downloads a run reads nothing. Chosen: longer than a radio link is out.
    pub(crate) max_download_stall: Duration,
    /// Longest time that open connections have to end when the gateway stops. Chosen: less than the 30 s that the supervisor waits.
    pub(crate) shutdown_timeout: Duration,
    /// Time between two heartbeats. Chosen: a tenth of the silence after which the supervisor ends the process.
    pub(crate) beat_period: Duration,
    /// Time of silence after which a peer is asked whether it is there, and time for which sent bytes may stay without an acknowledgement before the connection ends.
    /// Chosen: longer than common outages of a radio link.
    pub(crate) peer_timeout: Duration,
    /// Pause after the system could not create another socket, so that others can be closed meanwhile. Chosen: nobody notices it.
    pub(crate) accept_pause: Duration,
    /// Longest time that a closing connection is kept open so that the peer can read the reason. Chosen: longer than a common way there and back.
    pub(crate) close_timeout: Duration,
    /// Longest time for which the clock is extrapolated without a new stamp. After that the robot is silent, and its clock stands. Chosen: forty ticks of the core.
    pub(crate) max_clock_extrapolation: Duration,
    /// Bytes read from the disk at a time, which a connection that does not read keeps in memory about twice. Chosen: 25 MB for all connections.
    pub(crate) file_chunk_bytes: usize,
}

/// The bounds in force.
pub(crate) const FIXED: FixedLimits = FixedLimits {
    max_live_scan_age: Duration::from_secs(1),
    socket_buffer_bytes: 16 << 10,
    max_client_message_bytes: api::MAX_EDIT_BYTES + (16 << 10),
    max_stream_request_bytes: 16 << 10,
    max_greetings_at_a_time: 16,
    max_request_head_bytes: 32 << 10,
    max_request_headers: 64,
    max_unsent_bytes: 16 << 10,
    max_answers: 256,
    max_pending_commands: 256,
    max_queued_commands: 256,
    max_queued_stops: 64,
    max_graph_changes: 256,
    max_site_changes: 1_024,
    max_site_change_bytes: 8 << 20,
    max_pending_edits: 128,
    large_edit_bytes: 64 << 10,
    max_large_edits: 4,
    max_object_json_bytes: 1 << 20,
    max_edit_json_bytes: 16 << 20,
    max_short_edit_bytes: 256 << 10,
    max_short_edits_at_a_time: 32,
    max_short_edits_of_account: 4,
    max_long_edits_at_a_time: 2,
    max_edit_values: 600_000,
    max_edit_read_time: Duration::from_secs(30),
    graph_answer_period: Duration::from_secs(5),
    max_loops_per_event: 100,
    max_upload_bytes: 16 << 30,
    max_uploads_kept: 4,
    space_check_bytes: 64 << 20,
    max_json_bytes: 16 << 10,
    max_page_entries: 1_000,
    max_http_commands: 32,
    max_answer_wait: Duration::from_secs(120),
    max_account_requests: 64,
    use_report_period: Duration::from_secs(20),
    journal_report_period: Duration::from_secs(1),
    max_uploads_at_a_time: 1,
    max_downloads_at_a_time: 4,
    max_download_chunks: 4,
    max_download_stall: Duration::from_secs(60),
    shutdown_timeout: Duration::from_secs(3),
    beat_period: Duration::from_millis(500),
    peer_timeout: Duration::from_secs(30),
    accept_pause: Duration::from_millis(50),
    close_timeout: Duration::from_secs(2),
    max_clock_extrapolation: Duration::from_secs(2),
    file_chunk_bytes: 16 << 10,
};

/// A token bucket.
pub(crate) struct RateLimit {
    per_second: f64,
    tokens: f64,
    filled: Instant,
}

impl RateLimit {
    /// Allows `per_second` in the mean and twice as many in a burst.
    pub(crate) fn new(per_second: f64, now: Instant) -> Self {
        Self { per_second, tokens: 2.0 * per_second, filled: now }
    }

    /// Takes one token, if there is one.
    pub(crate) fn allow(&mut self, now: Instant) -> bool {
        let elapsed = now.saturating_duration_since(self.filled).as_secs_f64();
        self.filled = now;
        self.tokens = (self.tokens + elapsed * self.per_second).min(2.0 * self.per_second);
        let allowed = self.tokens >= 1.0;
        if allowed {
            self.tokens -= 1.0;
        }
        allowed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_then_the_mean_rate() {
        let start = Instant::now();
        let mut limit = RateLimit::new(50.0, start);
        assert_eq!((0..1000).filter(|_| limit.allow(start)).count(), 100);
        let later = start + Duration::from_secs(1);
        assert_eq!((0..1000).filter(|_| limit.allow(later)).count(), 50);
        let much_later = start + Duration::from_secs(3600);
        assert_eq!((0..1000).filter(|_| limit.allow(much_later)).count(), 100);
    }
}
