//! The actions that come with the platform: one table for the robot, which performs them, and for clients, which draw their forms from the schemas. Further
//! actions are registered while the robot runs, with the same description.
//!
//! Schemas are JSON Schema (draft 2020-12), of one object with plain properties. The name of a property ends with its unit. `title` is the caption of the field,
//! `description` its hint, and `unit` the unit of its value; forms show degrees for `rad`. `object` says that the text is the id of an object of the site of this kind.
//! Properties with `readOnly` are set by the platform: forms leave them out.
//! Limits of pan, tilt and zoom are those of the camera head of the robot's profile: their names stand in the text of the catalogue.

use crate::{Parameter, Parameters};
use vocab::CameraHead;

/// Longest text of a message, characters.
pub const MAX_MESSAGE_CHARS: u32 = 200;

/// What is known of an action before it is called.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActionDescription {
    /// Name under which it is registered.
    pub name: &'static str,
    /// Shown to people.
    pub title: &'static str,
    /// JSON Schema of its parameters, with names in place of the limits of the camera head.
    schema_text: &'static str,
    /// How long it is expected to take besides the duration that its parameters give, seconds.
    pub expected_s: f64,
    /// The parameter that is a duration, seconds, and its default. It is added to the expected time.
    pub duration: Option<(&'static str, f64)>,
    /// Power that it is expected to take besides what the standing robot takes, watts. Chosen: of common instruments.
    pub power_w: f64,
    /// Whether it can be repeated without harm.
    pub is_idempotent: bool,
    /// Whether it moves the robot to where it ends. Then its task has no place ([`crate::TaskPlace::ByAction`]), and it is done in tasks only.
    pub moves_robot: bool,
}

/// Parameter that tells what an action is aimed at, metres, map frame. The platform sets it from the inspection point.
pub const TARGET_PARAMETER: &str = "target_m";

impl ActionDescription {
    /// JSON Schema of its parameters on a robot with this camera head.
    pub fn parameter_schema(&self, head: &CameraHead) -> String {
        let limits = [
            ("PAN_MIN", -head.pan_max_rad),
            ("PAN_MAX", head.pan_max_rad),
            ("TILT_MIN", head.tilt_min_rad),
            ("TILT_MAX", head.tilt_max_rad),
            ("ZOOM_MAX", head.zoom_max),
        ];
        let with = |text: String, (name, limit): (&str, f64)| text.replace(name, &limit.to_string());
        limits.into_iter().fold(self.schema_text.to_owned(), with)
    }

    /// Whether it is aimed at something.
    pub fn takes_target(&self) -> bool {
        self.schema_text.contains("\"target_m\"")
    }

    /// Whether a gauge is read in what it gathers.
    pub fn takes_gauge(&self) -> bool {
        self.schema_text.contains("\"gauge\"")
    }

    /// How long it is expected to take with these parameters, seconds.
    pub fn expected_time_s(&self, parameters: &Parameters) -> f64 {
        let duration_s = self.duration.map_or(0.0, |(name, default_s)| match parameters.get(name) {
            Some(Parameter::Number(given_s)) => given_s.max(0.0),
            Some(Parameter::Integer(given_s)) => (*given_s as f64).max(0.0),
            _ => default_s,
        });
        self.expected_s + duration_s
    }

    /// Energy that it is expected to take with these parameters, besides what the standing robot takes, joules.
    pub fn expected_energy_j(&self, parameters: &Parameters) -> f64 {
        self.power_w * self.expected_time_s(parameters)
    }
}

/// The actions that come with the platform, in the order of menus.
pub const ACTION_CATALOGUE: &[ActionDescription] = &[
    ActionDescription {
        name: "photo",
        title: "Photo",
        schema_text: r#"{
            "type": "object",
            "properties": {
                "gauge": { "type": "object", "readOnly": true,
                    "title": "Gauge", "description": "Its needle is read in the picture. That of the inspection point." },
                "pan_rad": { "type": "number", "title": "Pan", "unit": "rad", "minimum": PAN_MIN, "maximum": PAN_MAX,
                    "description": "To the left. Not used where the task has a target." },
                "target_m": { "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3, "readOnly": true,
                    "title": "Target", "unit": "m", "description": "Map frame. That of the inspection point." },
                "tilt_rad": { "type": "number", "title": "Tilt", "unit": "rad", "minimum": TILT_MIN, "maximum": TILT_MAX,
                    "description": "Upwards. Not used where the task has a target." },
                "zoom": { "type": "number", "title": "Zoom", "minimum": 1, "maximum": ZOOM_MAX, "default": 1 }
            },
            "additionalProperties": false
        }"#,
        expected_s: 6.0,
        duration: None,
        power_w: 10.0,
        is_idempotent: true,
        moves_robot: false,
    },
    ActionDescription {
        name: "thermal_photo",
        title: "Thermal photo",
        schema_text: r#"{
            "type": "object",
            "properties": {
                "pan_rad": { "type": "number", "title": "Pan", "unit": "rad", "minimum": PAN_MIN, "maximum": PAN_MAX,
                    "description": "To the left. Not used where the task has a target." },
                "target_m": { "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3, "readOnly": true,
                    "title": "Target", "unit": "m", "description": "Map frame. That of the inspection point." },
                "tilt_rad": { "type": "number", "title": "Tilt", "unit": "rad", "minimum": TILT_MIN, "maximum": TILT_MAX,
                    "description": "Upwards. Not used where the task has a target." }
            },
            "additionalProperties": false
        }"#,
        expected_s: 6.0,
        duration: None,
        power_w: 10.0,
        is_idempotent: true,
        moves_robot: false,
    },
    ActionDescription {
        name: "point_cloud",
        title: "Point cloud",
        schema_text: r#"{
            "type": "object",
            "properties": {
                "duration_s": { "type": "number", "title": "Duration", "unit": "s", "minimum": 0.1, "maximum": 60, "default": 2 }
            },
            "additionalProperties": false
        }"#,
        expected_s: 1.0,
        duration: Some(("duration_s", 2.0)),
        power_w: 0.0,
        is_idempotent: true,
        moves_robot: false,
    },
    ActionDescription {
        name: "temperature_humidity",
        title: "Temp. and humidity",
        schema_text: r#"{
            "type": "object",
            "properties": {
                "duration_s": { "type": "number", "title": "Averaged over", "unit": "s", "minimum": 1, "maximum": 600, "default": 5 }
            },
            "additionalProperties": false
        }"#,
        expected_s: 1.0,
        duration: Some(("duration_s", 5.0)),
        power_w: 1.0,
        is_idempotent: true,
        moves_robot: false,
    },
    ActionDescription {
        name: "gamma_spectrum",
        title: "Gamma spectrum",
        schema_text: r#"{
            "type": "object",
            "properties": {
                "duration_s": { "type": "number", "title": "Counting time", "unit": "s", "minimum": 1, "maximum": 3600, "default": 60 }
            },
            "additionalProperties": false
        }"#,
        expected_s: 2.0,
        duration: Some(("duration_s", 60.0)),
        power_w: 5.0,
        is_idempotent: true,
        moves_robot: false,
    },
    ActionDescription {
        name: "wait",
        title: "Wait",
        schema_text: r#"{
            "type": "object",
            "properties": {
                "duration_s": { "type": "number", "title": "Time", "unit": "s", "minimum": 1, "maximum": 86400, "default": 10 }
            },
            "additionalProperties": false
        }"#,
        expected_s: 0.0,
        duration: Some(("duration_s", 10.0)),
        power_w: 0.0,
        is_idempotent: true,
        moves_robot: false,
    },
    ActionDescription {
        name: "message",
        title: "Message",
        schema_text: r#"{
            "type": "object",
            "properties": {
                "text": { "type": "string", "title": "Text", "minLength": 1, "maxLength": 200,
                    "description": "Shown to all operators." }
            },
            "required": ["text"],
            "additionalProperties": false
        }"#,
        expected_s: 1.0,
        duration: None,
        power_w: 0.0,
        // Whoever reads it twice may act twice.
        is_idempotent: false,
        moves_robot: false,
    },
    ActionDescription {
        name: "dock",
        title: "Dock",
        schema_text: r#"{
            "type": "object",
            "properties": {
                "charge_until_percent": { "type": "number", "title": "Charge until", "unit": "percent", "minimum": 1, "maximum": 100,
                    "description": "Empty: the robot goes on as soon as it is charged." },
                "dock": { "type": "string", "title": "Dock", "format": "uuid", "object": "dock",
                    "description": "Empty: the nearest one that can be reached." }
            },
            "additionalProperties": false
        }"#,
        // From the node in front of the dock: aligning, walking in, and the first charging current. Charging comes on top, by the charge that is left.
        expected_s: 15.0,
        duration: None,
        power_w: 0.0,
        // A robot that is in the dock stays there.
        is_idempotent: true,
        moves_robot: true,
    },
    ActionDescription {
        name: "undock",
        title: "Undock",
        schema_text: r#"{ "type": "object", "properties": {}, "additionalProperties": false }"#,
        expected_s: 5.0,
        duration: None,
        power_w: 0.0,
        is_idempotent: true,
        moves_robot: true,
    },
];

/// The actions of the catalogue that are done at a place, in the order of menus: all but those that move the robot, which are the last.
pub fn actions_at_places() -> &'static [ActionDescription] {
    let count = ACTION_CATALOGUE.iter().take_while(|action| !action.moves_robot).count();
    &ACTION_CATALOGUE[..count]
}

/// The description of an action; none if the platform does not come with it.
pub fn describe_action(name: &str) -> Option<&'static ActionDescription> {
    ACTION_CATALOGUE.iter().find(|action| action.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    fn schema(action: &ActionDescription) -> Value {
        serde_json::from_str(&action.parameter_schema(&CameraHead::COMMON)).expect(action.name)
    }

    #[test]
    fn every_schema_is_of_one_object_with_plain_properties_and_defaults_within_their_range() {
        for (index, action) in ACTION_CATALOGUE.iter().enumerate() {
            assert_eq!(ACTION_CATALOGUE.iter().position(|it| it.name == action.name), Some(index), "unique");
            let schema = schema(action);
            assert_eq!((&schema["type"], &schema["additionalProperties"]), (&"object".into(), &false.into()));
            for (name, property) in schema["properties"].as_object().expect(action.name) {
                assert!(property["title"].is_string(), "{}: {name} has a title", action.name);
                let unit = property["unit"].as_str();
                assert!(
                    unit.is_none_or(|unit| name.ends_with(&format!("_{unit}"))),
                    "{name} ends with its unit"
                );
                if let Some(default) = property["default"].as_f64() {
                    let within = property["minimum"].as_f64().is_none_or(|min| default >= min)
                        && property["maximum"].as_f64().is_none_or(|max| default <= max);
                    assert!(within, "{}: {name}", action.name);
                }
            }
        }
    }

    #[test]
    fn pictures_can_be_asked_for_within_the_reach_of_the_camera_head() {
        let fixed = CameraHead {
            pan_max_rad: 0.0,
            tilt_min_rad: 0.0,
            tilt_max_rad: 0.0,
            zoom_max: 1.0,
            ..CameraHead::COMMON
        };
        for head in [CameraHead::COMMON, fixed] {
            let properties = |name: &str| {
                let text = describe_action(name).expect("listed").parameter_schema(&head);
                serde_json::from_str::<Value>(&text).expect(name)["properties"].clone()
            };
            for name in ["photo", "thermal_photo"] {
                let of_action = properties(name);
                let limits =
                    |property: &str| ["minimum", "maximum"].map(|limit| of_action[property][limit].as_f64());
                assert_eq!(limits("pan_rad"), [Some(-head.pan_max_rad), Some(head.pan_max_rad)], "{name}");
                assert_eq!(limits("tilt_rad"), [Some(head.tilt_min_rad), Some(head.tilt_max_rad)], "{name}");
            }
            assert_eq!(properties("photo")["zoom"]["maximum"].as_f64(), Some(head.zoom_max));
        }
    }

    #[test]
    fn actions_that_move_the_robot_are_the_last() {
        assert!(actions_at_places().iter().all(|action| !action.moves_robot));
        assert!(ACTION_CATALOGUE[actions_at_places().len()..].iter().all(|action| action.moves_robot));
    }

    #[test]
    fn the_duration_is_a_property_and_has_the_default_of_the_schema() {
        for action in ACTION_CATALOGUE {
            if let Some((name, default_s)) = action.duration {
                assert_eq!(schema(action)["properties"][name]["default"].as_f64(), Some(default_s));
            }
        }
        let schema = schema(describe_action("message").expect("listed"));
        assert_eq!(schema["properties"]["text"]["maxLength"], MAX_MESSAGE_CHARS);
    }

    #[test]
    fn the_expected_time_includes_the_duration_that_is_asked_for() {
        let gamma = describe_action("gamma_spectrum").expect("listed");
        assert_eq!(gamma.expected_time_s(&Parameters::new()), 62.0);
        assert_eq!(gamma.expected_energy_j(&Parameters::new()), 5.0 * 62.0);
        let of = |value| Parameters::from([("duration_s".to_owned(), value)]);
        assert_eq!(gamma.expected_time_s(&of(Parameter::Integer(120))), 122.0);
        assert_eq!(gamma.expected_time_s(&of(Parameter::Number(0.5))), 2.5);
        assert_eq!(
            describe_action("photo").expect("listed").expected_time_s(&of(Parameter::Integer(9))),
            6.0
        );
    }
}
