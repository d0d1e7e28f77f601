//! Compresses files at build time, so that the server only copies bytes.
//!
//! Both forms are needed: browsers accept brotli on secure origins only, and gzip also on `http://` names of a local network.

use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::io::Write;
use std::ops::AddAssign;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use flate2::write::GzEncoder;

/// Compression effort.
#[derive(Clone, Copy)]
pub(crate) enum CompressionEffort {
    /// 1 s for 10 MB; for development.
    Quick,
    /// Smallest size, 30 s for 10 MB; for releases.
    Smallest,
}

impl CompressionEffort {
    fn brotli_quality(self) -> i32 {
        match self {
            Self::Quick => 4,
            Self::Smallest => 11,
        }
    }

    fn gzip_level(self) -> flate2::Compression {
        match self {
            Self::Quick => flate2::Compression::fast(),
            Self::Smallest => flate2::Compression::best(),
        }
    }
}

/// Sizes of one file, or a sum of them, in bytes.
#[derive(Clone, Copy, Default)]
pub(crate) struct Sizes {
    pub(crate) plain: u64,
    pub(crate) gzip: u64,
    pub(crate) brotli: u64,
}

impl Sizes {
    pub(crate) const HEADINGS: &str = "     bytes       gzip     brotli";
}

impl AddAssign for Sizes {
    fn add_assign(&mut self, other: Self) {
        self.plain += other.plain;
        self.gzip += other.gzip;
        self.brotli += other.brotli;
    }
}

impl fmt::Display for Sizes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:>10} {:>10} {:>10}", self.plain, self.gzip, self.brotli)
    }
}

/// Writes `content` as `folder/name`, with `.gz` and `.br` beside it, and adds the three paths to `written`.
pub(crate) fn write_with_variants(
    folder: &Path,
    name: &str,
    content: &[u8],
    effort: CompressionEffort,
    written: &mut BTreeSet<PathBuf>,
) -> Result<Sizes> {
    let gzip = gzip(content, effort).with_context(|| format!("could not compress {name} with gzip"))?;
    let brotli = brotli(content, effort).with_context(|| format!("could not compress {name} with brotli"))?;
    for (suffix, bytes) in [("", content), (".gz", &gzip), (".br", &brotli)] {
        let path = folder.join(format!("{name}{suffix}"));
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).with_context(|| format!("could not create {}", parent.display()))?;
        }
        fs::write(&path, bytes).with_context(|| format!("could not write {}", path.display()))?;
        written.insert(path);
    }
    Ok(Sizes { plain: content.len() as u64, gzip: gzip.len() as u64, brotli: brotli.len() as u64 })
}

fn gzip(content: &[u8], effort: CompressionEffort) -> std::io::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), effort.gzip_level());
    encoder.write_all(content)?;
    encoder.finish()
}

fn brotli(content: &[u8], effort: CompressionEffort) -> std::io::Result<Vec<u8>> {
    let parameters = brotli::enc::BrotliEncoderParams {
        quality: effort.brotli_quality(),
        lgwin: 24,
        size_hint: content.len(),
        ..Default::default()
    };
    let mut compressed = Vec::new();
    brotli::BrotliCompress(&mut &*content, &mut compressed, &parameters)?;
    Ok(compressed)
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    #[test]
    fn both_forms_decompress_to_the_original() {
        let original: Vec<u8> = (0..100_000_u32).flat_map(|i| i.wrapping_mul(i).to_le_bytes()).collect();
        for effort in [CompressionEffort::Quick, CompressionEffort::Smallest] {
            let mut unzipped = Vec::new();
            let zipped = gzip(&original, effort).unwrap();
            flate2::read::GzDecoder::new(&*zipped).read_to_end(&mut unzipped).unwrap();
            assert_eq!(unzipped, original);

            let mut unpacked = Vec::new();
            let packed = brotli(&original, effort).unwrap();
            brotli::BrotliDecompress(&mut &*packed, &mut unpacked).unwrap();
            assert_eq!(unpacked, original);
        }
    }
}
