//! Symmetric matrices whose entries stand in a band along the diagonal: Cholesky's factor has no other.

/// The lower half of a positive definite matrix, later of its factor L of L Lᵀ.
pub(super) struct BandMatrix {
    n: usize,
    width: usize,
    /// Column by column, each from its diagonal down.
    entries: Vec<f64>,
}

impl BandMatrix {
    /// Of `n` rows, with `width` entries beside the diagonal.
    pub(super) fn zeros(n: usize, width: usize) -> BandMatrix {
        BandMatrix { n, width, entries: vec![0.0; n * (width + 1)] }
    }

    /// Sets all entries to zero.
    pub(super) fn clear(&mut self) {
        self.entries.fill(0.0);
    }

    /// Entry of row i and column j, or of row j and column i.
    pub(super) fn at(&mut self, i: usize, j: usize) -> &mut f64 {
        &mut self.entries[i.min(j) * (self.width + 1) + i.abs_diff(j)]
    }

    /// Factorises it in place.
    #[inline(always)]
    pub(super) fn factorise(&mut self) {
        let size = self.width + 1;
        for j in 0..self.n {
            let (before, after) = self.entries.split_at_mut((j + 1) * size);
            let column = &mut before[j * size..];
            let n_below = self.width.min(self.n - 1 - j);
            let root = column[0].sqrt();
            column[0] = root;
            for entry in &mut column[1..=n_below] {
                *entry /= root;
            }
            for k in 1..=n_below {
                let factor = column[k];
                let other = &mut after[(k - 1) * size..];
                for (entry, below) in other.iter_mut().zip(&column[k..=n_below]) {
                    *entry -= below * factor;
                }
            }
        }
    }

    /// With the factor: from the right side to the solution, in place.
    #[inline(always)]
    pub(super) fn solve(&self, values: &mut [f64]) {
        let size = self.width + 1;
        for j in 0..self.n {
            let column = &self.entries[j * size..(j + 1) * size];
            let value = values[j] / column[0];
            values[j] = value;
            for (other, factor) in values[j + 1..].iter_mut().zip(&column[1..]) {
                *other -= factor * value;
            }
        }
        for j in (0..self.n).rev() {
            let column = &self.entries[j * size..(j + 1) * size];
            let known: f64 = values[j + 1..].iter().zip(&column[1..]).map(|(x, factor)| x * factor).sum();
            values[j] = (values[j] - known) / column[0];
        }
    }
}

/// Places of `n` knots such that those on one cable stand close together: Cuthill and McKee's order.
pub(super) fn band_order(n: usize, cables: impl Iterator<Item = [usize; 2]>) -> Vec<usize> {
    let mut neighbours = vec![Vec::new(); n];
    for [a, b] in cables {
        neighbours[a].push(b);
        neighbours[b].push(a);
    }
    let degree: Vec<usize> = neighbours.iter().map(Vec::len).collect();
    let mut starts: Vec<usize> = (0..n).collect();
    starts.sort_by_key(|&knot| degree[knot]);
    let mut place = vec![usize::MAX; n];
    let mut order = Vec::with_capacity(n);
    for start in starts {
        if place[start] != usize::MAX {
            continue;
        }
        place[start] = order.len();
        order.push(start);
        let mut next = place[start];
        while next < order.len() {
            let mut found = neighbours[order[next]].clone();
            found.sort_by_key(|&knot| (degree[knot], knot));
            for knot in found {
                if place[knot] == usize::MAX {
                    place[knot] = order.len();
                    order.push(knot);
                }
            }
            next += 1;
        }
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_solves_what_the_matrix_makes() {
        let (n, width) = (9, 3);
        let mut matrix = BandMatrix::zeros(n, width);
        let entry = |i: usize, j: usize| if i == j { 8.0 } else { (1.3 * (i * j) as f64).sin() };
        for j in 0..n {
            for i in j..n.min(j + width + 1) {
                *matrix.at(i, j) = entry(i.max(j), i.min(j));
            }
        }
        let wanted: Vec<f64> = (0..n).map(|i| (0.7 * i as f64).cos()).collect();
        let mut values: Vec<f64> = (0..n)
            .map(|i| {
                let near = (0..n).filter(|j| i.abs_diff(*j) <= width);
                near.map(|j| entry(i.max(j), i.min(j)) * wanted[j]).sum()
            })
            .collect();
        matrix.factorise();
        matrix.solve(&mut values);
        assert!(values.iter().zip(&wanted).all(|(x, y)| (x - y).abs() < 1e-13), "{values:?}");
    }

    /// A grid's band is as wide as its shorter side and one, whatever the numbers of its knots.
    #[test]
    fn knots_of_a_grid_stand_in_a_narrow_band() {
        let (rows, columns) = (11, 30);
        // Numbered as badly as may be.
        let number = |row: usize, column: usize| (row * columns + column) * 7 % (rows * columns);
        let mut cables = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                if row + 1 < rows {
                    cables.push([number(row, column), number(row + 1, column)]);
                }
                if column + 1 < columns {
                    cables.push([number(row, column), number(row, column + 1)]);
                }
            }
        }
        let place = band_order(rows * columns, cables.iter().copied());
        let mut sorted = place.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..rows * columns));
        let width = cables.iter().map(|[a, b]| place[*a].abs_diff(place[*b])).max().unwrap();
        assert!(width <= rows + 1, "{width}");
    }
}
