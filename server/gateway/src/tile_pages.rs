//! A page of the tile list of a saved map, read from its file without keeping the rest.

use crate::pages::PageRequest;
use api::{TileEntry, TileHash, TileList};
use serde::de::{DeserializeSeed, Deserializer, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

/// A part of a tile list.
pub(crate) struct TilePage {
    /// The list with this part of its tiles.
    pub(crate) list: TileList,
    /// Whether more tiles follow.
    pub(crate) has_more: bool,
    /// Whether the tile before the first one is in the list.
    pub(crate) is_found: bool,
}

/// Reads a page; `after` is the request's key.
///
/// # Errors
/// When the file cannot be read.
pub(crate) fn read(path: &Path, page: &PageRequest, after: Option<TileHash>) -> io::Result<TilePage> {
    let file = BufReader::new(File::open(path)?);
    let seed = ListSeed { max_tiles: page.max_entries(), after };
    seed.deserialize(&mut serde_json::Deserializer::from_reader(file)).map_err(io::Error::from)
}

struct ListSeed {
    max_tiles: usize,
    after: Option<TileHash>,
}

impl<'de> DeserializeSeed<'de> for ListSeed {
    type Value = TilePage;
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<TilePage, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for ListSeed {
    type Value = TilePage;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a tile list")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut fields: A) -> Result<TilePage, A::Error> {
        let (mut bounds, mut robust_bounds, mut tiles) = (None, None, None);
        while let Some(name) = fields.next_key::<String>()? {
            match name.as_str() {
                "bounds" => bounds = Some(fields.next_value()?),
                "robust_bounds" => robust_bounds = fields.next_value()?,
                "tiles" => {
                    let seed = TilesSeed { max_tiles: self.max_tiles, after: self.after };
                    tiles = Some(fields.next_value_seed(seed)?);
                }
                _ => _ = fields.next_value::<IgnoredAny>()?,
            }
        }
        let bounds = bounds.ok_or_else(|| A::Error::missing_field("bounds"))?;
        let PageTiles { tiles, has_more, is_found } =
            tiles.ok_or_else(|| A::Error::missing_field("tiles"))?;
        Ok(TilePage { list: TileList { bounds, tiles, robust_bounds }, has_more, is_found })
    }
}

struct TilesSeed {
    max_tiles: usize,
    after: Option<TileHash>,
}

struct PageTiles {
    tiles: Vec<TileEntry>,
    has_more: bool,
    is_found: bool,
}

impl<'de> DeserializeSeed<'de> for TilesSeed {
    type Value = PageTiles;
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<PageTiles, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for TilesSeed {
    type Value = PageTiles;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("tiles")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut all: A) -> Result<PageTiles, A::Error> {
        let mut page = PageTiles { tiles: Vec::new(), has_more: false, is_found: self.after.is_none() };
        while let Some(tile) = all.next_element::<TileEntry>()? {
            if !page.is_found {
                page.is_found = Some(tile.hash) == self.after;
            } else if page.tiles.len() < self.max_tiles {
                page.tiles.push(tile);
            } else {
                page.has_more = true;
            }
        }
        Ok(page)
    }
}
