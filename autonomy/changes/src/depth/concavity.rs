//! Parts objects that touch each other: where a surface bends inwards and the colours on both sides differ.
//!
//! Things are mostly convex, so that two of them meet where the surface bends inwards. Source of the idea: Stein and others, *Object Partitioning using Local Convexity*, 2014.
//! Difference: what bends inwards within one thing, such as a pot and its handle, is joined again by its colour.

use super::colour::ColourHistogram;
use super::config::DepthChangesConfig;
use super::image::DepthImage;
use super::normals::normal;
use super::segments::{area_m2, connected};
use std::collections::VecDeque;

/// The objects of a connected part: itself, or its parts, each in ascending order. Linear in its pixels, times the window of a normal.
pub(crate) fn parted(part: &[usize], image: &DepthImage, config: &DepthChangesConfig) -> Vec<Vec<usize>> {
    let is_border = borders(part, image, config);
    let inner: Vec<usize> = part.iter().copied().filter(|pixel| !is_border[*pixel]).collect();
    let mut cores = connected(&inner, image, 1, config);
    cores.retain(|core| area_m2(core.iter().copied(), image) >= config.min_area_m2);
    if cores.len() < 2 {
        return vec![part.to_vec()];
    }
    let core_of = nearest_cores(part, &cores, image);
    let objects = joined_by_colour(&cores, &core_of, image, config);
    let mut parts = vec![Vec::new(); cores.len()];
    for pixel in part {
        if let Some(core) = core_of[*pixel] {
            parts[objects[core]].push(*pixel);
        }
    }
    parts.retain(|part| !part.is_empty());
    parts
}

/// Whether each pixel is where the surface of a part bends inwards, or next to it.
fn borders(part: &[usize], image: &DepthImage, config: &DepthChangesConfig) -> Vec<bool> {
    let [width, height] = image.size_px();
    let mut normals = vec![None; image.len()];
    for pixel in part {
        normals[*pixel] = normal(image, *pixel, config);
    }
    let step = config.bend_px as isize;
    let mut is_border = vec![false; image.len()];
    for first in part {
        let (column, row) = ((first % width) as isize, (first / width) as isize);
        for (columns, rows) in [(step, 0), (0, step), (step, step), (-step, step)] {
            let (to_column, to_row) = (column + columns, row + rows);
            if to_column < 0 || to_column >= width as isize || to_row >= height as isize {
                continue;
            }
            let second = to_row as usize * width + to_column as usize;
            if bends_inwards([*first, second], &normals, image, config) {
                let middle = (row + rows / 2) as usize * width + (column + columns / 2) as usize;
                for near in image.around(middle, 1) {
                    is_border[near] = true;
                }
            }
        }
    }
    is_border
}

/// Whether the surface bends inwards between two pixels: their normals turn towards each other by more than the least angle.
fn bends_inwards(
    [first, second]: [usize; 2],
    normals: &[Option<geometry::Vector3>],
    image: &DepthImage,
    config: &DepthChangesConfig,
) -> bool {
    let (Some(from), Some(to)) = (normals[first], normals[second]) else { return false };
    let (Some(a), Some(b)) = (image.point(first), image.point(second)) else { return false };
    let distance_m = (b - a).norm();
    // Farther apart than a surface seen at a slant of 70 degrees: a gap, no bend.
    let max_apart_m = 3.0 * config.bend_px as f64 * image.camera().pixel_area_m2(a.z).sqrt() * 1.5;
    if distance_m > max_apart_m.max(config.gap_m) || from.dot(&to) > config.min_bend_rad.cos() {
        return false;
    }
    (to - from).dot(&(b - a)) < -(config.min_bend_rad / 2.0).sin() * distance_m
}

/// The core of each pixel of a part: the one from which it is reached in fewest steps within the part.
fn nearest_cores(part: &[usize], cores: &[Vec<usize>], image: &DepthImage) -> Vec<Option<usize>> {
    let mut is_part = vec![false; image.len()];
    for pixel in part {
        is_part[*pixel] = true;
    }
    let mut core_of = vec![None; image.len()];
    let mut waiting = VecDeque::new();
    for (core, pixels) in cores.iter().enumerate() {
        for pixel in pixels {
            core_of[*pixel] = Some(core);
            waiting.push_back((*pixel, core));
        }
    }
    while let Some((pixel, core)) = waiting.pop_front() {
        for near in image.around(pixel, 2) {
            if is_part[near] && core_of[near].is_none() {
                core_of[near] = Some(core);
                waiting.push_back((near, core));
            }
        }
    }
    core_of
}

/// The object of each core, named by its first core: neighbouring cores with one colour are one object.
fn joined_by_colour(
    cores: &[Vec<usize>],
    core_of: &[Option<usize>],
    image: &DepthImage,
    config: &DepthChangesConfig,
) -> Vec<usize> {
    let mut objects: Vec<usize> = (0..cores.len()).collect();
    if image.colours().is_empty() {
        return objects;
    }
    let colours: Vec<Option<ColourHistogram>> = cores
        .iter()
        .map(|core| ColourHistogram::of(core.iter().map(|pixel| image.colours()[*pixel]), &config.colours))
        .collect();
    for (first, second) in neighbours(core_of, image) {
        let overlap = colours[first].as_ref().zip(colours[second].as_ref()).map(|(a, b)| a.overlap(b));
        if overlap.is_some_and(|overlap| overlap >= config.same_colour_overlap) {
            let (low, high) = (objects[first].min(objects[second]), objects[first].max(objects[second]));
            for object in &mut objects {
                if *object == high {
                    *object = low;
                }
            }
        }
    }
    objects
}

/// Pairs of cores with pixels next to each other, ascending.
fn neighbours(core_of: &[Option<usize>], image: &DepthImage) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    for pixel in 0..core_of.len() {
        let Some(core) = core_of[pixel] else { continue };
        for other in image.around(pixel, 1).filter_map(|near| core_of[near]) {
            if other != core && !pairs.contains(&(core.min(other), core.max(other))) {
                pairs.push((core.min(other), core.max(other)));
            }
        }
    }
    pairs.sort_unstable();
    pairs
}
