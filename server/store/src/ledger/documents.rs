//! The site in the ledger: its objects with their revisions, and the edits that made them.

use super::rows::{Fault, integer, or_null, text};
use super::schema::{DOCUMENT_REVISIONS, DOCUMENTS, EDITS};
use super::{Ledger, LedgerWriter};
use crate::StoreError;
use api::{MAX_PAGE, MAX_PAGE_BYTES, SiteState, StoredRevision};
use messages::Principal;
use rusqlite::types::Value;
use rusqlite::{Connection, params};
use site_model::{
    Change, Edit, EditId, Object, ObjectId, ObjectKind, Revision, RevisionChange, Site, Versioned,
};
use vocab::Stamp;

/// An edit that was applied to the site in memory.
#[derive(Clone, Copy, Debug)]
pub struct EditRecord<'a> {
    /// Revision of the site after it.
    pub revision: u64,
    /// The edit.
    pub edit: &'a Edit,
    /// Revisions of the changed objects, in the order of the changes.
    pub changes: &'a [RevisionChange],
    /// Who made it; none: the robot itself.
    pub by: Option<&'a Principal>,
    /// When, by calendar time.
    pub at: Stamp,
}

impl LedgerWriter<'_> {
    /// Writes an edit, its objects and its entry in the audit log.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn put_edit(&self, record: &EditRecord<'_>) -> Result<(), StoreError> {
        self.try_put_edit(record).map_err(|fault| self.error(fault))
    }

    fn try_put_edit(&self, record: &EditRecord<'_>) -> Result<(), Fault> {
        let EditRecord { revision, edit, changes, by, at } = *record;
        let author = author(by);
        let values = [
            Value::from(revision as i64),
            Value::from(edit.id.to_string()),
            author.clone(),
            Value::from(at.nanos()),
            Value::from(json(&changes)),
        ];
        EDITS.put(self.transaction, &values)?;
        for (change, made) in edit.changes.iter().zip(changes) {
            let (revision, object) = match (change, made.after) {
                (Change::Put { object, .. }, Some(after)) => (after, Some(object)),
                // A removal counts as a revision too.
                _ => (Revision(made.before.unwrap_or_default().0 + 1), None),
            };
            self.put_document(made.object, revision, object, author.clone(), at)?;
        }
        let command = format!("edit {} of {} objects", edit.id, edit.changes.len());
        self.put_audit(by, &command, "applied", at)
    }

    /// Writes a state of an object.
    pub(super) fn put_document(
        &self,
        id: ObjectId,
        revision: Revision,
        object: Option<&Object>,
        author: Value,
        at: Stamp,
    ) -> Result<(), Fault> {
        let values = [
            Value::from(id.kind().name().to_owned()),
            Value::from(id.uuid().to_string()),
            Value::from(revision.0 as i64),
            or_null(object.map(json)),
            author,
            Value::from(at.nanos()),
        ];
        DOCUMENT_REVISIONS.put(self.transaction, &values)?;
        DOCUMENTS.put(self.transaction, &values)
    }

    /// The answer to an edit that was applied before: the revision of the site after it, and those of its objects.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn applied_edit(&self, id: EditId) -> Result<Option<(u64, Vec<RevisionChange>)>, StoreError> {
        let take = |row: &[Value]| {
            let changes = serde_json::from_str(text(&row[4])?).ok()?;
            Some((u64::try_from(integer(&row[0])?).ok()?, changes))
        };
        let found = EDITS.read(self.transaction, "WHERE id = ?", [id.to_string()], take);
        Ok(found.map_err(|fault| self.error(fault))?.pop())
    }
}

impl Ledger {
    /// States of an object before `before`, the newest first.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn revisions(
        &self,
        object: ObjectId,
        before: Option<Revision>,
        limit: u32,
    ) -> Result<Vec<StoredRevision>, StoreError> {
        let (kind, id) = (object.kind().name(), object.uuid().to_string());
        let before = before.map_or(i64::MAX, |before| i64::try_from(before.0).unwrap_or(i64::MAX));
        let rest = "WHERE kind = ? AND id = ? AND revision < ? ORDER BY revision DESC LIMIT ?";
        let mut bytes = 0;
        let take = |row: &[Value]| {
            bytes += text(&row[3]).map_or(0, str::len);
            let revision = StoredRevision {
                revision: Revision(u64::try_from(integer(&row[2])?).ok()?),
                object: match &row[3] {
                    Value::Null => None,
                    body => Some(serde_json::from_str(text(body)?).ok()?),
                },
                author: text(&row[4]).map(str::to_owned),
                at: Stamp::from_nanos(integer(&row[5])?),
            };
            Some((revision, bytes))
        };
        let parameters = params![kind, id, before, limit.clamp(1, MAX_PAGE)];
        let read = DOCUMENT_REVISIONS.read(&self.connection, rest, parameters, take);
        let read = read.map_err(|fault| self.error(fault))?;
        // The first one always, so that whoever pages gets on.
        let fits =
            |(place, (_, bytes)): &(usize, (StoredRevision, usize))| *place == 0 || *bytes <= MAX_PAGE_BYTES;
        Ok(read.into_iter().enumerate().take_while(fits).map(|(_, (revision, _))| revision).collect())
    }
}

/// An object as a row says it is; without an object it was removed.
pub(super) fn document(row: &[Value]) -> Option<(ObjectId, Revision, Option<Object>)> {
    let id = ObjectId::new(ObjectKind::of_name(text(&row[0])?)?, text(&row[1])?.parse().ok()?);
    let revision = Revision(u64::try_from(integer(&row[2])?).ok()?);
    let object = match &row[3] {
        Value::Null => None,
        body => Some(serde_json::from_str::<Object>(text(body)?).ok().filter(|object| object.id() == id)?),
    };
    Some((id, revision, object))
}

/// All objects, and the number of the last edit.
pub(super) fn read_site(connection: &Connection) -> Result<SiteState, Fault> {
    let mut objects = Vec::new();
    let mut removed = Vec::new();
    DOCUMENTS.read(connection, "", [], |row| {
        let (id, revision, object) = document(row)?;
        match object {
            Some(object) => objects.push(Versioned { revision, object }),
            None => removed.push((id, revision)),
        }
        Some(())
    })?;
    let newest = "ORDER BY seq DESC LIMIT 1";
    let last = EDITS.read(connection, newest, [], |row| u64::try_from(integer(&row[0])?).ok())?;
    let revision = last.first().copied().unwrap_or(0);
    Ok(SiteState { revision, site: Site::new(objects, removed) })
}

/// Who made an edit, as a column.
pub(super) fn author(by: Option<&Principal>) -> Value {
    or_null(by.map(json))
}

/// As JSON. Total for the types that are stored: their keys are texts, and numbers that are not finite are not accepted by the site.
pub(super) fn json<T: serde::Serialize + ?Sized>(value: &T) -> String {
    serde_json::to_string(value).unwrap_or_default()
}
