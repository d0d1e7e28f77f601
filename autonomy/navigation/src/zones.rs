//! Areas of the ground with a rule: keep out, a speed limit, a penalty. They hold for the middle of the robot, not for its whole footprint.

/// What holds in an area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ZoneRule {
    /// Paths do not enter it.
    KeepOut,
    /// Greatest speed, m/s.
    SpeedLimit(f64),
    /// Factor on the cost of paths, at least 1.
    Penalty(f64),
}

/// An area, in the frame of the elevation map.
#[derive(Clone, Debug, PartialEq)]
pub struct ZoneArea {
    /// Corners, metres, in either sense of rotation.
    pub corners_m: Vec<[f64; 2]>,
    /// What holds in it.
    pub rule: ZoneRule,
}

impl ZoneArea {
    /// Whether a point is inside. Linear in the corners.
    pub fn contains(&self, point: [f64; 2]) -> bool {
        vocab::is_in_polygon(&self.corners_m, point)
    }
}

/// All areas. Each look-up is linear in their corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroundZones {
    areas: Vec<ZoneArea>,
}

impl GroundZones {
    /// These areas.
    pub fn new(areas: Vec<ZoneArea>) -> Self {
        Self { areas }
    }

    /// Whether a point lies in an area that is kept out of.
    pub fn is_kept_out(&self, point: [f64; 2]) -> bool {
        self.rules_at(point).any(|rule| rule == ZoneRule::KeepOut)
    }

    /// Factor by which ground costs more, the greatest of all areas; none where paths do not lead.
    pub fn cost_factor(&self, point: [f64; 2]) -> Option<f64> {
        self.rules_at(point).try_fold(1.0, |greatest: f64, rule| match rule {
            ZoneRule::KeepOut => None,
            ZoneRule::Penalty(factor) => Some(greatest.max(factor)),
            ZoneRule::SpeedLimit(_) => Some(greatest),
        })
    }

    /// The lowest speed limit at a point, m/s.
    pub fn speed_limit_m_s(&self, point: [f64; 2]) -> Option<f64> {
        let limits = self.rules_at(point).filter_map(|rule| match rule {
            ZoneRule::SpeedLimit(limit) => Some(limit),
            ZoneRule::KeepOut | ZoneRule::Penalty(_) => None,
        });
        limits.min_by(f64::total_cmp)
    }

    fn rules_at(&self, point: [f64; 2]) -> impl Iterator<Item = ZoneRule> {
        self.areas.iter().filter(move |area| area.contains(point)).map(|area| area.rule)
    }
}
