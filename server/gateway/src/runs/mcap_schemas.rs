//! JSON Schemas of the messages in the MCAP file of a run. Those of `foxglove.` describe the fields that Foxglove's schemas of these names have.

use recorder::JsonSchema;

/// A picture in a file format. Source: fields of `foxglove.CompressedImage` (docs.foxglove.dev, schemas).
pub(super) const COMPRESSED_IMAGE: JsonSchema = JsonSchema {
    name: "foxglove.CompressedImage",
    text: r#"{"title": "foxglove.CompressedImage", "type": "object", "properties": {
  "timestamp": {"type": "object", "title": "time", "properties": {"sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0, "maximum": 999999999}}},
  "frame_id": {"type": "string"},
  "data": {"type": "string", "contentEncoding": "base64"},
  "format": {"type": "string"}}}"#,
};

/// A pose in a frame. Source: fields of `foxglove.PoseInFrame` (docs.foxglove.dev, schemas).
pub(super) const POSE_IN_FRAME: JsonSchema = JsonSchema {
    name: "foxglove.PoseInFrame",
    text: r#"{"title": "foxglove.PoseInFrame", "type": "object", "properties": {
  "timestamp": {"type": "object", "title": "time", "properties": {"sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0, "maximum": 999999999}}},
  "frame_id": {"type": "string"},
  "pose": {"title": "foxglove.Pose", "type": "object", "properties": {
    "position": {"title": "foxglove.Vector3", "type": "object", "properties": {"x": {"type": "number"}, "y": {"type": "number"}, "z": {"type": "number"}}},
    "orientation": {"title": "foxglove.Quaternion", "type": "object", "properties": {"x": {"type": "number"}, "y": {"type": "number"}, "z": {"type": "number"}, "w": {"type": "number"}}}}}}}"#,
};

/// A number that was measured.
pub(super) const READING: JsonSchema = JsonSchema {
    name: "autoinspect.Reading",
    text: r#"{"title": "autoinspect.Reading", "type": "object", "properties": {
  "timestamp": {"type": "object", "title": "time", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
  "place": {"type": "string"}, "name": {"type": "string"}, "value": {"type": "number"},
  "standard_deviation": {"type": ["number", "null"]}, "unit": {"type": "string"}}}"#,
};

/// A gamma spectrum: events by channel, from `first_kev` in steps of `channel_kev`.
pub(super) const SPECTRUM: JsonSchema = JsonSchema {
    name: "autoinspect.GammaSpectrum",
    text: r#"{"title": "autoinspect.GammaSpectrum", "type": "object", "properties": {
  "timestamp": {"type": "object", "title": "time", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
  "place": {"type": "string"},
  "spectrum": {"type": "object", "properties": {"live_time_s": {"type": "number"}, "first_kev": {"type": "number"},
    "channel_kev": {"type": "number"}, "counts": {"type": "array", "items": {"type": "integer"}}}}}}"#,
};

/// A result as the ledger has it.
pub(super) const RESULT: JsonSchema = JsonSchema {
    name: "autoinspect.Result",
    text: r#"{"title": "autoinspect.Result", "type": "object", "properties": {
  "timestamp": {"type": "object", "title": "time", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
  "number": {"type": "integer"}, "step": {"type": "integer"}, "attempt": {"type": "integer"},
  "action": {"type": "string"}, "place": {"type": "string"}, "details": {"type": ["object", "null"]}}}"#,
};

/// An alert as it is when the file is made.
pub(super) const ALERT: JsonSchema = JsonSchema {
    name: "autoinspect.Alert",
    text: r#"{"title": "autoinspect.Alert", "type": "object", "properties": {
  "timestamp": {"type": "object", "title": "time", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
  "severity": {"type": "string"}, "alert": {"type": "object"}}}"#,
};
