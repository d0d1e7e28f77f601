//! The rows of the privilege table for the HTTP interface. The gateway makes its routes from them, so that there is no route without a row.

use super::{Privilege, Role};
use crate::paths;
use std::fmt;

/// Methods of HTTP that the interface uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "named as in HTTP")]
pub enum HttpMethod {
    Get,
    Post,
    Put,
    Patch,
    Delete,
}

impl fmt::Display for HttpMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Get => "GET",
            Self::Post => "POST",
            Self::Put => "PUT",
            Self::Patch => "PATCH",
            Self::Delete => "DELETE",
        })
    }
}

/// Declares [`Endpoint`] and its rows together.
macro_rules! endpoints {
    ($($name:ident: $method:ident $path:expr, $privilege:expr;)*) => {
        /// A method of a path of the HTTP interface.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        #[allow(missing_docs, reason = "the constants of their paths have the documentation")]
        pub enum Endpoint {
            $($name,)*
        }

        impl Endpoint {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$name,)*];

            /// Its method.
            pub const fn method(self) -> HttpMethod {
                match self {
                    $(Self::$name => HttpMethod::$method,)*
                }
            }

            /// Its path, with names in braces in place of what differs.
            pub const fn path(self) -> &'static str {
                match self {
                    $(Self::$name => $path,)*
                }
            }

            /// Who may use it.
            pub const fn privilege(self) -> Privilege {
                match self {
                    $(Self::$name => $privilege,)*
                }
            }
        }
    };
}

const ANYONE: Privilege = Privilege::Anyone;
const VIEWER: Privilege = Privilege::SignedIn(Role::Viewer);
const OPERATOR: Privilege = Privilege::SignedIn(Role::Operator);
const ADMIN: Privilege = Privilege::SignedIn(Role::Admin);

endpoints! {
    Control: Get paths::CONTROL_PATH, VIEWER;
    Stream: Get paths::STREAM_PATH, VIEWER;
    // Says nothing about the robot; monitoring needs it.
    Health: Get paths::HEALTH_PATH, ANYONE;
    Description: Get paths::DESCRIPTION_PATH, ANYONE;
    // For browsers that do not trust the robot yet. A certificate is public.
    Authority: Get paths::AUTHORITY_PATH, ANYONE;
    AuthorityCertificate: Get paths::AUTHORITY_CERTIFICATE_PATH, ANYONE;
    TrustCode: Get paths::TRUST_CODE_PATH, ANYONE;
    // Who asks, for the page that asks people to sign in.
    Session: Get paths::SESSION_PATH, ANYONE;
    SignIn: Post paths::SESSION_PATH, ANYONE;
    SignOut: Delete paths::SESSION_PATH, VIEWER;
    MakeFirstAdmin: Post paths::FIRST_ADMIN_PATH, ANYONE;
    ChangeOwnPassword: Put paths::OWN_PASSWORD_PATH, VIEWER;
    ListAccounts: Get paths::ACCOUNTS_PATH, ADMIN;
    AddAccount: Post paths::ACCOUNTS_PATH, ADMIN;
    ChangeAccount: Patch paths::ACCOUNT_PATH, ADMIN;
    RemoveAccount: Delete paths::ACCOUNT_PATH, ADMIN;
    ListTokens: Get paths::TOKENS_PATH, ADMIN;
    AddToken: Post paths::TOKENS_PATH, ADMIN;
    RevokeToken: Delete paths::TOKEN_PATH, ADMIN;
    ListAudit: Get paths::AUDIT_PATH, ADMIN;
    // Whoever sees danger stops the robot.
    StopMotion: Post paths::STOP_PATH, VIEWER;
    ListMaps: Get paths::MAPS_PATH, VIEWER;
    GetMap: Get paths::MAP_PATH, VIEWER;
    RenameMap: Patch paths::MAP_PATH, OPERATOR;
    DeleteMap: Delete paths::MAP_PATH, OPERATOR;
    ListBin: Get paths::BIN_PATH, VIEWER;
    DeleteMapPermanently: Delete paths::BINNED_MAP_PATH, ADMIN;
    RestoreMap: Post paths::RESTORE_MAP_PATH, OPERATOR;
    ListDamagedMaps: Get paths::DAMAGED_MAPS_PATH, VIEWER;
    GetMapTiles: Get paths::MAP_TILES_PATH, VIEWER;
    GetMapGraph: Get paths::MAP_GRAPH_PATH, VIEWER;
    GetTile: Get paths::TILE_PATH, VIEWER;
    GetBlob: Get paths::BLOB_PATH, VIEWER;
    GetCloud: Get paths::CLOUD_PATH, VIEWER;
    ListUploads: Get paths::UPLOADS_PATH, VIEWER;
    Upload: Put paths::UPLOAD_PATH, OPERATOR;
    DeleteUpload: Delete paths::UPLOAD_PATH, OPERATOR;
    GetSite: Get paths::SITE_PATH, VIEWER;
    ListObjects: Get paths::SITE_KIND_PATH, VIEWER;
    CreateObject: Post paths::SITE_KIND_PATH, OPERATOR;
    GetObject: Get paths::SITE_OBJECT_PATH, VIEWER;
    PutObject: Put paths::SITE_OBJECT_PATH, OPERATOR;
    PatchObject: Patch paths::SITE_OBJECT_PATH, OPERATOR;
    DeleteObject: Delete paths::SITE_OBJECT_PATH, OPERATOR;
    ListRevisions: Get paths::SITE_REVISIONS_PATH, VIEWER;
    PostEdit: Post paths::SITE_EDITS_PATH, OPERATOR;
    GetExample: Get paths::EXAMPLE_PATH, VIEWER;
    MakeExample: Post paths::EXAMPLE_PATH, OPERATOR;
    CancelExample: Delete paths::EXAMPLE_PATH, OPERATOR;
    ListRuns: Get paths::RUNS_PATH, VIEWER;
    StartRun: Post paths::RUNS_PATH, OPERATOR;
    GetCurrentRuns: Get paths::CURRENT_RUNS_PATH, VIEWER;
    CommandRun: Post paths::RUN_COMMANDS_PATH, OPERATOR;
    ListSteps: Get paths::RUN_STEPS_PATH, VIEWER;
    ListResults: Get paths::RUN_RESULTS_PATH, VIEWER;
    ListRunClouds: Get paths::RUN_CLOUDS_PATH, VIEWER;
    GetRunCloud: Get paths::RUN_CLOUD_PATH, VIEWER;
    DownloadRun: Get paths::RUN_DOWNLOAD_PATH, VIEWER;
    DownloadRunMcap: Get paths::RUN_MCAP_PATH, VIEWER;
    ReportRun: Get paths::RUN_REPORT_PATH, VIEWER;
    ReportPeriod: Get paths::REPORT_PATH, VIEWER;
    ListPointResults: Get paths::POINT_RESULTS_PATH, VIEWER;
    ComparePictures: Get paths::PICTURE_COMPARISON_PATH, VIEWER;
    ListSlots: Get paths::SLOTS_PATH, VIEWER;
    ListSceneChanges: Get paths::SCENE_CHANGES_PATH, VIEWER;
    ListAlerts: Get paths::ALERTS_PATH, VIEWER;
    GetChangesNormal: Get paths::NORMAL_CHANGES_PATH, VIEWER;
    MakeChangesNormal: Post paths::NORMAL_CHANGES_PATH, OPERATOR;
}
