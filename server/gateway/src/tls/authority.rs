//! A certificate authority of this robot's own. It is made on the first start, and people tell their browsers once to trust it. It certifies this computer under each name
//! by which a client asks for it.

use super::error::TlsError;
use jiff::{Timestamp, tz::Offset};
use rcgen::{
    BasicConstraints, CertificateParams, DistinguishedName, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer,
    KeyPair, KeyUsagePurpose, date_time_ymd,
};
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tokio_rustls::rustls::crypto::ring::sign::any_supported_type;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, PrivatePkcs8KeyDer};
use tokio_rustls::rustls::sign::CertifiedKey;

/// Parameters of the authority and its certificates.
struct AuthorityConfig {
    /// For how long the authority is valid, days: as long as the robot serves, since replacing it means telling all browsers again. Chosen: ten years, longer than robots
    /// serve.
    authority_days: i64,
    /// For how long a certificate is valid, days. Browsers accept 398 at most. Chosen: as usual of automatic authorities; a stolen key is worthless after it.
    certificate_days: i64,
    /// Time after which a certificate is made anew, while the program runs: a third of its validity. Chosen: a program that is ended for weeks has a valid one when it
    /// starts.
    renewal_period: Duration,
    /// Names that are kept. Only names of this server are certified, so they are few. Chosen: it bounds the memory.
    max_names: usize,
}

const CONFIG: AuthorityConfig = AuthorityConfig {
    authority_days: 3_650,
    certificate_days: 90,
    renewal_period: Duration::from_secs(30 * 24 * 3_600),
    max_names: 64,
};

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
        // Name and key are all that a certificate says of its authority.
        Ok(Self {
            issuer: Issuer::new(authority_params(), key_pair),
            certificate: der,
            pem,
            certified: Mutex::default(),
        })
    }

    /// Its certificate in PEM format, which people tell their browsers to trust.
    pub(crate) fn certificate_pem(&self) -> &str {
        &self.pem
    }

    /// Its certificate as bytes.
    pub(crate) fn certificate_der(&self) -> &[u8] {
        &self.certificate
    }

    /// A certificate of this computer under these names and addresses.
    ///
    /// # Errors
    /// When it cannot be made.
    pub(crate) fn certified(&self, names: &[String]) -> Result<Arc<CertifiedKey>, TlsError> {
        let names: Vec<_> = names.iter().map(|name| name.to_ascii_lowercase()).collect();
        let known_as = names.join(" ");
        let mut certified = self.certified.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((made, key)) = certified.get(&known_as)
            && made.elapsed() < CONFIG.renewal_period
        {
            return Ok(Arc::clone(key));
        }
        let made = self.certify(names).map_err(|error| TlsError::Make(error.to_string()))?;
        let key = any_supported_type(&made.1).map_err(|error| TlsError::Make(error.to_string()))?;
        let key = Arc::new(CertifiedKey::new(vec![made.0, self.certificate.clone()], key));
        if certified.len() >= CONFIG.max_names {
            certified.clear();
        }
        certified.insert(known_as, (Instant::now(), Arc::clone(&key)));
        Ok(key)
    }

    fn certify(
        &self,
        names: Vec<String>,
    ) -> Result<(CertificateDer<'static>, PrivateKeyDer<'static>), rcgen::Error> {
        let mut params = CertificateParams::new(names)?;
        params.distinguished_name = named("AutoInspect robot");
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth];
        params.use_authority_key_identifier_extension = true;
        set_validity(&mut params, CONFIG.certificate_days);
        let key = KeyPair::generate()?;
        let certificate = params.signed_by(&key, &self.issuer)?;
        let key = PrivateKeyDer::Pkcs8(PrivatePkcs8KeyDer::from(key.serialize_der()));
        Ok((certificate.der().clone(), key))
    }
}

fn authority_params() -> CertificateParams {
    let mut params = CertificateParams::default();
    params.distinguished_name = named("AutoInspect authority of this robot");
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    params
}

/// A new authority and its key, in PEM format.
fn make() -> Result<(String, String), rcgen::Error> {
    let mut params = authority_params();
    set_validity(&mut params, CONFIG.authority_days);
    let key = KeyPair::generate()?;
    Ok((params.self_signed(&key)?.pem(), key.serialize_pem()))
}

fn named(name: &str) -> DistinguishedName {
    let mut distinguished = DistinguishedName::new();
    distinguished.push(DnType::CommonName, name);
    distinguished
}

/// From yesterday, because the clocks of clients differ, for this number of days.
fn set_validity(params: &mut CertificateParams, days: i64) {
    let midnight = |days_from_now: i64| {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
        let now =
            i64::try_from(now).ok().and_then(|now| Timestamp::from_second(now).ok()).unwrap_or_default();
        let today = Offset::UTC.to_datetime(now).date();
        let date = today.saturating_add(jiff::Span::new().days(days_from_now));
        // Month and day are always positive.
        date_time_ymd(i32::from(date.year()), date.month().unsigned_abs(), date.day().unsigned_abs())
    };
    (params.not_before, params.not_after) = (midnight(-1), midnight(days));
}

fn write(path: &Path, content: &str, mode: u32) -> std::io::Result<()> {
    let mut file = fs::OpenOptions::new().write(true).create(true).truncate(true).mode(mode).open(path)?;
    file.write_all(content.as_bytes())?;
    file.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn an_authority_is_made_once_and_only_its_user_reads_the_key() {
        let folder = tempfile::tempdir().expect("a folder");
        let first = Authority::open(folder.path()).expect("made").certificate_pem().to_owned();
        let again = Authority::open(folder.path()).expect("read");
        assert_eq!(again.certificate_pem(), first);
        let key = fs::metadata(folder.path().join("authority-key.pem")).expect("a key");
        assert_eq!(key.permissions().mode() & 0o777, 0o600);
        let names = ["robot7".to_owned(), "192.0.2.7".to_owned()];
        let made = again.certified(&names).expect("a certificate");
        assert!(Arc::ptr_eq(&made, &again.certified(&names).expect("the same")));
    }

    #[test]
    fn an_authority_whose_key_is_damaged_is_not_replaced_silently() {
        let folder = tempfile::tempdir().expect("a folder");
        Authority::open(folder.path()).expect("made");
        fs::write(folder.path().join("authority-key.pem"), "damaged").expect("written");
        assert!(matches!(Authority::open(folder.path()), Err(TlsError::File { .. })));
    }
}
