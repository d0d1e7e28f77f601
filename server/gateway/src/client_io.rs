//! A client's TCP connection: options that keep it fresh, and an end to it when the client stops reading.

use crate::address_places::AddressPlace;
use crate::limits::FIXED;
use crate::reserved_places::{ReservedPlace, ReservedPlaceId};
use socket2::{SockRef, TcpKeepalive};
use std::future::Future;
use std::io;
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::sync::OwnedSemaphorePermit;
use tokio::time::Sleep;

/// A connection's place among all. It is given back when it is dropped.
#[derive(Debug)]
pub(crate) enum ConnectionPlace {
    /// One of the server's and one of the address's.
    Ordinary { _of_server: OwnedSemaphorePermit, _of_address: AddressPlace },
    /// One of those for when all others are taken.
    Reserved(ReservedPlace),
}

impl ConnectionPlace {
    /// Its name, if it is reserved.
    pub(crate) fn reserved(&self) -> Option<ReservedPlaceId> {
        match self {
            Self::Ordinary { .. } => None,
            Self::Reserved(place) => Some(place.id()),
        }
    }
}

/// A connection that fails when its peer takes nothing for too long, and holds its place among the connections.
pub(crate) struct ClientIo {
    stream: TcpStream,
    stall_limit: Duration,
    /// Runs while a write waits.
    stall: Option<Pin<Box<Sleep>>>,
    _place: ConnectionPlace,
}

impl ClientIo {
    /// Wraps an accepted connection.
    pub(crate) fn new(stream: TcpStream, stall_limit: Duration, place: ConnectionPlace) -> Self {
        if let Err(error) = keep_fresh(&stream) {
            tracing::debug!(%error, "a socket refused an option");
        }
        Self { stream, stall_limit, stall: None, _place: place }
    }

    /// Whether the client speaks TLS: its first byte is that of a handshake (RFC 8446, 5.1). Waits for the byte and leaves it there.
    ///
    /// # Errors
    /// When the connection fails.
    pub(crate) async fn begins_with_tls(&self) -> io::Result<bool> {
        const HANDSHAKE: u8 = 22;
        let mut first = [0];
        Ok(self.stream.peek(&mut first).await? == 1 && first == [HANDSHAKE])
    }

    fn guard<T>(&mut self, context: &mut Context<'_>, polled: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if polled.is_ready() {
            self.stall = None;
            return polled;
        }
        let limit = self.stall_limit;
        let stall = self.stall.get_or_insert_with(|| Box::pin(tokio::time::sleep(limit)));
        ready!(stall.as_mut().poll(context));
        Poll::Ready(Err(io::ErrorKind::TimedOut.into()))
    }
}

/// Small messages leave at once; the kernel queues next to nothing, so that what waits is still replaceable; and a peer
/// that vanished without a word is noticed.
fn keep_fresh(stream: &TcpStream) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let socket = SockRef::from(stream);
    socket.set_tcp_keepalive(&TcpKeepalive::new().with_time(FIXED.peer_timeout))?;
    #[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
    socket.set_tcp_notsent_lowat(FIXED.max_unsent_bytes)?;
    #[cfg(any(target_os = "linux", target_os = "android"))]
    socket.set_tcp_user_timeout(Some(FIXED.peer_timeout))?;
    Ok(())
}

impl AsyncRead for ClientIo {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, buffer)
    }
}

impl AsyncWrite for ClientIo {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let polled = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.guard(context, polled)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let polled = Pin::new(&mut self.stream).poll_write_vectored(context, parts);
        self.guard(context, polled)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::address_places::AddressPlaces;
    use std::sync::Arc;
    use tokio::io::AsyncWriteExt;
    use tokio::net::TcpListener;
    use tokio::sync::Semaphore;

    /// Both ends of a connection, ours wrapped.
    async fn pair(stall_limit: Duration, places: &Arc<Semaphore>) -> (ClientIo, TcpStream) {
        let listener = TcpListener::bind("127.0.0.1:0").await.expect("a listener");
        let theirs =
            TcpStream::connect(listener.local_addr().expect("an address")).await.expect("a connection");
        let (ours, _) = listener.accept().await.expect("accepted");
        let _of_server = places.clone().try_acquire_owned().expect("a place");
        let _of_address = AddressPlaces::new(1).claim([127, 0, 0, 1].into()).expect("a place");
        let place = ConnectionPlace::Ordinary { _of_server, _of_address };
        (ClientIo::new(ours, stall_limit, place), theirs)
    }

    #[tokio::test]
    async fn options_are_set_and_the_place_is_given_back() {
        let places = Arc::new(Semaphore::new(1));
        let (ours, _theirs) = pair(Duration::from_secs(1), &places).await;
        assert!(ours.stream.nodelay().expect("an option"));
        #[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
        assert_eq!(
            SockRef::from(&ours.stream).tcp_notsent_lowat().expect("an option"),
            FIXED.max_unsent_bytes
        );
        assert_eq!(places.available_permits(), 0);
        drop(ours);
        assert_eq!(places.available_permits(), 1);
    }

    #[tokio::test]
    async fn a_write_that_nobody_takes_fails_and_little_was_queued() {
        let places = Arc::new(Semaphore::new(1));
        let (mut ours, theirs) = pair(Duration::from_millis(100), &places).await;
        let mut written = 0;
        let error = loop {
            match ours.write(&[0; 4096]).await {
                Ok(bytes) => written += bytes,
                Err(error) => break error,
            }
        };
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
        assert!(written < 16 << 20, "{written} bytes were taken by the kernel");
        drop(theirs);
    }
}
