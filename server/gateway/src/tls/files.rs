//! A certificate and its key from files, read again when they change, so that a certificate is renewed without a restart.

use super::error::TlsError;
use crate::texts;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};
use tokio_rustls::rustls::crypto::ring::sign::any_supported_type;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::sign::CertifiedKey;

/// Parameters of [`CertificateFiles`].
struct CertificateFilesConfig {
    /// Time between two looks at the files. Chosen: whoever exchanges them waits no longer, and a look costs two system calls.
    look_period: Duration,
}

const CONFIG: CertificateFilesConfig = CertificateFilesConfig { look_period: Duration::from_secs(10) };

/// The files with what they held last.
pub(crate) struct CertificateFiles {
    look_period: Duration,
    certificates: PathBuf,
    key: PathBuf,
    current: Mutex<LoadedCertificate>,
}

struct LoadedCertificate {
    certified: Arc<CertifiedKey>,
    changed: [Option<SystemTime>; 2],
    looked: Instant,
}

impl CertificateFiles {
    /// Reads the files.
    ///
    /// # Errors
    /// When they cannot be used.
    pub(crate) fn open(certificates: PathBuf, key: PathBuf) -> Result<Self, TlsError> {
        Self::open_with(CONFIG.look_period, certificates, key)
    }

    fn open_with(look_period: Duration, certificates: PathBuf, key: PathBuf) -> Result<Self, TlsError> {
        let certified = Arc::new(read(&certificates, &key)?);
        let changed = [changed(&certificates), changed(&key)];
        let current = Mutex::new(LoadedCertificate { certified, changed, looked: Instant::now() });
        Ok(Self { look_period, certificates, key, current })
    }

    /// The certificate that is in force now. Files that have changed and cannot be used are reported, and the certificate before stays.
    pub(crate) fn current(&self) -> Arc<CertifiedKey> {
        let mut current = self.current.lock().unwrap_or_else(PoisonError::into_inner);
        if current.looked.elapsed() >= self.look_period {
            current.looked = Instant::now();
            let changed = [changed(&self.certificates), changed(&self.key)];
            if changed != current.changed {
                match read(&self.certificates, &self.key) {
                    Ok(certified) => {
                        tracing::info!("the certificate was read again");
                        (current.certified, current.changed) = (Arc::new(certified), changed);
                    }
                    // Perhaps only one of both files was replaced so far.
                    Err(error) => tracing::error!("{error}. The certificate of before stays in force"),
                }
            }
        }
        Arc::clone(&current.certified)
    }
}

fn changed(path: &Path) -> Option<SystemTime> {
    fs::metadata(path).and_then(|about| about.modified()).ok()
}

fn read(certificates: &Path, key: &Path) -> Result<CertifiedKey, TlsError> {
    let failed = |path: &Path, reason: String| TlsError::File { path: path.to_owned(), reason };
    let chain = CertificateDer::pem_file_iter(certificates).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let chain = chain.map_err(|error| failed(certificates, error.to_string()))?;
    if chain.is_empty() {
        return Err(failed(certificates, texts::NO_CERTIFICATE.to_owned()));
    }
    let private = PrivateKeyDer::from_pem_file(key).map_err(|error| failed(key, error.to_string()))?;
    let private = any_supported_type(&private).map_err(|error| failed(key, error.to_string()))?;
    let certified = CertifiedKey::new(chain, private);
    certified.keys_match().map_err(|_| failed(key, texts::OTHER_KEY.to_owned()))?;
    Ok(certified)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rcgen::{CertificateParams, KeyPair};
    use std::fs::File;

    /// Writes a new certificate and returns its bytes. `changed` is when its files seem to have changed.
    fn renew(folder: &Path, changed: SystemTime, is_key_written: bool) -> Vec<u8> {
        let key = KeyPair::generate().expect("a key");
        let params = CertificateParams::new(vec!["robot7".to_owned()]).expect("a name");
        let certificate = params.self_signed(&key).expect("a certificate");
        let mut files = vec![("certificate.pem", certificate.pem())];
        if is_key_written {
            files.push(("key.pem", key.serialize_pem()));
        }
        for (name, content) in files {
            fs::write(folder.join(name), content).expect("written");
            let file = File::options().append(true).open(folder.join(name)).expect("a file");
            file.set_modified(changed).expect("a time");
        }
        certificate.der().to_vec()
    }

    #[test]
    fn a_renewed_certificate_is_read_and_one_without_its_key_is_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |seconds| SystemTime::UNIX_EPOCH + Duration::from_secs(seconds);
        let first = renew(folder.path(), at(1), true);
        let (certificates, key) = (folder.path().join("certificate.pem"), folder.path().join("key.pem"));
        let files = CertificateFiles::open_with(Duration::ZERO, certificates, key).expect("usable");
        let served = || files.current().cert[0].to_vec();
        assert_eq!(served(), first);
        let second = renew(folder.path(), at(2), true);
        assert_eq!(served(), second);
        renew(folder.path(), at(3), false);
        assert_eq!(served(), second, "the key of the third is missing");
        let fourth = renew(folder.path(), at(4), true);
        assert_eq!(served(), fourth);
    }
}
