//! A certificate authority of this robot's own. It is made on the first start, and people tell their browsers once to trust it. It certifies this computer under each name
//! by which a client asks for it.

use super::TlsError;
use rcgen::{
    BasicConstraints, CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer,
    KeyPair, KeyUsagePurpose,
};
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};
use tokio_rustls::rustls::crypto::ring::sign::any_supported_type;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, PrivatePkcs8KeyDer};
use tokio_rustls::rustls::sign::CertifiedKey;

/// For how long the authority is valid, days: as long as the robot serves, since replacing it means telling all browsers again.
const AUTHORITY_DAYS: u64 = 3_650;
/// For how long a certificate is valid, days. Browsers accept 398 at most.
const CERTIFICATE_DAYS: u64 = 90;
/// Time after which a certificate is made anew, while the program runs.
const RENEWAL_PERIOD: Duration = Duration::from_secs(30 * 24 * 3_600);
/// Names that are kept. Only names of this server are certified, so they are few.
const MAX_NAMES: usize = 64;

/// The authority.
pub(crate) struct Authority {
    issuer: Issuer<'static, KeyPair>,
    certificate: CertificateDer<'static>,
    pem: String,
    certified: Mutex<BTreeMap<String, (Instant, Arc<CertifiedKey>)>>,
}

impl Authority {
    /// Reads the authority of this folder, or makes one. Only the user of the service can read its key.
    ///
    /// # Errors
    /// When a file cannot be read or written.
    pub(crate) fn open(folder: &Path) -> Result<Self, TlsError> {
        let (certificate, key) = (folder.join("authority.pem"), folder.join("authority-key.pem"));
        let failed = |path: &Path, reason: String| TlsError::File { path: path.to_owned(), reason };
        let io_failed = |path: &Path, error: std::io::Error| failed(path, error.to_string());
        if !certificate.exists() || !key.exists() {
            fs::create_dir_all(folder).map_err(|error| io_failed(folder, error))?;
            let (made, made_key) = make().map_err(|error| TlsError::Make(error.to_string()))?;
            write(&key, &made_key, 0o600).map_err(|error| io_failed(&key, error))?;
            write(&certificate, &made, 0o644).map_err(|error| io_failed(&certificate, error))?;
        }
        let read = |path: &Path| fs::read_to_string(path).map_err(|error| io_failed(path, error));
        let pem = read(&certificate)?;
        let key_pair = KeyPair::from_pem(&read(&key)?).map_err(|error| failed(&key, error.to_string()))?;
        let der = CertificateDer::from_pem_slice(pem.as_bytes())
            .map_err(|error| failed(&certificate, error.to_string()))?;
        let issuer = Issuer::from_ca_cert_der(&der, key_pair)
            .map_err(|error| failed(&certificate, error.to_string()))?;
        Ok(Self { issuer, certificate: der, pem, certified: Mutex::default() })
    }

    /// Its certificate in PEM format, which people tell their browsers to trust.
    pub(crate) fn certificate_pem(&self) -> &str {
        &self.pem
    }

    /// A certificate of this computer under a name or an address.
    ///
    /// # Errors
    /// When it cannot be made.
    pub(crate) fn certified(&self, name: &str) -> Result<Arc<CertifiedKey>, TlsError> {
        let name = name.to_ascii_lowercase();
        let mut certified = self.certified.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((made, key)) = certified.get(&name)
            && made.elapsed() < RENEWAL_PERIOD
        {
            return Ok(Arc::clone(key));
        }
        let made = self.certify(&name).map_err(|error| TlsError::Make(error.to_string()))?;
        let key = any_supported_type(&made.1).map_err(|error| TlsError::Make(error.to_string()))?;
        let key = Arc::new(CertifiedKey::new(vec![made.0, self.certificate.clone()], key));
        if certified.len() >= MAX_NAMES {
            certified.clear();
        }
        certified.insert(name, (Instant::now(), Arc::clone(&key)));
        Ok(key)
    }

    fn certify(&self, name: &str) -> Result<(CertificateDer<'static>, PrivateKeyDer<'static>), rcgen::Error> {
        let mut params = CertificateParams::new(vec![name.to_owned()])?;
        params.distinguished_name = named("AutoInspect robot");
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth];
        (params.not_before, params.not_after) = validity(CERTIFICATE_DAYS);
        let key = KeyPair::generate()?;
        let certificate = params.signed_by(&key, &self.issuer)?;
        let key = PrivateKeyDer::Pkcs8(PrivatePkcs8KeyDer::from(key.serialize_der()));
        Ok((certificate.der().clone(), key))
    }
}

/// A new authority and its key, in PEM format.
fn make() -> Result<(String, String), rcgen::Error> {
    let mut params = CertificateParams::default();
    params.distinguished_name = named("AutoInspect authority of this robot");
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    (params.not_before, params.not_after) = validity(AUTHORITY_DAYS);
    let key = KeyPair::generate()?;
    Ok((params.self_signed(&key)?.pem(), key.serialize_pem()))
}

fn named(name: &str) -> DistinguishedName {
    let mut distinguished = DistinguishedName::new();
    distinguished.push(DnType::CommonName, name);
    distinguished
}

/// From yesterday, because the clocks of clients differ, for this number of days.
fn validity(days: u64) -> (time::OffsetDateTime, time::OffsetDateTime) {
    let day = Duration::from_secs(24 * 3_600);
    let now = SystemTime::now();
    ((now - day).into(), (now + day * days as u32).into())
}

fn write(path: &Path, content: &str, mode: u32) -> std::io::Result<()> {
    let mut file = fs::OpenOptions::new().write(true).create(true).truncate(true).mode(mode).open(path)?;
    file.write_all(content.as_bytes())?;
    file.sync_all()
}
