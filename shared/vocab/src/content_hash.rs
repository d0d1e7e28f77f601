//! Names of immutable files: the BLAKE3 of their bytes.

/// Declares a type of such names, with the error for text that is none. It is hexadecimal in text and in formats that people read. The crate that uses it needs
/// `serde`.
#[macro_export]
macro_rules! content_hash {
    ($(#[$doc:meta])* $name:ident, $(#[$error_doc:meta])* $error:ident, $sentence:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub [u8; 32]);

        $(#[$error_doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $error;

        impl std::fmt::Display for $error {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str($sentence)
            }
        }

        impl std::error::Error for $error {}

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
            }
        }

        impl std::fmt::Debug for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, concat!(stringify!($name), "({})"), self)
            }
        }

        impl std::str::FromStr for $name {
            type Err = $error;
            fn from_str(text: &str) -> Result<Self, $error> {
                let digits = text.as_bytes();
                if digits.len() != 64 {
                    return Err($error);
                }
                let value = |digit: u8| (digit as char).to_digit(16).ok_or($error);
                let mut hash = [0; 32];
                for (byte, pair) in hash.iter_mut().zip(digits.chunks_exact(2)) {
                    *byte = (value(pair[0])? << 4 | value(pair[1])?) as u8;
                }
                Ok(Self(hash))
            }
        }

        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                if serializer.is_human_readable() {
                    serializer.collect_str(self)
                } else {
                    serde::Serialize::serialize(&self.0, serializer)
                }
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                if deserializer.is_human_readable() {
                    <String as serde::Deserialize>::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
                } else {
                    <[u8; 32] as serde::Deserialize>::deserialize(deserializer).map(Self)
                }
            }
        }
    };
}

content_hash! {
    /// BLAKE3 of the bytes of a file that an action has gathered: its name.
    BlobHash,
    /// Text that names no such file.
    BlobHashError,
    "a file is named by 64 hexadecimal digits"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_64_hexadecimal_digits_and_nothing_else() {
        let hash = BlobHash(std::array::from_fn(|i| i as u8 * 7));
        let text = hash.to_string();
        assert_eq!((text.len(), text.parse()), (64, Ok(hash)));
        assert_eq!(text.to_uppercase().parse(), Ok(hash));
        for wrong in [&text[1..], &format!("{text}0"), &text.replace('7', "g"), &"é".repeat(32), ""] {
            assert_eq!(wrong.parse::<BlobHash>(), Err(BlobHashError), "{wrong}");
        }
    }
}
