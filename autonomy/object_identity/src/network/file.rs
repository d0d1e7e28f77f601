//! The weights of a network as bytes: `AIPN`, the version of the format and the units of the layers as u32, the weights as f32, all little-endian, and the BLAKE3 of everything before.

use super::PointNetwork;
use super::layers::Dense;
use blake3::Hash;
use thiserror::Error;

const MAGIC: &[u8; 4] = b"AIPN";
const FORMAT_VERSION: u32 = 1;
const CHECKSUM_BYTES: usize = 32;

/// Why bytes are no network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum NetworkFileError {
    /// Something else.
    #[error("it is no file of a point network")]
    NotANetwork,
    /// A later program wrote it.
    #[error("its format has version {0}, and this program reads version {FORMAT_VERSION}")]
    Version(u32),
    /// Its layers are other ones.
    #[error("its layers have other numbers of units than those of this program")]
    Layers,
    /// It was cut off, changed or has numbers that are not finite.
    #[error("it is damaged")]
    Damaged,
}

impl PointNetwork {
    /// Reads a network.
    ///
    /// # Errors
    /// When the bytes are none of this version, or are damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, NetworkFileError> {
        let (magic, rest) = bytes.split_first_chunk().ok_or(NetworkFileError::NotANetwork)?;
        if magic != MAGIC {
            return Err(NetworkFileError::NotANetwork);
        }
        let (version, _) = rest.split_first_chunk().ok_or(NetworkFileError::Damaged)?;
        let version = u32::from_le_bytes(*version);
        if version != FORMAT_VERSION {
            return Err(NetworkFileError::Version(version));
        }
        let (content, checksum) =
            bytes.split_last_chunk::<CHECKSUM_BYTES>().ok_or(NetworkFileError::Damaged)?;
        if blake3::hash(content) != Hash::from_bytes(*checksum) {
            return Err(NetworkFileError::Damaged);
        }
        let mut numbers = content.get(8..).ok_or(NetworkFileError::Damaged)?.chunks_exact(4);
        let mut next = || numbers.next().and_then(|bytes| bytes.try_into().ok());
        let mut whole = || next().map(u32::from_le_bytes).ok_or(NetworkFileError::Damaged);
        let shapes = Self::shapes();
        for units in shapes.into_iter().flatten() {
            if whole()? as usize != units {
                return Err(NetworkFileError::Layers);
            }
        }
        let mut layers = shapes.map(Dense::zeros);
        for value in layers.iter_mut().flat_map(|layer| &mut layer.values) {
            *value =
                next().map(f32::from_le_bytes).filter(|x| x.is_finite()).ok_or(NetworkFileError::Damaged)?;
        }
        if next().is_some() {
            return Err(NetworkFileError::Damaged);
        }
        let [a, b, c, d] = layers;
        Ok(Self::new([a, b], [c, d]))
    }

    /// The network as bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = self.content();
        let checksum = blake3::hash(&bytes);
        bytes.extend(checksum.as_bytes());
        bytes
    }

    /// The checksum of its bytes.
    pub(super) fn checksum(&self) -> Hash {
        blake3::hash(&self.content())
    }

    fn content(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(FORMAT_VERSION.to_le_bytes());
        for units in Self::shapes().into_iter().flatten() {
            bytes.extend((units as u32).to_le_bytes());
        }
        for value in self.layers().into_iter().flat_map(|layer| &layer.values) {
            bytes.extend(value.to_le_bytes());
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_network_is_read_and_written_alike() {
        let network = PointNetwork::shipped().expect("the file of this program");
        assert_eq!(network.to_bytes(), super::super::SHIPPED);
        assert!(network.to_bytes().len() < 1_000_000);
    }

    #[test]
    fn damaged_and_other_files_are_refused() {
        let bytes = super::super::SHIPPED.to_vec();
        let read = |bytes: &[u8]| PointNetwork::from_bytes(bytes).map(|_| ());
        for end in (0..bytes.len()).step_by(97) {
            assert!(read(&bytes[..end]).is_err(), "{end}");
        }
        for place in (0..bytes.len()).step_by(997) {
            let mut changed = bytes.clone();
            changed[place] ^= 4;
            assert!(read(&changed).is_err(), "{place}");
        }
        let mut later = bytes.clone();
        later[4] = 2;
        assert_eq!(read(&later), Err(NetworkFileError::Version(2)));
        assert_eq!(read(b"solid stone"), Err(NetworkFileError::NotANetwork));
    }
}
