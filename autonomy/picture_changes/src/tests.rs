//! Tests of the alignment and of the search for changes on drawn pictures.

use crate::{
    Homography, PictureAlignmentConfig, PictureAlignmentError, PictureChangesConfig, align_pictures,
    find_picture_changes, mapped_dial,
};
use gauges::{Dial, Picture};
use geometry::{Matrix3, Rng, RngTree};

const SIZE_PX: [usize; 2] = [320, 240];

/// A dial with a red needle on a wall with marks. `turn_rad`: direction of the needle, clockwise, 0 is up.
struct Scene {
    turn_rad: f64,
    /// Light of the left half relative to that of the right half: the edge of a shadow.
    shadow: f64,
    gain: f64,
    /// How far a post before the wall is displaced, pixels: what parallax does.
    post_px: f64,
}

const PLAIN: Scene = Scene { turn_rad: 0.5, shadow: 1.0, gain: 1.0, post_px: 0.0 };

impl Scene {
    /// Linear red, green and blue at a place of the wall, pixels of a picture that is taken from the middle.
    fn colour(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let (right, down) = (x - 160.0, y - 120.0);
        let radius = right.hypot(down);
        let (sin, cos) = self.turn_rad.sin_cos();
        let (along, across) = (right * sin - down * cos, right * cos + down * sin);
        let is_needle = (-10.0..50.0).contains(&along) && across.abs() < 2.5;
        let is_mark = (52.0..58.0).contains(&radius) && (down.atan2(right) * 5.0).sin() > 0.6;
        let is_ring = (62.0..66.0).contains(&radius);
        let is_joint = (x.rem_euclid(90.0) < 3.0 || y.rem_euclid(70.0) < 3.0) && radius > 66.0;
        let on_post = x - 262.0 - self.post_px;
        let colour = match () {
            () if on_post.abs() < 12.0 => {
                if (y / 9.0).rem_euclid(2.0) < 1.0 {
                    [0.6, 0.4, 0.05]
                } else {
                    [0.05; 3]
                }
            }
            () if is_needle => [0.6, 0.03, 0.02],
            () if is_ring || is_mark => [0.03; 3],
            () if radius < 62.0 => [0.7; 3],
            () if is_joint => [0.1, 0.09, 0.08],
            () => [0.4, 0.35, 0.3],
        };
        let light = self.gain * if x < 110.0 { self.shadow } else { 1.0 };
        colour.map(|c| c * light)
    }

    /// The picture of a camera whose pixels are mapped to the wall, with noise.
    fn picture(&self, wall_from_px: &Homography, rng: &mut Rng) -> Picture {
        let pixel = |at: usize| {
            let offsets = [[0.25, 0.25], [-0.25, 0.25], [0.25, -0.25], [-0.25, -0.25]];
            let mut sum = [0.0; 3];
            for [dx, dy] in offsets {
                let px = [(at % SIZE_PX[0]) as f64 + dx, (at / SIZE_PX[0]) as f64 + dy];
                let colour = self.colour(wall_from_px.map(px).expect("ahead"));
                sum = [0, 1, 2].map(|i| sum[i] + 0.25 * colour[i]);
            }
            let encoded = |value: f64| 1.055 * value.powf(1.0 / 2.4) - 0.055;
            sum.map(|value| {
                (255.0 * encoded(value.clamp(0.003_2, 1.0)) + 2.0 * rng.normal()).clamp(0.0, 255.0).round()
                    as u8
            })
        };
        Picture::new(SIZE_PX, (0..SIZE_PX[0] * SIZE_PX[1]).map(pixel).collect()).expect("a picture")
    }
}

fn rng() -> Rng {
    RngTree::new(11).child("pictures").rng()
}

/// A camera that has moved a little.
fn moved() -> Homography {
    let matrix = Matrix3::new(1.02, -0.015, 4.3, 0.012, 0.99, -3.6, 2e-5, -3e-5, 1.0);
    Homography::new(&matrix).expect("a mapping")
}

/// Greatest error of a mapping in the middle of the picture, pixels.
fn error_px(found: &Homography, expected: &Homography) -> f64 {
    let places = (0..25).map(|at| [80.0 + 40.0 * f64::from(at % 5), 60.0 + 30.0 * f64::from(at / 5)]);
    let error = |px: [f64; 2]| {
        let [a, b] = [found, expected].map(|mapping| mapping.map(px).expect("ahead"));
        (a[0] - b[0]).hypot(a[1] - b[1])
    };
    places.map(error).fold(0.0, f64::max)
}

#[test]
fn pictures_are_aligned_in_other_light_and_the_same_input_gives_the_same_bits() {
    let mut rng = rng();
    let before = PLAIN.picture(&Homography::identity(), &mut rng);
    let after = Scene { shadow: 0.4, gain: 0.6, ..PLAIN }.picture(&moved(), &mut rng);
    let align =
        || align_pictures(&before, &after, None, &PictureAlignmentConfig::default()).expect("aligned");
    let found = align();
    let error_px = error_px(&found.after_from_before, &moved().inverse().expect("a mapping"));
    assert!(error_px < 0.3 && error_px <= found.residual_px, "{error_px} px, {} px", found.residual_px);
    assert_eq!(found, align());
}

#[test]
fn a_needle_that_has_turned_is_a_change_and_other_light_is_none() {
    let mut rng = rng();
    let before = PLAIN.picture(&Homography::identity(), &mut rng);
    let config = PictureChangesConfig::default();
    let changes = |scene: Scene, rng: &mut Rng| {
        let after = scene.picture(&moved(), rng);
        let found =
            align_pictures(&before, &after, None, &PictureAlignmentConfig::default()).expect("aligned");
        find_picture_changes(&before, &after, &found, &config)
    };
    assert_eq!(changes(Scene { shadow: 0.4, gain: 0.6, ..PLAIN }, &mut rng), []);
    // 5 % of a scale of 270 degrees.
    let turned = changes(Scene { turn_rad: 0.5 + 0.2356, shadow: 0.4, gain: 0.6, ..PLAIN }, &mut rng);
    let region = turned.first().expect("a change");
    assert!(region.min_px[0] > 150 && region.max_px[0] < 215 && region.min_px[1] > 60, "{turned:?}");
    assert!(region.score > 0.5 && region.score < 1.0, "{turned:?}");
}

#[test]
fn what_stands_before_the_wall_is_displaced_and_has_not_changed() {
    let mut rng = rng();
    let before = PLAIN.picture(&Homography::identity(), &mut rng);
    let after = Scene { post_px: 7.0, ..PLAIN }.picture(&moved(), &mut rng);
    let found = align_pictures(&before, &after, None, &PictureAlignmentConfig::default()).expect("aligned");
    assert!(error_px(&found.after_from_before, &moved().inverse().expect("a mapping")) < 0.3);
    assert_eq!(find_picture_changes(&before, &after, &found, &PictureChangesConfig::default()), []);
    // Without that tolerance it would be one.
    let strict =
        PictureChangesConfig { plane_share: 0.0, displaced_share: 1.0, ..PictureChangesConfig::default() };
    assert!(!find_picture_changes(&before, &after, &found, &strict).is_empty());
}

#[test]
fn what_cannot_be_aligned_gets_a_reason() {
    let mut rng = rng();
    let config = PictureAlignmentConfig::default();
    let picture = PLAIN.picture(&Homography::identity(), &mut rng);
    let noise = |rng: &mut Rng| {
        let pixel = |_: usize| [(120.0 + 4.0 * rng.normal()) as u8; 3];
        Picture::new(SIZE_PX, (0..SIZE_PX[0] * SIZE_PX[1]).map(pixel).collect()).expect("a picture")
    };
    let bare = noise(&mut rng);
    assert_eq!(align_pictures(&picture, &bare, None, &config), Err(PictureAlignmentError::NoTexture));
    let small = Picture::new([40, 40], vec![[0; 3]; 1_600]).expect("a picture");
    let too_small = align_pictures(&small, &picture, None, &config);
    assert_eq!(too_small, Err(PictureAlignmentError::TooSmall { size_px: [40, 40], least_px: 64 }));
    let aside = Homography::translation([290.0, 0.0]);
    let far = align_pictures(&picture, &picture, Some(&aside), &config);
    assert!(matches!(far, Err(PictureAlignmentError::TooLittleOverlap { .. })), "{far:?}");
    let blots = |seed: u64| {
        let mut rng = RngTree::new(seed).child("blots").rng();
        let places: Vec<[f64; 3]> =
            (0..40).map(|_| [rng.range(0.0, 320.0), rng.range(0.0, 240.0), rng.range(5.0, 25.0)]).collect();
        let pixel = |at: usize| {
            let (x, y) = ((at % SIZE_PX[0]) as f64, (at / SIZE_PX[0]) as f64);
            let count =
                places.iter().filter(|[right, down, radius]| (x - right).hypot(y - down) < *radius).count();
            [if count % 2 == 0 { 200 } else { 60 }; 3]
        };
        Picture::new(SIZE_PX, (0..SIZE_PX[0] * SIZE_PX[1]).map(pixel).collect()).expect("a picture")
    };
    let other = align_pictures(&blots(1), &blots(2), None, &config);
    assert_eq!(other, Err(PictureAlignmentError::NotConverged));
    for error in [PictureAlignmentError::NoTexture, PictureAlignmentError::NotConverged] {
        assert!(error.to_string().len() > 30);
    }
}

#[test]
fn a_dial_is_where_its_marks_are_mapped_to() {
    let dial = Dial {
        centre_px: [160.0, 120.0],
        axis_px: [161.0, 121.0],
        radius_px: 50.0,
        start_rad: -2.3,
        sweep_rad: 4.6,
        range: [0.0, 10.0],
    };
    let turned =
        Homography::new(&Matrix3::new(0.0, -2.0, 500.0, 2.0, 0.0, 7.0, 0.0, 0.0, 1.0)).expect("a mapping");
    let mapped = mapped_dial(&dial, &turned).expect("ahead");
    assert_eq!(mapped.centre_px, [260.0, 327.0]);
    assert!((mapped.radius_px - 100.0).abs() < 1e-9);
    let quarter = mapped.start_rad - dial.start_rad;
    assert!((quarter.sin() - 1.0).abs() < 1e-9, "{quarter}");
}
