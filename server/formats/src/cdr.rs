//! The two binary encodings of ROS messages: CDR (XCDR1 and plain XCDR2, both byte orders) and ROS 1's own.
//!
//! They differ in alignment, byte order and the terminating zero of strings, and in nothing else that
//! matters to the messages in [`crate::ros`], so one reader and one writer serve both.
//! Source: OMG DDS-XTypes 1.3, clause 7.4; ROS 1 wiki, "msg".

use crate::{FormatError, texts};

/// How the messages of a channel are serialised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// ROS 2: a 4-byte encapsulation header, then aligned values.
    Cdr,
    /// ROS 1: little-endian, packed.
    Ros1,
}

/// Reads values one after the other and never past the end.
pub struct CdrReader<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Offset from which alignment counts.
    origin: usize,
    big_endian: bool,
    /// 1 switches alignment off.
    max_align: usize,
    encoding: Encoding,
    /// Named in errors.
    what: &'static str,
}

macro_rules! read_scalar {
    ($($name:ident: $type:ty),*) => {$(
        #[doc = concat!("The next value, a `", stringify!($type), "`.")]
        pub fn $name(&mut self) -> Result<$type, FormatError> {
            let bytes = self.take_array(align_of_wire::<$type>())?;
            Ok(if self.big_endian { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) })
        }
    )*};
}

/// On the wire every scalar is aligned to its size.
const fn align_of_wire<T>() -> usize {
    size_of::<T>()
}

impl<'a> CdrReader<'a> {
    /// Starts reading a message; `what` names it in errors.
    ///
    /// # Errors
    /// When the CDR encapsulation header is missing or names a representation without fixed layout.
    pub fn new(encoding: Encoding, bytes: &'a [u8], what: &'static str) -> Result<Self, FormatError> {
        let mut reader = Self { bytes, at: 0, origin: 0, big_endian: false, max_align: 1, encoding, what };
        if encoding == Encoding::Cdr {
            let [high, kind, _, _] = reader.take_array(1)?;
            (reader.big_endian, reader.max_align) = match (high, kind) {
                (0, 0) => (true, 8),
                (0, 1) => (false, 8),
                (0, 6) => (true, 4),
                (0, 7) => (false, 4),
                _ => {
                    return Err(FormatError::at_byte(what, 0, texts::unknown_cdr(high, kind)));
                }
            };
            reader.origin = 4;
        }
        Ok(reader)
    }

    read_scalar!(u8: u8, u16: u16, u32: u32, u64: u64, i8: i8, i16: i16, i32: i32, i64: i64, f32: f32, f64: f64);

    /// The next value, one byte that is zero or not.
    pub fn bool(&mut self) -> Result<bool, FormatError> {
        Ok(self.u8()? != 0)
    }

    /// The next value, text; bytes that are not UTF-8 are replaced.
    pub fn string(&mut self) -> Result<String, FormatError> {
        let bytes = self.byte_sequence()?;
        let bytes = match (self.encoding, bytes) {
            (Encoding::Cdr, [text @ .., 0]) => text,
            _ => bytes,
        };
        Ok(String::from_utf8_lossy(bytes).into_owned())
    }

    /// The next value, a counted run of bytes, borrowed.
    pub fn byte_sequence(&mut self) -> Result<&'a [u8], FormatError> {
        let count = self.u32()? as usize;
        self.take(count)
    }

    /// The next value, a counted run of elements that take at least `least_size` bytes each.
    pub fn sequence<T>(
        &mut self,
        least_size: usize,
        mut element: impl FnMut(&mut Self) -> Result<T, FormatError>,
    ) -> Result<Vec<T>, FormatError> {
        let count = self.u32()? as usize;
        let needed = count.saturating_mul(least_size);
        if needed > self.remaining() {
            return Err(self.truncated(needed - self.remaining()));
        }
        (0..count).map(|_| element(self)).collect()
    }

    /// The next values, a fixed-length array of f64.
    pub fn f64_array<const N: usize>(&mut self) -> Result<[f64; N], FormatError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Ok(values)
    }

    /// Which encoding is read.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Bytes not yet read.
    pub fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// An error at the current position.
    pub fn malformed(&self, problem: impl Into<String>) -> FormatError {
        FormatError::at_byte(self.what, self.at as u64, problem)
    }

    fn take_array<const N: usize>(&mut self, align: usize) -> Result<[u8; N], FormatError> {
        let align = align.min(self.max_align);
        let padding = (align - (self.at - self.origin) % align) % align;
        self.take(padding)?;
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], FormatError> {
        if count > self.remaining() {
            return Err(self.truncated(count - self.remaining()));
        }
        let taken = &self.bytes[self.at..self.at + count];
        self.at += count;
        Ok(taken)
    }

    fn truncated(&self, missing: usize) -> FormatError {
        FormatError::Truncated { what: self.what, at: self.at as u64, missing: missing as u64 }
    }
}

/// Appends little-endian values to a buffer.
pub struct Writer<'a> {
    out: &'a mut Vec<u8>,
    origin: usize,
    encoding: Encoding,
}

macro_rules! write_scalar {
    ($($name:ident: $type:ty),*) => {$(
        #[doc = concat!("Appends a `", stringify!($type), "`.")]
        pub fn $name(&mut self, value: $type) {
            self.align(align_of_wire::<$type>());
            self.out.extend_from_slice(&value.to_le_bytes());
        }
    )*};
}

impl<'a> Writer<'a> {
    /// Starts a message at the end of `out`.
    pub fn new(encoding: Encoding, out: &'a mut Vec<u8>) -> Self {
        if encoding == Encoding::Cdr {
            out.extend_from_slice(&[0, 1, 0, 0]);
        }
        let origin = out.len();
        Self { out, origin, encoding }
    }

    write_scalar!(u8: u8, u16: u16, u32: u32, u64: u64, i8: i8, i16: i16, i32: i32, i64: i64, f32: f32, f64: f64);

    /// Which encoding is written.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Appends text.
    pub fn string(&mut self, text: &str) {
        let terminator = usize::from(self.encoding == Encoding::Cdr);
        self.u32((text.len() + terminator) as u32);
        self.out.extend_from_slice(text.as_bytes());
        self.out.extend(std::iter::repeat_n(0, terminator));
    }

    /// Appends a counted run of bytes of known length that `fill` appends; it must append exactly `length`.
    pub fn byte_sequence(&mut self, length: usize, fill: impl FnOnce(&mut Vec<u8>)) {
        self.u32(length as u32);
        self.out.reserve(length);
        let start = self.out.len();
        fill(self.out);
        debug_assert_eq!(self.out.len() - start, length);
    }

    /// Appends the values of a fixed-length array.
    pub fn f64_array(&mut self, values: &[f64]) {
        for value in values {
            self.f64(*value);
        }
    }

    fn align(&mut self, size: usize) {
        if self.encoding == Encoding::Cdr {
            let padding = (size - (self.out.len() - self.origin) % size) % size;
            self.out.extend(std::iter::repeat_n(0, padding));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_aligned_in_cdr_and_packed_in_ros1() {
        let write = |encoding| {
            let mut out = Vec::new();
            let mut writer = Writer::new(encoding, &mut out);
            writer.u8(7);
            writer.f64(1.5);
            writer.string("ab");
            writer.u16(9);
            out
        };
        assert_eq!(write(Encoding::Cdr).len(), 4 + 8 + 8 + 4 + 3 + 1 + 2);
        assert_eq!(write(Encoding::Ros1).len(), 1 + 8 + 4 + 2 + 2);
        for encoding in [Encoding::Cdr, Encoding::Ros1] {
            let bytes = write(encoding);
            let mut reader = CdrReader::new(encoding, &bytes, "test").unwrap();
            assert_eq!(reader.u8().unwrap(), 7);
            assert_eq!(reader.f64().unwrap(), 1.5);
            assert_eq!(reader.string().unwrap(), "ab");
            assert_eq!(reader.u16().unwrap(), 9);
            assert_eq!(reader.remaining(), 0);
            assert!(reader.u8().is_err());
        }
    }

    #[test]
    fn big_endian_and_xcdr2_are_read() {
        let mut reader = CdrReader::new(Encoding::Cdr, &[0, 0, 0, 0, 1, 2], "test").unwrap();
        assert_eq!(reader.u16().unwrap(), 0x0102);
        let mut bytes = vec![0, 7, 0, 0, 5, 0, 0, 0];
        bytes.extend(2.5f64.to_le_bytes());
        let mut reader = CdrReader::new(Encoding::Cdr, &bytes, "test").unwrap();
        assert_eq!(reader.u32().unwrap(), 5);
        assert_eq!(reader.f64().unwrap(), 2.5, "XCDR2 aligns eight-byte values to four");
    }

    #[test]
    fn an_absurd_count_is_refused_without_allocating() {
        let bytes = [0, 1, 0, 0, 255, 255, 255, 255];
        let mut reader = CdrReader::new(Encoding::Cdr, &bytes, "test").unwrap();
        assert!(matches!(reader.sequence(8, CdrReader::f64), Err(FormatError::Truncated { .. })));
        let mut reader = CdrReader::new(Encoding::Cdr, &bytes, "test").unwrap();
        assert!(matches!(reader.byte_sequence(), Err(FormatError::Truncated { .. })));
    }
}
