//! Columns of features as bins of one byte.

use rayon::prelude::*;

/// The bin of a missing value.
pub const MISSING: u8 = 255;

/// The most bins of known values.
const MOST: usize = 255;

/// Columns of features, each value replaced by the number of its bin.
pub struct Bins {
    /// For each column, the ends of its bins in ascending order. Bin k contains values above end k - 1 and up to end k.
    /// The last bin contains values above all ends.
    ends: Vec<Vec<f32>>,
    /// For each column the bin of each row.
    codes: Vec<Vec<u8>>,
}

impl Bins {
    /// Bins with about equally many of the given rows, or with one value each if there are few.
    pub fn new(columns: &[Vec<f32>], rows: &[u32]) -> Self {
        let ends: Vec<Vec<f32>> = columns.par_iter().map(|column| ends(column, rows)).collect();
        let codes = columns.par_iter().zip(&ends).map(|(column, ends)| {
            let code = |x: &f32| match x.is_finite() {
                true => ends.partition_point(|end| end < x) as u8,
                false => MISSING,
            };
            column.iter().map(code).collect()
        });
        let codes = codes.collect();
        Self { ends, codes }
    }

    pub fn columns(&self) -> usize {
        self.codes.len()
    }

    /// The bin of each row.
    pub fn codes(&self, column: usize) -> &[u8] {
        &self.codes[column]
    }

    /// Number of bins of known values.
    pub fn bins(&self, column: usize) -> usize {
        self.ends[column].len() + 1
    }

    /// The largest value of a bin; infinite for the last.
    pub fn end(&self, column: usize, bin: u8) -> f32 {
        self.ends[column].get(usize::from(bin)).copied().unwrap_or(f32::INFINITY)
    }
}

fn ends(column: &[f32], rows: &[u32]) -> Vec<f32> {
    let mut values: Vec<f32> =
        rows.iter().map(|row| column[*row as usize]).filter(|v| v.is_finite()).collect();
    values.sort_by(f32::total_cmp);
    let mut distinct = values.clone();
    distinct.dedup();
    let candidates: Vec<(f32, f32)> = if distinct.len() <= MOST {
        distinct.windows(2).map(|two| (two[0], two[1])).collect()
    } else {
        (1..MOST)
            .map(|k| k * values.len() / MOST)
            .filter(|k| values[k - 1] < values[*k])
            .map(|k| (values[k - 1], values[k]))
            .collect()
    };
    let mut ends: Vec<f32> = candidates.into_iter().map(|(a, b)| between(a, b)).collect();
    ends.dedup();
    ends
}

/// The middle of `a` and `b`, or `a` if no number lies between them.
fn between(a: f32, b: f32) -> f32 {
    let middle = a + 0.5 * (b - a);
    if a <= middle && middle < b { middle } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_values_get_a_bin_each() {
        let column = vec![3.0, 1.0, f32::NAN, 2.0, 1.0, f32::INFINITY];
        let bins = Bins::new(&[column], &[0, 1, 2, 3, 4, 5]);
        assert_eq!(bins.codes(0), [2, 0, MISSING, 1, 0, MISSING]);
        assert_eq!((bins.bins(0), bins.end(0, 0), bins.end(0, 2)), (3, 1.5, f32::INFINITY));
    }

    #[test]
    fn ends_part_values_as_their_bins_do() {
        let column: Vec<f32> = (0..5000).map(|k| ((k * 7919) % 5000) as f32 * 1e-3 + 1e7).collect();
        let rows: Vec<u32> = (0..5000).collect();
        let bins = Bins::new(std::slice::from_ref(&column), &rows);
        assert!(bins.bins(0) <= MOST);
        for (x, code) in column.iter().zip(bins.codes(0)) {
            for bin in 0..bins.bins(0) as u8 {
                assert_eq!(*code <= bin, *x <= bins.end(0, bin));
            }
        }
    }

    #[test]
    fn bins_hold_about_equally_many() {
        let column: Vec<f32> = (0..51_000).map(|k| ((k * 7919) % 51_000) as f32).collect();
        let rows: Vec<u32> = (0..51_000).collect();
        let bins = Bins::new(std::slice::from_ref(&column), &rows);
        let mut counts = vec![0; bins.bins(0)];
        bins.codes(0).iter().for_each(|code| counts[usize::from(*code)] += 1);
        assert_eq!(counts, vec![200; 255]);
    }
}
