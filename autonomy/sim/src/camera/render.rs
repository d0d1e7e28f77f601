//! Rays of a whole picture: what each pixel sees, and the light that comes from there.
//!
//! Eight pixels of a row are one packet of rays. Shadows are packets from there to the strongest lamps. Pixels on edges get two more rays each.

use super::lamps::{LAMP_HALF_M, LocalLight, SHADOWED, Sun};
use super::optics::Intrinsics;
use super::surfaces::{Finish, finish, hash};
use super::{CameraScene, faces, lamps, leaks};
use crate::people::{PERSON_BIT, People};
use crate::ray_packet::{ENDED, LANES, Lane, NO_HIT, RayPacket};
use crate::shape::Material;
use geometry::{Isometry, Vector3};

/// Greatest range, metres.
const MAX_RANGE_M: f32 = 150.0;
/// Panes of glass that a ray passes.
const MAX_PANES: usize = 3;
/// Share of light that passes a pane.
const PANE_LIGHT: f32 = 0.85;
/// Light from all sides, on surfaces that look up.
const AMBIENT_UP: f32 = 0.16;
/// Light from all sides, on surfaces that look down.
const AMBIENT_DOWN: f32 = 0.08;
/// Share of the light of lamps of which no shadow is cast.
const UNSHADOWED: f32 = 0.5;
/// Exponent of highlights.
const HIGHLIGHT: i32 = 24;
/// A lamp of which less light than this share of the ambient light would fall on a surface casts no shadow there.
const MIN_SHADOW: f32 = 0.3;
/// Offset of shadow rays from their surface, metres.
const OFFSET_M: f32 = 2e-3;
/// A lamp list is shared by points that are nearer to each other than this, metres.
const SHARED_LIGHT_M: f32 = 0.3;
/// Light of the sky, linear.
const SKY: [f32; 3] = [0.75, 0.95, 1.3];
/// Positions of the further rays of a pixel on an edge, in the pixel.
const EDGE_SUBPIXELS: [[f32; 2]; 2] = [[0.2, 0.3], [0.8, 0.7]];
/// Two surfaces make an edge if their light differs by more than this share.
const EDGE_CONTRAST: f32 = 0.08;
/// Positions in a pixel over which letters are averaged (rotated grid).
const SUBPIXELS: [[f32; 2]; 4] = [[0.375, 0.125], [0.875, 0.375], [0.625, 0.875], [0.125, 0.625]];

/// A camera in a scene at one instant.
pub(super) struct CameraView<'a> {
    pub(super) scene: &'a CameraScene,
    pub(super) people: &'a People,
    /// Pose of the camera: x right, y down, z ahead.
    pub(super) site_from_camera: &'a Isometry,
    pub(super) intrinsics: &'a Intrinsics,
    /// Time since the start of the simulation, seconds.
    pub(super) seconds: f64,
    /// Decides where on its lamps the shadow rays of a pixel end: another one for each picture, so that the grain of soft shadows is as different as noise is.
    pub(super) grain: u32,
}

/// What a ray has met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum HitTarget {
    Nothing,
    Solid(Material),
    Person(Material),
    /// A fixture, and the point of its plate, metres.
    Plate(usize, [f32; 2]),
}

/// The end of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceHit {
    pub(super) target: HitTarget,
    /// Site frame, metres.
    pub(super) point: [f32; 3],
    /// Towards the camera.
    pub(super) normal: [f32; 3],
    direction: [f32; 3],
    /// Number that differs on the two sides of an edge.
    surface: u32,
    /// Share of light that has passed panes of glass.
    light: f32,
}

impl SurfaceHit {
    const NOTHING: Self = Self {
        target: HitTarget::Nothing,
        point: [0.0; 3],
        normal: [0.0; 3],
        direction: [0.0; 3],
        surface: u32::MAX,
        light: 1.0,
    };
}

/// A plate that may be in the picture.
struct VisiblePlate {
    fixture: usize,
    /// Least and greatest pixel of its bounding rectangle.
    min_px: [f32; 2],
    max_px: [f32; 2],
    middle: [f32; 3],
    right: [f32; 3],
    up: [f32; 3],
    outward: [f32; 3],
    half: [f32; 2],
}

/// Points of the picture, pixels. Packets hold neighbouring ones.
type Points = [[f32; 2]; LANES];

impl CameraView<'_> {
    /// Linear light of every pixel, row by row.
    pub(super) fn light(&self) -> Vec<[f32; 3]> {
        let plates = self.visible_plates();
        let [width, height] = [self.intrinsics.width_px, self.intrinsics.height_px].map(|n| n as usize);
        let mut light = vec![[0.0; 3]; width * height];
        let mut surfaces = vec![u32::MAX; width * height];
        self.for_each_packet(|first, points| {
            let hits = self.hits(points, &plates);
            let shaded = self.shade(&hits, points);
            let count = LANES.min(width - first % width);
            light[first..first + count].copy_from_slice(&shaded[..count]);
            for lane in 0..count {
                surfaces[first + lane] = hits[lane].surface;
            }
        });
        let edges = edges(&surfaces, &light, width);
        for group in edges.chunks(LANES / EDGE_SUBPIXELS.len()) {
            let points: Points = std::array::from_fn(|lane| {
                let pixel = group[(lane / EDGE_SUBPIXELS.len()).min(group.len() - 1)];
                let [x, y] = [pixel % width, pixel / width].map(|n| n as f32);
                let [dx, dy] = EDGE_SUBPIXELS[lane % EDGE_SUBPIXELS.len()];
                [x + dx, y + dy]
            });
            let shaded = self.shade(&self.hits(&points, &plates), &points);
            for (pixel, rays) in group.iter().zip(shaded.chunks(EDGE_SUBPIXELS.len())) {
                let sum = rays.iter().fold(light[*pixel], |sum, ray| [0, 1, 2].map(|i| sum[i] + ray[i]));
                light[*pixel] = sum.map(|c| c / (1 + rays.len()) as f32);
            }
        }
        light
    }

    /// What the middle of every pixel sees, row by row.
    pub(super) fn targets(&self, mut visit: impl FnMut(usize, &SurfaceHit)) {
        let plates = self.visible_plates();
        let width = self.intrinsics.width_px as usize;
        self.for_each_packet(|first, points| {
            let hits = self.hits(points, &plates);
            for lane in 0..LANES.min(width - first % width) {
                visit(first + lane, &hits[lane]);
            }
        });
    }

    /// Calls `visit` with the first pixel and the middles of eight pixels of a row; those beyond the last column repeat it.
    fn for_each_packet(&self, mut visit: impl FnMut(usize, &Points)) {
        let [width, height] = [self.intrinsics.width_px as usize, self.intrinsics.height_px as usize];
        for row in 0..height {
            for column in (0..width).step_by(LANES) {
                let points = std::array::from_fn(|lane| {
                    [(column + lane).min(width - 1) as f32 + 0.5, row as f32 + 0.5]
                });
                visit(row * width + column, &points);
            }
        }
    }

    /// The plates that face the camera and are in front of it.
    fn visible_plates(&self) -> Vec<VisiblePlate> {
        let camera_from_site = self.site_from_camera.inverse();
        let eye = self.site_from_camera.translation.vector;
        let size = [self.intrinsics.width_px as f32, self.intrinsics.height_px as f32];
        let visible = self.scene.fixtures.iter().enumerate().filter_map(|(fixture, it)| {
            let middle = it.site_from_plate.translation.vector;
            let [right, up, outward] =
                [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| it.site_from_plate.rotation * axis);
            if (eye - middle).dot(&outward) <= 0.0 {
                return None;
            }
            let half = it.face.half_m();
            let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)].map(|(x, y)| {
                let corner = middle + right * (half[0] * x) + up * (half[1] * y);
                self.intrinsics.project(&(camera_from_site * nalgebra::Point3::from(corner)).coords)
            });
            let in_front = corners.iter().flatten().count();
            let (min_px, max_px) = match in_front {
                0 => return None,
                4 => bounding_rectangle(corners.into_iter().flatten()),
                // It reaches behind the camera: anywhere in the picture.
                _ => ([0.0; 2], size),
            };
            let is_inside = (0..2).all(|axis| max_px[axis] >= 0.0 && min_px[axis] <= size[axis]);
            let narrow = |v: Vector3| [v.x as f32, v.y as f32, v.z as f32];
            is_inside.then(|| VisiblePlate {
                fixture,
                min_px,
                max_px,
                middle: narrow(middle),
                right: narrow(right),
                up: narrow(up),
                outward: narrow(outward),
                half: half.map(|h| h as f32),
            })
        });
        visible.collect()
    }

    /// What is seen at these points of the picture.
    fn hits(&self, points: &Points, plates: &[VisiblePlate]) -> [SurfaceHit; LANES] {
        let eye = self.site_from_camera.translation.vector;
        let origin = [[eye.x as f32; LANES], [eye.y as f32; LANES], [eye.z as f32; LANES]];
        let direction = self.directions(points);
        let mut hits = [SurfaceHit::NOTHING; LANES];
        let mut packet = RayPacket::new(origin, direction, MAX_RANGE_M);
        let mut passed = [0.0_f32; LANES];
        for pane in 0..=MAX_PANES {
            self.scene.site.bvh().cast(&mut packet);
            self.people.cast(&mut packet);
            let mut behind = [ENDED; LANES];
            for lane in 0..LANES {
                if packet.solid[lane] == NO_HIT {
                    continue;
                }
                let hit = self.hit(&packet, lane);
                if hit.target == HitTarget::Solid(Material::Glass) && pane < MAX_PANES {
                    passed[lane] += packet.range[lane] + OFFSET_M;
                    behind[lane] = MAX_RANGE_M - passed[lane];
                    hits[lane].light *= PANE_LIGHT;
                } else {
                    hits[lane] = SurfaceHit { light: hits[lane].light, ..hit };
                    passed[lane] += packet.range[lane];
                }
            }
            if behind.iter().all(|range| *range <= 0.0) {
                break;
            }
            let advanced = [0, 1, 2].map(|axis| {
                std::array::from_fn(|lane| origin[axis][lane] + direction[axis][lane] * passed[lane])
            });
            packet = RayPacket::new(advanced, direction, MAX_RANGE_M);
            packet.range = behind;
        }
        for lane in 0..LANES {
            hits[lane].direction = [0, 1, 2].map(|axis| direction[axis][lane]);
        }
        self.hang_plates(points, plates, &origin, &mut hits);
        hits
    }

    /// Unit vectors, site frame.
    fn directions(&self, points: &Points) -> [Lane; 3] {
        let rotation = self.site_from_camera.rotation.to_rotation_matrix().into_inner().cast::<f32>();
        let focal = self.intrinsics.focal_px as f32;
        let centre = self.intrinsics.centre_px.map(|c| c as f32);
        let mut direction = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let [x, y] = [0, 1].map(|axis| (points[lane][axis] - centre[axis]) / focal);
            let length = (x * x + y * y + 1.0).sqrt();
            for axis in 0..3 {
                let row = [rotation[(axis, 0)], rotation[(axis, 1)], rotation[(axis, 2)]];
                direction[axis][lane] = (row[0] * x + row[1] * y + row[2]) / length;
            }
        }
        direction
    }

    fn hit(&self, packet: &RayPacket, lane: usize) -> SurfaceHit {
        let point = packet.end(lane);
        let solid = packet.solid[lane];
        let direction = [0, 1, 2].map(|axis| packet.direction[axis][lane]);
        let (normal, target) = if solid & PERSON_BIT != 0 {
            let (normal, material) = self.people.surface(solid, point);
            (normal, HitTarget::Person(material))
        } else {
            let bvh = self.scene.site.bvh();
            (bvh.normal(solid, point), HitTarget::Solid(bvh.solids()[solid as usize].material))
        };
        // Triangles are seen from both sides.
        let normal = if dot(normal, direction) > 0.0 { normal.map(|c| -c) } else { normal };
        let facing = normal.map(|c| (c * 2.0).round() as i32 as u32);
        SurfaceHit {
            target,
            point,
            normal,
            direction,
            surface: hash([solid, facing[0] ^ (facing[1] << 8), facing[2]]),
            light: 1.0,
        }
    }

    /// Replaces hits by plates in front of them.
    fn hang_plates(
        &self,
        points: &Points,
        plates: &[VisiblePlate],
        origin: &[Lane; 3],
        hits: &mut [SurfaceHit; LANES],
    ) {
        for plate in plates {
            for lane in 0..LANES {
                let px = points[lane];
                if (0..2).any(|axis| px[axis] < plate.min_px[axis] || px[axis] > plate.max_px[axis]) {
                    continue;
                }
                let direction = hits[lane].direction;
                let eye = [0, 1, 2].map(|axis| origin[axis][lane]);
                let offset = subtract(plate.middle, eye);
                let range = dot(offset, plate.outward) / dot(direction, plate.outward);
                let hit = &mut hits[lane];
                let behind = match hit.target {
                    HitTarget::Nothing => MAX_RANGE_M,
                    _ => length(subtract(hit.point, eye)),
                };
                if !(range > 0.0 && range < behind) {
                    continue;
                }
                let point = [0, 1, 2].map(|axis| eye[axis] + direction[axis] * range);
                let from_middle = subtract(point, plate.middle);
                let on_plate = [dot(from_middle, plate.right), dot(from_middle, plate.up)];
                if on_plate[0].abs() > plate.half[0] || on_plate[1].abs() > plate.half[1] {
                    continue;
                }
                *hit = SurfaceHit {
                    target: HitTarget::Plate(plate.fixture, on_plate),
                    point,
                    normal: plate.outward,
                    surface: NO_HIT - 1 - plate.fixture as u32,
                    ..*hit
                };
            }
        }
    }

    /// Linear light of hits.
    fn shade(&self, hits: &[SurfaceHit; LANES], points: &Points) -> [[f32; 3]; LANES] {
        let mut local: [Option<LocalLight>; LANES] = [None; LANES];
        for lane in 0..LANES {
            if hits[lane].target == HitTarget::Nothing {
                continue;
            }
            let near = lane > 0 && length(subtract(hits[lane].point, hits[lane - 1].point)) < SHARED_LIGHT_M;
            local[lane] = match local[lane.saturating_sub(1)] {
                Some(light) if near => Some(light),
                _ => Some(self.scene.lamps.at(hits[lane].point)),
            };
        }
        // Light that falls on each surface, and its highlight.
        let mut fallen = [[0.0_f32; 2]; LANES];
        for number in 0..SHADOWED {
            self.add_lamps(number, hits, points, &local, &mut fallen);
        }
        if let Some(sun) = self.scene.lamps.sun() {
            self.add_sun(&sun, hits, &mut fallen);
        }
        std::array::from_fn(|lane| {
            let hit = &hits[lane];
            let Some(light) = &local[lane] else { return SKY.map(|c| c * hit.light) };
            let Finish { albedo, gloss } = self.finish(hit);
            let up = 0.5 + 0.5 * hit.normal[2];
            let ambient = AMBIENT_DOWN + (AMBIENT_UP - AMBIENT_DOWN) * up;
            let rest = UNSHADOWED * dot(light.rest, hit.normal).max(0.0);
            let [diffuse, highlight] = fallen[lane];
            albedo.map(|c| hit.light * (c * (ambient + rest + diffuse) + gloss * highlight))
        })
    }

    fn finish(&self, hit: &SurfaceHit) -> Finish {
        match hit.target {
            HitTarget::Nothing => Finish { albedo: SKY, gloss: 0.0 },
            HitTarget::Solid(material) => {
                leaks::wetted(&self.scene.leaks, finish(material, hit.point), hit.point, hit.normal)
            }
            HitTarget::Person(material) => finish(material, hit.point),
            HitTarget::Plate(fixture, at) => {
                let numbers = &self.scene.scale_numbers[fixture];
                let fixture = &self.scene.fixtures[fixture];
                // The size of a pixel on the plate: letters are averaged over it.
                let eye = self.site_from_camera.translation.vector;
                let eye = [eye.x as f32, eye.y as f32, eye.z as f32];
                let pixel_m = length(subtract(hit.point, eye)) / self.intrinsics.focal_px as f32;
                let mut albedo = [0.0; 3];
                for [dx, dy] in SUBPIXELS {
                    let point = [at[0] + (dx - 0.5) * pixel_m, at[1] + (dy - 0.5) * pixel_m];
                    let colour = faces::colour(fixture, numbers, point, self.seconds);
                    for i in 0..3 {
                        albedo[i] += 0.25 * colour[i];
                    }
                }
                Finish { albedo, gloss: 0.03 }
            }
        }
    }

    /// Adds the light of the lamps that are `number` in strength, unless something is between.
    fn add_lamps(
        &self,
        number: usize,
        hits: &[SurfaceHit; LANES],
        points: &Points,
        local: &[Option<LocalLight>; LANES],
        fallen: &mut [[f32; 2]; LANES],
    ) {
        let mut to_lamp = [[0.0_f32, 0.0, 1.0]; LANES];
        let mut strength = [0.0_f32; LANES];
        let mut range = [ENDED; LANES];
        for lane in 0..LANES {
            let Some((lamp, share)) = local[lane].and_then(|light| light.strongest[number]) else { continue };
            let seed = points[lane].map(f32::to_bits);
            let jitter = [0, 1].map(|axis| {
                let bits = hash([seed[0], seed[1], (2 * number + axis) as u32 ^ self.grain]);
                ((bits >> 8) as f32 / (1 << 23) as f32 - 1.0) * LAMP_HALF_M
            });
            let [x, y, z] = lamp.position;
            let offset = subtract([x + jitter[0], y + jitter[1], z], hits[lane].point);
            let distance = length(offset).max(0.05);
            to_lamp[lane] = offset.map(|c| c / distance);
            let cosine = dot(to_lamp[lane], hits[lane].normal);
            if cosine > 0.0 {
                strength[lane] = share * lamps::strength_at(&lamp, hits[lane].point);
                let is_weak = strength[lane] * cosine < MIN_SHADOW * AMBIENT_DOWN;
                range[lane] = if is_weak { ENDED } else { distance - OFFSET_M };
            }
        }
        self.add_unless_shadowed(hits, &to_lamp, &strength, range, fallen);
    }

    fn add_sun(&self, sun: &Sun, hits: &[SurfaceHit; LANES], fallen: &mut [[f32; 2]; LANES]) {
        let lit = |hit: &SurfaceHit| hit.target != HitTarget::Nothing && dot(hit.normal, sun.to_sun) > 0.0;
        let range = hits.each_ref().map(|hit| if lit(hit) { MAX_RANGE_M } else { ENDED });
        let strength = range.map(|range| if range > 0.0 { sun.strength } else { 0.0 });
        self.add_unless_shadowed(hits, &[sun.to_sun; LANES], &strength, range, fallen);
    }

    fn add_unless_shadowed(
        &self,
        hits: &[SurfaceHit; LANES],
        to_light: &[[f32; 3]; LANES],
        strength: &Lane,
        range: Lane,
        fallen: &mut [[f32; 2]; LANES],
    ) {
        if strength.iter().all(|strength| *strength <= 0.0) {
            return;
        }
        let origin = [0, 1, 2].map(|axis| {
            std::array::from_fn(|lane| hits[lane].point[axis] + hits[lane].normal[axis] * OFFSET_M)
        });
        let direction = [0, 1, 2].map(|axis| std::array::from_fn(|lane| to_light[lane][axis]));
        let mut packet = RayPacket::new(origin, direction, 0.0);
        packet.range = range;
        self.scene.site.bvh().occlude(&mut packet);
        self.people.cast(&mut packet);
        for lane in 0..LANES {
            if strength[lane] <= 0.0 || packet.solid[lane] != NO_HIT {
                continue;
            }
            let hit = &hits[lane];
            let cosine = dot(to_light[lane], hit.normal);
            let half = subtract(to_light[lane], hit.direction);
            let half_cosine = dot(half, hit.normal) / length(half).max(1e-6);
            fallen[lane][0] += strength[lane] * cosine;
            fallen[lane][1] += strength[lane] * cosine * half_cosine.max(0.0).powi(HIGHLIGHT);
        }
    }
}

/// Pixels whose right or lower neighbour is another surface with other light, and these neighbours.
fn edges(surfaces: &[u32], light: &[[f32; 3]], width: usize) -> Vec<usize> {
    let differ = |a: usize, b: usize| {
        surfaces[a] != surfaces[b]
            && (0..3).any(|i| {
                let [a, b] = [light[a][i], light[b][i]];
                (a - b).abs() > EDGE_CONTRAST * a.max(b)
            })
    };
    let mut is_edge = vec![false; surfaces.len()];
    for pixel in 0..surfaces.len() {
        let right = (pixel % width + 1 < width).then_some(pixel + 1);
        for neighbour in right.into_iter().chain(Some(pixel + width).filter(|below| *below < surfaces.len()))
        {
            if differ(pixel, neighbour) {
                is_edge[pixel] = true;
                is_edge[neighbour] = true;
            }
        }
    }
    is_edge.iter().enumerate().filter_map(|(pixel, is_edge)| is_edge.then_some(pixel)).collect()
}

fn bounding_rectangle(points: impl Iterator<Item = [f64; 2]>) -> ([f32; 2], [f32; 2]) {
    let start = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
    points.fold(start, |(min, max), px| {
        let px = px.map(|c| c as f32);
        ([0, 1].map(|i| min[i].min(px[i] - 1.0)), [0, 1].map(|i| max[i].max(px[i] + 1.0)))
    })
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn subtract(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn length(v: [f32; 3]) -> f32 {
    dot(v, v).sqrt()
}
