//! Pages of lists over HTTP: `?limit=N` and `?after=KEY` choose one, and a `Link` header leads to the next (RFC 8288). A key is the id of the last entry
//! that was read, so that entries which come and go meanwhile neither hide others nor show them twice.

use crate::limits::FIXED;
use crate::problem::ProblemResponse;
use crate::texts;
use axum::extract::Query;
use axum::extract::rejection::QueryRejection;
use axum::http::{HeaderValue, header};
use axum::response::Response;
use serde::Deserialize;

pub(crate) type AnyQuery = Result<Query<PageQuery>, QueryRejection>;

/// The query of a list.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PageQuery {
    limit: Option<usize>,
    after: Option<String>,
}

/// The wanted part of a list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct PageRequest {
    /// Greatest number of entries, if one is asked for.
    pub(crate) limit: Option<usize>,
    /// Key of the entry before the first; `None` begins at the start.
    pub(crate) after: Option<String>,
}

impl PageRequest {
    /// # Errors
    /// When the query is malformed.
    pub(crate) fn parse(query: AnyQuery) -> Result<Self, ProblemResponse> {
        let malformed = || ProblemResponse::malformed(texts::page_malformed(FIXED.max_page_entries));
        let Query(PageQuery { limit, after }) = query.map_err(|_| malformed())?;
        match limit {
            Some(limit) if !(1..=FIXED.max_page_entries).contains(&limit) => Err(malformed()),
            limit => Ok(Self { limit, after }),
        }
    }

    /// Whether the query asks for anything.
    pub(crate) fn is_whole(&self) -> bool {
        *self == Self::default()
    }

    /// Greatest number of entries of the answer.
    pub(crate) fn max_entries(&self) -> usize {
        self.limit.unwrap_or(FIXED.max_page_entries)
    }

    /// The entries of the page, and the key of the last one if there are more.
    ///
    /// # Errors
    /// When the entry before the first is not in the list any more.
    pub(crate) fn of<'a, T>(
        &self,
        all: &'a [T],
        key: impl Fn(&T) -> String,
    ) -> Result<(&'a [T], Option<String>), ProblemResponse> {
        let first = match &self.after {
            None => 0,
            Some(after) => {
                let before = all.iter().position(|entry| key(entry) == *after);
                before.ok_or_else(|| ProblemResponse::not_found(texts::page_gone(after)))? + 1
            }
        };
        let page = &all[first..all.len().min(first.saturating_add(self.max_entries()))];
        let has_more = first + page.len() < all.len();
        Ok((page, page.last().filter(|_| has_more).map(key)))
    }

    /// Adds the link to the page after this one.
    pub(crate) fn link_next(&self, response: &mut Response, path: &str, last: Option<&str>) {
        let Some(last) = last else { return };
        let link =
            format!("<{path}?limit={}&after={}>; rel=\"next\"", self.max_entries(), percent_encoded(last));
        if let Ok(link) = HeaderValue::from_str(&link) {
            response.headers_mut().insert(header::LINK, link);
        }
    }
}

/// Text as a part of a query (RFC 3986, 2.1).
fn percent_encoded(text: &str) -> String {
    let mut encoded = String::new();
    for byte in text.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => {
                encoded.push(char::from(byte))
            }
            _ => encoded.push_str(&format!("%{byte:02X}")),
        }
    }
    encoded
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(limit: Option<usize>, after: Option<&str>) -> PageRequest {
        PageRequest { limit, after: after.map(str::to_owned) }
    }

    #[test]
    fn pages_in_a_row_are_the_list() {
        let all: Vec<u32> = (0..7).collect();
        let key = |entry: &u32| entry.to_string();
        let (mut read, mut after) = (Vec::new(), None);
        loop {
            let (entries, last) = page(Some(3), after.as_deref()).of(&all, key).expect("a page");
            read.extend_from_slice(entries);
            after = last;
            if after.is_none() {
                break;
            }
        }
        assert_eq!(read, all);
        let (entries, last) = page(Some(7), None).of(&all, key).expect("a page");
        assert_eq!((entries.len(), last), (7, None));
        assert!(page(None, Some("9")).of(&all, key).is_err(), "an entry that has gone");
        assert_eq!(page(None, None).of(&[0; 0], key).expect("no entries"), (&[][..], None));
    }

    #[test]
    fn a_link_holds_any_key() {
        let mut response = Response::default();
        page(Some(2), None).link_next(&mut response, "/api/v1/damaged-maps", Some("a b/ä"));
        let link = response.headers()[header::LINK].to_str().expect("ASCII");
        assert_eq!(link, "</api/v1/damaged-maps?limit=2&after=a%20b%2F%C3%A4>; rel=\"next\"");
    }
}
