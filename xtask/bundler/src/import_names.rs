//! Makes the names of imported functions easy to compress.
//!
//! wasm-bindgen ends the name of each browser function that the client imports with a hash of 16 hexadecimal digits, in the WASM and in its glue. Hashes cannot be
//! compressed: 800 of them are 15 kB of the compressed client. Here each becomes a number of as many digits, so that no length in the WASM changes.

use std::collections::BTreeMap;

/// Beginning of the names.
const PREFIX: &str = "__wbg_";
/// Digits of a hash.
const HASH_DIGITS: usize = 16;

/// Replaces the hashes by numbers from 0, in the order of the names. The glue and the WASM name the same functions before and after.
pub(crate) fn number_imports(glue: &str, wasm: &[u8]) -> (String, Vec<u8>) {
    let hashed: BTreeMap<&[u8], usize> = names(glue.as_bytes()).map(|(_, name)| (name, 0)).collect();
    let numbers: BTreeMap<&[u8], usize> =
        hashed.into_keys().enumerate().map(|(number, name)| (name, number)).collect();
    let replaced = |content: &[u8]| {
        let mut result = content.to_vec();
        for (at, name) in names(content) {
            if let Some(number) = numbers.get(name) {
                let digits = format!("{number:0HASH_DIGITS$x}");
                let end = at + name.len();
                result[end - HASH_DIGITS..end].copy_from_slice(digits.as_bytes());
            }
        }
        result
    };
    let glue = String::from_utf8(replaced(glue.as_bytes())).expect("only digits were replaced, by digits");
    (glue, replaced(wasm))
}

/// The names with a hash, each with the place at which it begins.
fn names(content: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let starts = (0..content.len()).filter(|at| content[*at..].starts_with(PREFIX.as_bytes()));
    starts.filter_map(|at| {
        let is_of_name = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
        let length = content[at..].iter().take_while(|byte| is_of_name(byte)).count();
        let name = &content[at..at + length];
        let (stem, hash) = name.split_at_checked(length.checked_sub(HASH_DIGITS)?)?;
        let is_hash = hash.iter().all(|byte| byte.is_ascii_digit() || (b'a'..=b'f').contains(byte));
        (is_hash && stem.ends_with(b"_")).then_some((at, name))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_become_numbers_in_glue_and_wasm_alike_and_nothing_else_changes() {
        let glue = "__wbg_open_208446807d0d1e30: f, __wbg_close_1f8446807d0d1e30: g, __wbg_set: h, new_208446807d0d1e30";
        // A length stands before a name in WASM, and may read as a letter.
        let wasm = b"\x00a__wbg_open_208446807d0d1e30\x00\x07__wbg_other_aaaaaaaaaaaaaaaa\x00";
        let (numbered_glue, numbered_wasm) = number_imports(glue, wasm);
        assert_eq!(
            numbered_glue,
            "__wbg_open_0000000000000001: f, __wbg_close_0000000000000000: g, __wbg_set: h, new_208446807d0d1e30"
        );
        assert_eq!(
            numbered_wasm,
            b"\x00a__wbg_open_0000000000000001\x00\x07__wbg_other_aaaaaaaaaaaaaaaa\x00"
        );
    }

    #[test]
    fn content_without_names_stays() {
        let (glue, wasm) = number_imports("__wbg_", b"__wbg_208446807d0d1e30");
        assert_eq!((glue.as_str(), wasm.as_slice()), ("__wbg_", b"__wbg_208446807d0d1e30".as_slice()));
    }
}
