//! What is wrong with a file or message, by key: the ends of the sentences of [`crate::FormatError`], without a full stop. English.
//!
//! The sentence already names the file's format and the byte, line or field. A text here says what is wrong there and, where that helps,
//! what to do.

use std::fmt::Display;
use vocab::legible;

/// Characters of a word or name of the file that a sentence shows, at most.
const MAX_SHOWN_CHARS: usize = 40;
/// Characters of a list of names that a sentence shows, at most.
const MAX_SHOWN_LIST_CHARS: usize = 200;

/// A word or name of the file.
pub(crate) fn shown(word: &str) -> String {
    legible(word, MAX_SHOWN_CHARS)
}

// What a file is, or should be.

pub(crate) const POINT_CLOUD: &str = "point cloud";
pub(crate) const E57_FILE: &str = "E57 file";
pub(crate) const KITTI_SCAN: &str = "KITTI scan (x y z intensity, 16 bytes a point)";
pub(crate) const ROS1_BAG: &str = "a ROS 1 bag of version 2.0";
pub(crate) const ROS2_BAG: &str = "a rosbag2 database";
pub(crate) const IMPORTABLE_MAP: &str = "a map that can be imported";

// Any format of text lines.

/// A word that should be a number of things.
pub(crate) fn not_a_count(word: &str) -> String {
    let word = shown(word);
    format!("'{word}' is not a count")
}
/// A word that should be a number.
pub(crate) fn not_a_number(word: &str) -> String {
    let word = shown(word);
    format!("'{word}' is not a number")
}
/// A line with too few words.
pub(crate) const LINE_ENDS_EARLY: &str = "it ends early";

// PCD.

pub(crate) const NO_PCD_HEADER: &str = "it does not begin with a PCD header";
pub(crate) const NO_PCD_SIZE: &str = "neither POINTS nor WIDTH was given";
pub(crate) const PCD_COLUMNS_DIFFER: &str = "FIELDS, SIZE, TYPE and COUNT do not match";

/// DATA is none of ascii, binary and binary_compressed.
pub(crate) fn unknown_data_kind(kind: &str) -> String {
    let kind = shown(kind);
    format!("unknown data kind '{kind}'")
}
/// A pair of TYPE and SIZE that does not exist.
pub(crate) fn unknown_field_type(name: &str, kind: &str, size: usize) -> String {
    let (name, kind) = (shown(name), shown(kind));
    format!("field '{name}' has the unknown type {kind}{size}")
}
/// A point would be longer than 1 MiB.
pub(crate) fn absurd_field_count(name: &str, count: usize) -> String {
    let name = shown(name);
    format!("field '{name}' has the absurd count {count}")
}
/// COUNT 0.
pub(crate) fn field_without_values(name: &str) -> String {
    format!("field '{}' has the count 0", shown(name))
}
/// Compressed data that unpacks to more than the reader's limit.
pub(crate) fn unpacks_to_too_much(bytes: usize, max_bytes: usize) -> String {
    format!("it claims to unpack to {bytes} bytes; at most {max_bytes} are read; save it uncompressed")
}
/// Compressed data unpacks to fewer points than the header states.
pub(crate) fn data_ends_early(stated: usize) -> String {
    format!("{stated} points were stated but the data ends earlier")
}
/// Fewer lines than the header states.
pub(crate) fn too_few_points(stated: usize, found: usize) -> String {
    format!("{stated} points were stated but only {found} are there")
}
pub(crate) fn value_missing(field: &str) -> String {
    let field = shown(field);
    format!("the value of '{field}' is missing")
}
pub(crate) fn not_a_value(word: &str, field: &str) -> String {
    let (word, field) = (shown(word), shown(field));
    format!("'{word}' is not a value of '{field}'")
}

// LZF, the compression of PCD.

pub(crate) const LZF_SIZE_IMPOSSIBLE: &str = "the stated size is larger than the data can unpack to";
pub(crate) const LZF_CUT_OFF: &str = "the data is cut off";
pub(crate) const LZF_REFERENCE_BEFORE_START: &str = "a reference precedes the start";
pub(crate) const LZF_TOO_LONG: &str = "it unpacks to more than the stated size";
pub(crate) const LZF_TOO_SHORT: &str = "it unpacks to less than the stated size";

// PLY.

pub(crate) const NO_PLY_HEADER: &str = "it does not begin with 'ply'";
pub(crate) const NO_VERTICES: &str = "there is no element 'vertex'";
pub(crate) const PLY_LIST_BEFORE_VERTICES: &str = "a PLY file with lists in or before its vertices";
pub(crate) const SAVE_VERTICES_FIRST: &str = "save it with vertices first";
pub(crate) const PROPERTY_BEFORE_ELEMENT: &str = "a property comes before any element";
pub(crate) const PROPERTY_INCOMPLETE: &str = "a property needs a type and a name";
pub(crate) const NO_PLY_FORMAT: &str = "the format is not given";

pub(crate) fn unknown_ply_format(format: &str) -> String {
    format!("unknown format '{}'", shown(format))
}
pub(crate) fn unknown_ply_type(name: &str) -> String {
    format!("unknown type '{}'", shown(name))
}
pub(crate) fn too_few_vertices(stated: usize, found: usize) -> String {
    format!("{stated} vertices were stated but only {found} are there")
}
pub(crate) fn value_missing_or_no_number(field: &str) -> String {
    let field = shown(field);
    format!("the value of '{field}' is missing or no number")
}

// Rows of binary fields: PointCloud2 and the files.

pub(crate) fn field_beyond_point(end: usize, point_bytes: usize) -> String {
    format!("it ends at byte {end} of a point of {point_bytes} bytes")
}
pub(crate) fn row_too_short(row_bytes: usize, width: usize, point_bytes: usize) -> String {
    format!("{row_bytes} bytes cannot hold {width} points of {point_bytes} bytes")
}
/// A cloud without x, y or z.
pub(crate) fn coordinate_missing(fields: &str) -> String {
    let fields = legible(fields, MAX_SHOWN_LIST_CHARS);
    format!("it is missing; the fields are: {fields}")
}
pub(crate) fn unknown_ros_field_type(name: &str, datatype: u8) -> String {
    let name = shown(name);
    format!("field '{name}' has the unknown data type {datatype}")
}

// ROS messages and bags.

pub(crate) fn unknown_cdr(high: u8, kind: u8) -> String {
    format!("unknown CDR representation {high:02x} {kind:02x}; re-record with plain CDR")
}
pub(crate) const OLD_BAG: &str = "it is a bag of an older version; convert it with 'rosbag fix'";
pub(crate) const NO_BAG: &str = "it does not begin as a bag does";
pub(crate) const NO_CHUNK: &str = "there is no chunk where one was announced";
pub(crate) const BAG_INDEX_INCOMPLETE: &str = "the index is not complete";
pub(crate) const CHUNK_BEYOND_END: &str = "a chunk lies beyond the end of the file";
pub(crate) const RECORD_HEADER_TOO_LONG: &str = "a record header is absurdly long";
pub(crate) const RECORD_HEADER_CUT_OFF: &str = "a record header is cut off";
pub(crate) const BAG_WITHOUT_INDEX: &str =
    "the bag has no index because it was not closed; everything in it is used";
pub(crate) const DECOMPRESS_BAG: &str = "unpack the bag with 'rosbag decompress'";
/// In place of the name of a compression that a chunk does not give.
pub(crate) const UNNAMED_COMPRESSION: &str = "nothing it names";
pub(crate) const NO_ROSBAG2_TABLES: &str = "it has no tables 'topics' and 'messages'";

pub(crate) fn record_field_missing(name: &str) -> String {
    format!("a record lacks its field '{name}'")
}
/// A bag without an index that is damaged as well.
pub(crate) fn bag_cut_off(at: u64, size: u64) -> String {
    format!(
        "the bag is cut off or damaged at byte {at} of {size}: everything before that is used; 'rosbag reindex' \
         repairs bags of a recorder that was stopped hard"
    )
}
/// A chunk larger than the reader's limit.
pub(crate) fn chunk_too_large(bytes: u64, max_bytes: u64) -> String {
    format!("a chunk claims to unpack to {bytes} bytes; at most {max_bytes} are read")
}
pub(crate) fn unknown_compression(name: &str) -> String {
    format!("a chunk packed with '{name}'")
}
pub(crate) fn chunk_cut_off(at: u64) -> String {
    format!("the chunk at byte {at} is cut off, the rest of it is lost")
}

// Trajectories and pose graphs.

pub(crate) const TRAJECTORY_LINE_EMPTY: &str = "it is empty";
pub(crate) const TRAJECTORY_LINE_SHORT: &str = "it does not hold 'seconds x y z qx qy qz qw'";

pub(crate) fn not_a_time(word: &str) -> String {
    let word = shown(word);
    format!("'{word}' is not a time in seconds")
}
pub(crate) fn unknown_graph_element(word: &str) -> String {
    let word = shown(word);
    format!("'{word}' is not a pose, an edge between poses or FIX")
}
pub(crate) fn not_a_vertex(word: &str) -> String {
    let word = shown(word);
    format!("'{word}' is not the number of a vertex")
}

// Surveys: LAS, LAZ, E57 and PTX.

pub(crate) const MAKE_SURVEY_SMALLER: &str =
    "thin it in the program that made it, to a point every 2 or 3 cm, or cut it into parts";
/// A survey with more points than are read.
pub(crate) fn too_many_points(most: usize) -> String {
    format!("a survey of more than {most} points")
}
pub(crate) const NO_SURVEY_FORMAT: &str =
    "it begins like no PCD, PLY, LAS, LAZ, E57 or PTX file; convert it to one of them";
pub(crate) const COMPRESSED_DATA_DAMAGED: &str = "its compressed data is damaged; copy or export it again";
/// Place of damage that a library does not give.
pub(crate) const UNKNOWN_PLACE: &str = "an unknown place";
/// Place of damage while a library decodes points.
pub(crate) const COMPRESSED_POINTS: &str = "its compressed points";
/// Place of damage while a library reads an E57 file.
pub(crate) const WHILE_READING: &str = "reading it";
pub(crate) const UNNAMED_SCAN: &str = "without a name";
/// All values of an E57 scan are constants of zero bits, so that the file could announce any number of points.
pub(crate) const SCAN_WITHOUT_DATA: &str =
    "all of its values are constant, so its points have no coordinates";
pub(crate) const SCALE_NOT_FINITE: &str = "the scale or the offset of the coordinates is no number";
pub(crate) const NO_LASZIP_RECORD: &str = "nothing says how its points are compressed";
pub(crate) const SAVE_AS_OTHER_LAS: &str = "save it as LAS, or as LAZ of version 1.2";
pub(crate) const LAS_POINT_UNWRITABLE: &str =
    "a point is not finite, or over 2,147 km from the middle of the others";
pub(crate) const SEEK_BEFORE_START: &str = "before the start of the file";
pub(crate) const PTX_LINE_TOO_LONG: &str = "the line is longer than any of this format";
pub(crate) const PTX_COUNT_EXPECTED: &str = "a count of columns or rows was expected";
pub(crate) const PTX_MATRIX_INVALID: &str = "the matrix is not a rotation and a translation";
pub(crate) const PTX_POINT_EXPECTED: &str = "a point's three coordinates were expected";

/// A library's error, with what to do.
pub(crate) fn library_error(error: impl Display) -> String {
    format!("{error}; copy or export it again")
}
pub(crate) fn scan_place(name: &str) -> String {
    format!("scan '{name}'")
}
pub(crate) fn points_begin_in_header(at: u64) -> String {
    format!("points cannot begin at byte {at}")
}
pub(crate) fn records_too_many(count: u32, bytes: u64) -> String {
    format!("{count} records do not fit into {bytes} bytes")
}
pub(crate) fn point_too_small(bytes: usize) -> String {
    format!("a point cannot have {bytes} bytes")
}
pub(crate) fn laszip_record_differs(point_bytes: usize) -> String {
    format!("it does not describe points of {point_bytes} bytes")
}
pub(crate) fn chunks_impossible(chunks: u64, points: u64) -> String {
    format!("{chunks} chunks of {points} points are impossible")
}
pub(crate) fn unknown_laz(error: impl Display) -> String {
    format!("this kind of LAZ file ({error})")
}
pub(crate) fn numbers_expected(count: usize) -> String {
    format!("{count} numbers were expected")
}

// Pictures.

pub(crate) const NO_PICTURE: &str = "it is neither a JPEG nor a PNG nor a BMP file";
pub(crate) const PICTURE_CUT_SHORT: &str = "the end of the picture is missing";
pub(crate) const OTHER_BMP: &str =
    "it is a BMP file without a size, or not of 24 or 32 bits without compression";
pub(crate) const OTHER_SAMPLING: &str = "it has more of a colour than of brightness, which no camera writes";
pub(crate) const NO_PICTURE_SIZE: &str = "it has no size";
pub(crate) const PICTURE_TOO_LARGE: &str = "its size is larger than its bytes can hold";
