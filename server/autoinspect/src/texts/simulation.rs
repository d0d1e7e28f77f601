//! Errors of `autoinspect sim`.

use std::fmt::Display;

/// A site without this route.
pub fn no_such_route(site: &dyn Display, route: &str, routes: &[&str]) -> String {
    if routes.is_empty() {
        return format!("{site} has no routes; write one into its .site.json");
    }
    format!("{site} has no route '{route}'; it has {}", routes.join(", "))
}

/// A fault that cannot be parsed.
pub fn invalid_fault(text: &str) -> String {
    format!(
        "'{text}' is no fault; write blind-lidar@60-80, silent-lidar@…, silent-imu@… or leg-slip@30-40:0.2,0,0"
    )
}
