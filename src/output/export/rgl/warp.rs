//! The map from the unit square to the half vectors of a lobe that Mitsuba, pbrt and powitacq make of a table of densities
//! (Dupuy and Jakob, An Adaptive Parameterization for Efficient Material Acquisition and Rendering, 2018): rows are chosen
//! by their integral, then columns; between rows and columns the density is bilinear.

/// A positive density on nodes of the unit square, ready to be drawn from.
pub struct Warp {
    width: usize,
    /// Density at the nodes, row by row, normalised.
    density: Vec<f64>,
    /// Integral along each row up to the end of each of its cells.
    conditional: Vec<f64>,
    /// Integral along the whole of each row.
    rows: Vec<f64>,
    /// Integral of the rows up to the end of each cell between them.
    marginal: Vec<f64>,
}

impl Warp {
    /// From densities at `height` × `width` nodes, both at least 2.
    pub fn new(density: &[f64], width: usize) -> Self {
        let height = density.len() / width;
        let step = |n: usize| 0.5 / (n - 1) as f64;
        let mut conditional = Vec::with_capacity(height * (width - 1));
        let mut rows = Vec::with_capacity(height);
        for row in density.chunks(width) {
            let mut sum = 0.0;
            conditional.extend(row.windows(2).map(|pair| {
                sum += step(width) * (pair[0] + pair[1]);
                sum
            }));
            rows.push(sum);
        }
        let mut sum = 0.0;
        let marginal: Vec<f64> = rows
            .windows(2)
            .map(|pair| {
                sum += step(height) * (pair[0] + pair[1]);
                sum
            })
            .collect();
        let scaled = |all: Vec<f64>| all.into_iter().map(|x| x / sum).collect();
        let density = scaled(density.to_vec());
        Self { width, density, conditional: scaled(conditional), rows: scaled(rows), marginal: scaled(marginal) }
    }

    /// The point to which one of the unit square goes, and the density there.
    pub fn draw(&self, [x, y]: [f64; 2]) -> ([f64; 2], f64) {
        let (w, cells) = (self.width, self.width - 1);
        let height = self.rows.len();
        let row = self.marginal.partition_point(|&m| m < y).min(height - 2);
        let rest = y - if row > 0 { self.marginal[row - 1] } else { 0.0 };
        let ty = within(rest, height - 1, self.rows[row], self.rows[row + 1]);
        let between = |all: &[f64], n: usize, k: usize| lerp(all[row * n + k], all[(row + 1) * n + k], ty);
        let conditional: Vec<f64> = (0..cells).map(|k| between(&self.conditional, cells, k)).collect();
        let x = x * lerp(self.rows[row], self.rows[row + 1], ty);
        let column = conditional.partition_point(|&c| c < x).min(cells - 1);
        let rest = x - if column > 0 { conditional[column - 1] } else { 0.0 };
        let [low, high] = [column, column + 1].map(|k| between(&self.density, w, k));
        let tx = within(rest, cells, low, high);
        ([(column as f64 + tx) / cells as f64, (row as f64 + ty) / (height - 1) as f64], lerp(low, high, tx))
    }
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + t * (b - a)
}

/// Part of a cell, of `cells` in all, whose integral is `part`, where the density goes from `a` to `b`.
fn within(part: f64, cells: usize, a: f64, b: f64) -> f64 {
    let part = 2.0 * cells as f64 * part;
    let t = if (a - b).abs() > 1e-4 * (a + b) {
        (a - (a * a + part * (b - a)).max(0.0).sqrt()) / (a - b)
    } else {
        part / (a + b)
    };
    t.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_density_moves_nothing() {
        let warp = Warp::new(&[2.0; 12], 4);
        for at in [[0.0, 0.0], [0.3, 0.7], [0.99, 0.01], [1.0, 1.0]] {
            let (to, density) = warp.draw(at);
            assert!((to[0] - at[0]).abs() < 1e-12 && (to[1] - at[1]).abs() < 1e-12 && (density - 1.0).abs() < 1e-12);
        }
    }

    /// The density is that of the bilinear table: its integral is 1, and the Jacobian of the map its inverse.
    #[test]
    fn the_density_is_the_inverse_jacobian() {
        let table: Vec<f64> = (0..35).map(|i| 0.1 + f64::from(i * i % 17)).collect();
        let warp = Warp::new(&table, 7);
        let step = 1e-5;
        for i in 0..19 {
            for j in 0..19 {
                let at = [f64::from(i) / 19.0 + 0.021, f64::from(j) / 19.0 + 0.017];
                let (p, density) = warp.draw(at);
                let ((q, _), (r, _)) = (warp.draw([at[0] + step, at[1]]), warp.draw([at[0], at[1] + step]));
                let area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
                let jacobian = area / (step * step);
                // Steps over the edge of a cell see two slopes.
                assert!((density * jacobian - 1.0).abs() < 0.02, "{at:?}: {density} {jacobian}");
            }
        }
    }
}
