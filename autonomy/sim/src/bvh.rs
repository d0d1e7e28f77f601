//! A bounding volume hierarchy over the solids of a site: nearest hits for packets of rays, and all solids near a point.
//!
//! It is built once by the binned surface-area heuristic (Wald, *On fast construction of SAH-based bounding volume hierarchies*, 2007). Solids
//! are stored in the order of the leaves, nodes in depth-first order: the left child follows its parent.

use crate::ray_packet::{NO_HIT, PackedShape, RayPacket};
use crate::shape::Solid;
use geometry::Vector3;

const BINS: usize = 16;
/// Leaves never hold more solids than this.
const MAX_LEAF: usize = 4;
/// Cost of visiting a node, relative to testing a solid.
const NODE_COST: f32 = 0.8;
/// Greatest depth. The builder stops splitting there. Trees of 2³² solids that halve at least at every other level stay below it.
const MAX_DEPTH: usize = 60;

#[derive(Clone, Copy, Debug)]
struct Node {
    min: [f32; 3],
    /// Leaf: index of its first solid. Inner node: index of the right child.
    link: u32,
    max: [f32; 3],
    /// Number of solids in a leaf. 0 for inner nodes.
    count: u16,
    /// Axis along which an inner node is split.
    axis: u16,
}

/// Solids in a tree.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    packed: Vec<PackedShape>,
    solids: Vec<Solid>,
}

#[derive(Clone, Copy)]
struct Bounds {
    min: [f32; 3],
    max: [f32; 3],
}

impl Bounds {
    const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    fn of(solid: &Solid) -> Self {
        let (min, max) = solid.shape.bounds();
        // The box is 0.1 mm wider than the shape on every side, so that rounding to f32 never cuts the shape.
        let pad = 1e-4;
        Self { min: [0, 1, 2].map(|i| (min[i] - pad) as f32), max: [0, 1, 2].map(|i| (max[i] + pad) as f32) }
    }

    fn join(self, other: Self) -> Self {
        Self {
            min: [0, 1, 2].map(|i| self.min[i].min(other.min[i])),
            max: [0, 1, 2].map(|i| self.max[i].max(other.max[i])),
        }
    }

    fn center(&self, axis: usize) -> f32 {
        (self.min[axis] + self.max[axis]) * 0.5
    }

    /// Half of the surface area.
    fn area(&self) -> f32 {
        let e = [0, 1, 2].map(|i| (self.max[i] - self.min[i]).max(0.0));
        e[0] * e[1] + e[1] * e[2] + e[2] * e[0]
    }
}

struct Item {
    bounds: Bounds,
    solid: Solid,
}

impl Bvh {
    /// Builds the tree.
    pub fn new(solids: &[Solid]) -> Self {
        let mut items: Vec<Item> =
            solids.iter().map(|solid| Item { bounds: Bounds::of(solid), solid: *solid }).collect();
        let mut nodes = Vec::with_capacity(solids.len());
        if !items.is_empty() {
            build(&mut items, 0, 0, &mut nodes);
        }
        let packed = items.iter().map(|item| PackedShape::from(&item.solid)).collect();
        Self { nodes, packed, solids: items.into_iter().map(|item| item.solid).collect() }
    }

    /// Solids in the order of the numbers in [`RayPacket::solid`].
    pub fn solids(&self) -> &[Solid] {
        &self.solids
    }

    /// Unit normal at a surface point of the solid with this number in [`RayPacket::solid`].
    pub(crate) fn normal(&self, solid: u32, point: [f32; 3]) -> [f32; 3] {
        self.packed[solid as usize].normal(point)
    }

    /// Shortens every ray of the packet to the nearest surface.
    pub fn cast(&self, packet: &mut RayPacket) {
        self.traverse(packet, |_| true);
    }

    /// Whether the processor has the instructions that test a whole packet at once.
    #[cfg(any(test, target_arch = "x86_64"))]
    pub(crate) fn has_wide_instructions() -> bool {
        #[cfg(target_arch = "x86_64")]
        return std::arch::is_x86_feature_detected!("avx2");
        #[cfg(not(target_arch = "x86_64"))]
        return false;
    }

    /// As [`Self::cast`], with the instructions that every processor has.
    #[cfg(test)]
    pub(crate) fn cast_portable(&self, packet: &mut RayPacket) {
        self.traverse_portable(packet, |_| true);
    }

    /// Finds out which rays of the packet hit any surface: those have a solid afterwards, not always the nearest one.
    pub(crate) fn occlude(&self, packet: &mut RayPacket) {
        self.traverse(packet, RayPacket::end_hits);
    }

    /// Visits all leaves that a ray of the packet reaches, the nearer ones first. After each, `goes_on` says whether to go on. A packet fits a register of AVX; the
    /// results are the same bits with and without it, because no operation is fused or reordered.
    #[allow(unsafe_code, reason = "instructions that not every processor has")]
    fn traverse(&self, packet: &mut RayPacket, goes_on: impl Fn(&mut RayPacket) -> bool) {
        #[cfg(target_arch = "x86_64")]
        if Self::has_wide_instructions() {
            // SAFETY: the processor has these instructions.
            return unsafe { self.traverse_avx2(packet, goes_on) };
        }
        self.traverse_portable(packet, goes_on);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn traverse_avx2(&self, packet: &mut RayPacket, goes_on: impl Fn(&mut RayPacket) -> bool) {
        self.traverse_portable(packet, goes_on);
    }

    #[inline(always)]
    fn traverse_portable(&self, packet: &mut RayPacket, goes_on: impl Fn(&mut RayPacket) -> bool) {
        if self.nodes.is_empty() {
            return;
        }
        // The nearer child comes first. All rays of a packet point in nearly the same direction.
        let backwards = [0, 1, 2].map(|axis| packet.direction[axis][0] < 0.0);
        let mut stack = [0_u32; MAX_DEPTH + 4];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let index = stack[waiting];
            let node = &self.nodes[index as usize];
            if !packet.intersects_box(&node.min, &node.max) {
                continue;
            }
            if node.count > 0 {
                for id in node.link..node.link + u32::from(node.count) {
                    self.packed[id as usize].intersect(packet, id);
                }
                if !goes_on(packet) {
                    return;
                }
                continue;
            }
            let (near, far) = if backwards[usize::from(node.axis)] {
                (node.link, index + 1)
            } else {
                (index + 1, node.link)
            };
            stack[waiting] = far;
            stack[waiting + 1] = near;
            waiting += 2;
        }
    }

    /// The first surface along a unit direction within `max_range` metres: its range (metres) and its solid.
    pub fn first_hit(&self, origin: &Vector3, direction: &Vector3, max_range: f64) -> Option<(f64, &Solid)> {
        let mut packet = RayPacket::single(origin, direction, max_range as f32);
        self.cast(&mut packet);
        let solid = packet.solid[0];
        (solid != NO_HIT).then(|| (f64::from(packet.range[0]), &self.solids[solid as usize]))
    }

    /// Calls `visit` for every solid whose bounding box comes within `radius` metres of `point`.
    pub fn near<'a>(&'a self, point: &Vector3, radius: f64, mut visit: impl FnMut(&'a Solid)) {
        let point = [point.x as f32, point.y as f32, point.z as f32];
        let limit = (radius * radius) as f32;
        let mut stack = vec![0_u32];
        while let Some(index) = stack.pop() {
            let Some(node) = self.nodes.get(index as usize) else { continue };
            let gap = [0, 1, 2].map(|i| (node.min[i] - point[i]).max(point[i] - node.max[i]).max(0.0));
            if gap.iter().map(|g| g * g).sum::<f32>() > limit {
                continue;
            }
            if node.count > 0 {
                let first = node.link as usize;
                self.solids[first..first + usize::from(node.count)].iter().for_each(&mut visit);
            } else {
                stack.extend([node.link, index + 1]);
            }
        }
    }
}

/// Builds the subtree of `items`. `first` is the overall index of their first solid.
fn build(items: &mut [Item], first: usize, depth: usize, nodes: &mut Vec<Node>) {
    let bounds = items.iter().fold(Bounds::EMPTY, |all, item| all.join(item.bounds));
    let index = nodes.len();
    let leaf =
        Node { min: bounds.min, max: bounds.max, link: first as u32, count: items.len() as u16, axis: 0 };
    nodes.push(leaf);
    let split = if depth < MAX_DEPTH { best_split(items, &bounds) } else { None };
    let (axis, middle) = match split {
        Some((axis, border)) => {
            let middle = partition(items, |item| item.bounds.center(axis) < border);
            (axis, middle)
        }
        None if items.len() <= MAX_LEAF || depth >= MAX_DEPTH => return,
        // All centres coincide, so any split into halves is as good.
        None => (0, items.len() / 2),
    };
    let (left, right) = items.split_at_mut(middle);
    build(left, first, depth + 1, nodes);
    let link = nodes.len() as u32;
    build(right, first + middle, depth + 1, nodes);
    nodes[index] = Node { link, count: 0, axis: axis as u16, ..leaf };
}

/// Axis and border of the cheapest split. `None` if a leaf is cheaper and small enough, or if no border divides the items.
fn best_split(items: &[Item], bounds: &Bounds) -> Option<(usize, f32)> {
    if items.len() < 2 {
        return None;
    }
    let mut best: Option<(f32, usize, f32)> = None;
    for axis in 0..3 {
        let low = items.iter().map(|item| item.bounds.center(axis)).fold(f32::INFINITY, f32::min);
        let high = items.iter().map(|item| item.bounds.center(axis)).fold(f32::NEG_INFINITY, f32::max);
        if high - low < 1e-6 {
            continue;
        }
        let mut bins = [(Bounds::EMPTY, 0_usize); BINS];
        for item in items {
            let bin = ((item.bounds.center(axis) - low) / (high - low) * BINS as f32) as usize;
            let (joined, count) = &mut bins[bin.min(BINS - 1)];
            *joined = joined.join(item.bounds);
            *count += 1;
        }
        for border in 1..BINS {
            let side = |part: &[(Bounds, usize)]| {
                part.iter().fold((Bounds::EMPTY, 0), |(all, n), (b, count)| (all.join(*b), n + count))
            };
            let ((left, left_count), (right, right_count)) = (side(&bins[..border]), side(&bins[border..]));
            if left_count == 0 || right_count == 0 {
                continue;
            }
            let cost = left.area() * left_count as f32 + right.area() * right_count as f32;
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, low + (high - low) * border as f32 / BINS as f32));
            }
        }
    }
    let (cost, axis, border) = best?;
    let worthwhile = cost + 2.0 * NODE_COST * bounds.area() < bounds.area() * items.len() as f32;
    (worthwhile || items.len() > MAX_LEAF).then_some((axis, border))
}

/// Moves the items that belong left to the front and returns their number. The order changes on both sides.
fn partition(items: &mut [Item], belongs_left: impl Fn(&Item) -> bool) -> usize {
    let mut left = 0;
    for i in 0..items.len() {
        if belongs_left(&items[i]) {
            items.swap(left, i);
            left += 1;
        }
    }
    // Rounding of the border may leave one side empty. Then the items are split into halves.
    if left == 0 || left == items.len() { items.len() / 2 } else { left }
}
