//! The features of the training loops for later comparison: their quantiles and correlations.

use crate::dataset::Dataset;
use rayon::prelude::*;
use stiction_diagnose::fusion::{QUANTILES, Reference, Spread, level, row, sigmoid};

/// The most loops for correlations.
const MOST: usize = 30_000;

/// Addition to the variance of every score, so that a small difference between nearly equal features does not
/// become a large distance.
const RIDGE: f64 = 0.05;

/// The share of loops left out of training within the distance of 1.
pub const WITHIN: f64 = 0.995;

/// The reference from `rows` and `columns`. Its threshold is set on the rows `judged`.
pub fn reference(data: &Dataset, columns: &[usize], rows: &[u32], judged: &[u32]) -> Reference {
    let spreads = columns.par_iter().map(|column| spread(data, *column, rows)).collect();
    let mut reference = Reference { spreads, whitening: vec![], threshold: 1.0 };
    let scored: Vec<Vec<f64>> =
        thinned(rows, MOST).par_iter().map(|k| reference.scores(&of(data, *k))).collect();
    reference.whitening = whitening(&correlations(&scored, columns.len()));
    let mut distances: Vec<f64> =
        thinned(judged, MOST).par_iter().map(|k| reference.distance(&of(data, *k))).collect();
    distances.sort_by(f64::total_cmp);
    let place = (WITHIN * distances.len() as f64) as usize;
    if let Some(threshold) = distances.get(place.min(distances.len().saturating_sub(1))) {
        reference.threshold = threshold.max(1e-6);
    }
    reference
}

fn of(data: &Dataset, k: u32) -> Vec<f32> {
    row(&data.row(k as usize))
}

/// Some of many, at equal distances.
pub fn thinned(rows: &[u32], most: usize) -> Vec<u32> {
    let n = rows.len().min(most);
    (0..n).map(|k| rows[k * rows.len() / n]).collect()
}

fn spread(data: &Dataset, column: usize, rows: &[u32]) -> Spread {
    let mut values: Vec<f32> = rows
        .iter()
        .map(|k| data.values[column][*k as usize])
        .filter(|value| value.is_finite())
        .collect();
    values.sort_by(f32::total_cmp);
    let quantile = |k: usize| {
        let place = sigmoid(level(k)) * values.len().saturating_sub(1) as f64;
        values.get(place.round() as usize).copied().unwrap_or(f32::NAN)
    };
    Spread {
        feature: column as u16,
        missing: 1.0 - values.len() as f32 / rows.len().max(1) as f32,
        quantiles: (0..QUANTILES).map(quantile).collect(),
    }
}

/// The mean products of scores. Variances below one, as for nearly constant features, become one.
fn correlations(scored: &[Vec<f64>], n: usize) -> Vec<Vec<f64>> {
    (0..n)
        .into_par_iter()
        .map(|i| {
            let mut sums = vec![0.0; i + 1];
            for scores in scored {
                let z = scores[i];
                sums.iter_mut().zip(scores).for_each(|(sum, other)| *sum += z * other);
            }
            sums.iter_mut().for_each(|sum| *sum /= scored.len().max(1) as f64);
            sums[i] = sums[i].max(1.0) + RIDGE;
            sums
        })
        .collect()
}

/// The inverse of the Cholesky factor of a matrix given by its lower triangle, row by row.
fn whitening(matrix: &[Vec<f64>]) -> Vec<f32> {
    let n = matrix.len();
    let mut factor: Vec<Vec<f64>> = vec![];
    for i in 0..n {
        let mut line = vec![0.0; i + 1];
        for j in 0..=i {
            let above = if j < i { &factor[j][..] } else { &line[..] };
            let rest = matrix[i][j] - (0..j).map(|k| line[k] * above[k]).sum::<f64>();
            line[j] = if j < i { rest / above[j] } else { rest.max(1e-12).sqrt() };
        }
        factor.push(line);
    }
    let mut inverse: Vec<Vec<f64>> = vec![];
    for i in 0..n {
        let mut line = vec![0.0; i + 1];
        for j in 0..i {
            let sum: f64 = (j..i).map(|k| factor[i][k] * inverse[k][j]).sum();
            line[j] = -sum / factor[i][i];
        }
        line[i] = 1.0 / factor[i][i];
        inverse.push(line);
    }
    inverse.into_iter().flatten().map(|weight| weight as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    #[test]
    fn whitening_undoes_the_matrix() {
        let matrix = vec![vec![2.0], vec![0.6, 1.5], vec![-0.3, 0.2, 1.2]];
        let inverse = whitening(&matrix);
        let at = |i: usize, j: usize| f64::from(inverse[i * (i + 1) / 2 + j]);
        let full = |i: usize, j: usize| matrix[i.max(j)][i.min(j)];
        for i in 0..3 {
            for j in 0..=i {
                let found: f64 = (0..=i)
                    .flat_map(|k| (0..=j).map(move |l| (k, l)))
                    .map(|(k, l)| at(i, k) * full(k, l) * at(j, l))
                    .sum();
                assert!((found - f64::from(u8::from(i == j))).abs() < 1e-6, "{i} {j} {found}");
            }
        }
    }

    #[test]
    fn few_loops_alike_and_all_unlike_ones_are_beyond() {
        let (data, fresh) = (synthetic::dataset(1, 6000), synthetic::dataset(2, 4000));
        let columns = [0, 1, 2, 3];
        let known = reference(&data, &columns, &data.rows(0..4000), &data.rows(4000..6000));
        let known = known.checked().unwrap();
        let rows: Vec<u32> = (0..4000).collect();
        let beyond = rows.iter().filter(|k| known.distance(&of(&fresh, **k)) > 1.0).count();
        assert!((4..60).contains(&beyond), "{beyond}");
        assert!(known.distance(&[40.0, -40.0, 90.0, 30.0]) > 1.0);
        let place = known.spreads[0].place(known.spreads[0].quantile(0.3)).unwrap();
        assert!((place - 0.3).abs() < 0.01, "{place}");
    }
}
