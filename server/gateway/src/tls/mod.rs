//! Encryption of connections by rustls: with a certificate of one's own authority ([`Authority`]), or with files that are read again when they change.

mod authority;
mod error;
mod files;
pub(crate) mod trust;

pub(crate) use authority::Authority;
pub use error::TlsError;

use crate::access::{HostList, TcpConnection};
use files::CertificateFiles;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio_rustls::LazyConfigAcceptor;
use tokio_rustls::rustls::server::Acceptor;
use tokio_rustls::rustls::sign::CertifiedKey;
use tokio_rustls::rustls::{self, ServerConfig};
use tokio_rustls::server::TlsStream;

/// How connections are encrypted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum TlsConfig {
    /// Not at all.
    #[default]
    None,
    /// With certificates of an authority of its own, which is made in this folder if it is not there.
    Own(PathBuf),
    /// With these files in PEM format, which are read again when they change.
    Files {
        /// The certificate, followed by those of its authorities.
        certificates: PathBuf,
        /// Its key.
        key: PathBuf,
    },
}

/// Encrypts connections.
pub(crate) enum Encryption {
    /// With a certificate for the name under which each client knows this computer.
    Own(Authority),
    /// With one certificate.
    Files(CertificateFiles),
}

impl Encryption {
    /// None: connections are not encrypted.
    ///
    /// # Errors
    /// When a file cannot be used.
    pub(crate) fn new(config: &TlsConfig) -> Result<Option<Self>, TlsError> {
        Ok(match config {
            TlsConfig::None => None,
            TlsConfig::Own(folder) => Some(Self::Own(Authority::open(folder)?)),
            TlsConfig::Files { certificates, key } => {
                Some(Self::Files(CertificateFiles::open(certificates.clone(), key.clone())?))
            }
        })
    }

    /// The authority that people have to trust, if it is one of our own.
    pub(crate) fn authority(&self) -> Option<&Authority> {
        match self {
            Self::Own(authority) => Some(authority),
            Self::Files(_) => None,
        }
    }

    /// Encrypts a connection.
    ///
    /// # Errors
    /// When the client does not speak TLS, or asks for a name that is not of this server.
    pub(crate) async fn accept<Io: AsyncRead + AsyncWrite + Unpin>(
        &self,
        io: Io,
        connection: &TcpConnection,
        hosts: &HostList,
    ) -> io::Result<TlsStream<Io>> {
        let start = LazyConfigAcceptor::new(Acceptor::default(), io).await?;
        let hello = start.client_hello();
        let certified = match self {
            Self::Files(files) => files.current(),
            Self::Own(authority) => {
                let names = match hello.server_name() {
                    Some(name) if hosts.allows(name, connection.local) => vec![name.to_owned()],
                    Some(_) => {
                        let reason = "the client asks for another server";
                        return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
                    }
                    // A client that knows this computer by an address names none.
                    None => hosts.addresses(connection.local),
                };
                authority.certified(&names).map_err(io::Error::other)?
            }
        };
        start.into_stream(server_config(certified)?).await
    }
}

/// TLS 1.2 and 1.3 with one certificate.
fn server_config(certified: Arc<CertifiedKey>) -> io::Result<Arc<ServerConfig>> {
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let builder = ServerConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .map_err(io::Error::other)?;
    let mut config = builder.with_no_client_auth().with_cert_resolver(Arc::new(Fixed(certified)));
    config.alpn_protocols = vec![b"http/1.1".to_vec()];
    Ok(Arc::new(config))
}

/// One certificate for all clients of a configuration.
#[derive(Debug)]
struct Fixed(Arc<CertifiedKey>);

impl rustls::server::ResolvesServerCert for Fixed {
    fn resolve(&self, _hello: rustls::server::ClientHello<'_>) -> Option<Arc<CertifiedKey>> {
        Some(Arc::clone(&self.0))
    }
}
