//! Encryption of connections by rustls: with a certificate of one's own authority ([`Authority`]), or with files that are read again when they change.

mod authority;
mod files;

pub(crate) use authority::Authority;

use crate::access::{Connection, HostList};
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

/// Why connections cannot be encrypted.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    /// A file cannot be read or written.
    #[error("{path} cannot be used for TLS: {reason}")]
    File {
        /// Which.
        path: PathBuf,
        /// Why, a clause.
        reason: String,
    },
    /// A certificate cannot be made.
    #[error("no certificate could be made: {0}")]
    Make(String),
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

    /// The certificate of the authority that people have to trust, in PEM format, if it is one of our own.
    pub(crate) fn authority(&self) -> Option<&str> {
        match self {
            Self::Own(authority) => Some(authority.certificate_pem()),
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
        connection: &Connection,
        hosts: &HostList,
    ) -> io::Result<TlsStream<Io>> {
        let start = LazyConfigAcceptor::new(Acceptor::default(), io).await?;
        let hello = start.client_hello();
        let certified = match self {
            Self::Files(files) => files.current(),
            Self::Own(authority) => {
                // A client that knows only the address of this computer names none.
                let name = hello.server_name().map(str::to_owned);
                let name = name.unwrap_or_else(|| connection.local.to_canonical().to_string());
                if !hosts.allows(&name, connection.local) {
                    return Err(io::Error::new(io::ErrorKind::InvalidData, "the client asks for another server"));
                }
                authority.certified(&name).map_err(io::Error::other)?
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
