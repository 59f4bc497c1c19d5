//! Which of many boxes overlap: uniform grids.

use std::sync::OnceLock;

use glam::I64Vec3;

use super::Aabb;

/// Boxes that reach over more cells than this are compared with all others instead.
const MANY_CELLS: i64 = 64;

/// So few boxes are compared with all others sooner than sorted into coarser grids.
const FEW_BOXES: usize = 4096;

/// Grids over boxes, each coarser than the one before.
pub struct Pairs<'a> {
    boxes: &'a [Aabb],
    /// With the edge of their cells, µm; made when they are first asked.
    grids: Vec<(f64, OnceLock<Grid>)>,
}

/// Cells of one size.
struct Grid {
    /// Boxes by bucket of cells: those of bucket `b` are at `starts[b]..starts[b + 1]`.
    starts: Vec<u32>,
    sorted: Vec<u32>,
    large: Vec<u32>,
}

impl<'a> Pairs<'a> {
    /// Coarser grids than this are of no use.
    const MOST_GRIDS: usize = 4;

    /// Sorts boxes into cells of about their median size and, if they are many, into coarser ones, for who looks for all
    /// boxes in a large one. Empty boxes are left out.
    pub fn new(boxes: &'a [Aabb]) -> Self {
        let some = boxes.iter().step_by(1 + boxes.len() / FEW_BOXES);
        let mut edges: Vec<f64> = some.map(|b| b.size().max_element()).filter(|e| e.is_finite() && *e > 0.0).collect();
        edges.sort_by(f64::total_cmp);
        let finest = edges.get(edges.len() / 2).copied().unwrap_or(1.0);
        let count = if boxes.len() > FEW_BOXES { Self::MOST_GRIDS } else { 1 };
        let edge = |level: usize| finest * 4.0_f64.powi(level as i32);
        Self { boxes, grids: (0..count).map(|level| (edge(level), OnceLock::new())).collect() }
    }

    /// Calls `visit` for every box that overlaps `b` (touching counts), possibly more than once.
    pub fn overlapping(&self, b: &Aabb, mut visit: impl FnMut(usize)) {
        if b.is_empty() {
            return;
        }
        let mut offer = |i: u32| {
            if self.boxes[i as usize].overlaps(*b) {
                visit(i as usize);
            }
        };
        match self.grids.iter().find_map(|(edge, grid)| Some((*edge, grid, range(*edge, b)?))) {
            Some((edge, grid, cells)) => {
                let grid = grid.get_or_init(|| Grid::new(self.boxes, edge));
                for cell in cells {
                    let b = grid.bucket(cell);
                    let inside = grid.starts[b] as usize..grid.starts[b + 1] as usize;
                    grid.sorted[inside].iter().copied().for_each(&mut offer);
                }
                grid.large.iter().copied().for_each(offer);
            }
            None => (0..self.boxes.len() as u32).for_each(offer),
        }
    }

    /// Every pair of different boxes that overlap, once, the smaller number first.
    pub fn all(&self) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        for (i, b) in self.boxes.iter().enumerate() {
            let first = pairs.len();
            self.overlapping(b, |j| {
                if j > i {
                    pairs.push((i, j));
                }
            });
            pairs[first..].sort_unstable();
        }
        pairs.dedup();
        pairs
    }
}

impl Grid {
    fn new(boxes: &[Aabb], edge: f64) -> Self {
        let buckets = (2 * boxes.len()).next_power_of_two();
        let mut grid = Self { starts: vec![0; buckets + 1], sorted: Vec::new(), large: Vec::new() };
        // Counted first, so that nothing is kept that is not needed later.
        for (i, b) in boxes.iter().enumerate() {
            match range(edge, b) {
                Some(cells) => cells.for_each(|cell| *grid.end_of(cell) += 1),
                None if !b.is_empty() => grid.large.push(i as u32),
                None => {}
            }
        }
        for b in 1..grid.starts.len() {
            grid.starts[b] += grid.starts[b - 1];
        }
        // Filled from behind, until what was the end of each bucket is its beginning, and the end of the one before.
        grid.sorted = vec![0; grid.starts.last().map_or(0, |&all| all as usize)];
        for (i, b) in boxes.iter().enumerate().rev() {
            for cell in range(edge, b).into_iter().flatten() {
                let end = grid.end_of(cell);
                *end -= 1;
                let at = *end as usize;
                grid.sorted[at] = i as u32;
            }
        }
        grid.starts.rotate_left(1);
        if let Some(end) = grid.starts.last_mut() {
            *end = grid.sorted.len() as u32;
        }
        grid
    }

    /// Where the bucket of a cell ends, while that is being found out.
    fn end_of(&mut self, cell: I64Vec3) -> &mut u32 {
        let bucket = self.bucket(cell);
        &mut self.starts[bucket + 1]
    }

    /// The bucket of a cell; others may share it. Cells of a block have theirs side by side: who comes along a
    /// space-filling curve finds them near at hand.
    fn bucket(&self, cell: I64Vec3) -> usize {
        let mix = |h: u64, x: i64| (h ^ (x >> 2) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
        let within = cell.to_array().into_iter().fold(0, |place, x| place << 2 | (x & 3) as u64);
        (cell.to_array().into_iter().fold(0, mix) << 6 | within) as usize & (self.starts.len() - 2)
    }
}

/// The cells of this edge (µm) that a box reaches, or `None` if it is empty or they are too many.
fn range(edge: f64, b: &Aabb) -> Option<impl Iterator<Item = I64Vec3> + use<>> {
    let (low, high) = ((b.min / edge).floor(), (b.max / edge).floor());
    let count = (high - low + 1.0).element_product();
    let few = count <= MANY_CELLS as f64; // false for a box that is no box
    if b.is_empty() || !few || low.abs().max_element() > 1e15 {
        return None;
    }
    let (low, high) = (low.as_i64vec3(), high.as_i64vec3());
    Some(
        (low.z..=high.z).flat_map(move |z| {
            (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| I64Vec3::new(x, y, z)))
        }),
    )
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn finds_the_pairs_that_comparing_all_finds() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut random = |scale: f64| DVec3::from_array(std::array::from_fn(|_| scale * rng.random::<f64>()));
        let mut boxes: Vec<Aabb> = (0..300)
            .map(|i| {
                let min = random(10.0);
                Aabb { min, max: min + random(if i % 50 == 0 { 20.0 } else { 1.0 }) }
            })
            .collect();
        boxes.push(Aabb::EMPTY);
        boxes.push(Aabb::INFINITE);
        let mut expected = Vec::new();
        for i in 0..boxes.len() {
            for j in i + 1..boxes.len() {
                if boxes[i].overlaps(boxes[j]) && !boxes[i].is_empty() && !boxes[j].is_empty() {
                    expected.push((i, j));
                }
            }
        }
        assert!(Pairs::new(&boxes).all() == expected);
    }

    #[test]
    fn a_large_box_finds_all_small_ones_in_it() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
        let mut random = |scale: f64| DVec3::from_array(std::array::from_fn(|_| scale * rng.random::<f64>()));
        let around = |p: DVec3, half: DVec3| Aabb { min: p - half, max: p + half };
        let boxes: Vec<Aabb> = (0..2 * FEW_BOXES).map(|_| around(random(100.0), random(0.5))).collect();
        let pairs = Pairs::new(&boxes);
        for edge in [0.1, 1.0, 5.0, 20.0, 80.0, 1000.0] {
            let b = around(random(100.0), random(edge));
            let mut found = Vec::new();
            pairs.overlapping(&b, |i| found.push(i));
            found.sort_unstable();
            found.dedup();
            let expected: Vec<usize> = (0..boxes.len()).filter(|&i| boxes[i].overlaps(b)).collect();
            assert_eq!(found, expected, "{edge}");
        }
    }
}
