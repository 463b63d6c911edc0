//! Rectangles in a rectangle, each as large as it weighs and as square as can be.
//!
//! M. Bruls, K. Huizing, J. J. van Wijk, "Squarified treemaps", Data Visualization 2000 (recalled, not read).

/// A rectangle: left, top, width and height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tile {
    /// Left.
    pub x: f64,
    /// Top.
    pub y: f64,
    /// Width.
    pub w: f64,
    /// Height.
    pub h: f64,
}

/// A tile of `whole` for each weight, in the order of the weights; they are the squarer the larger weights come first.
/// All weights must be above 0.
pub fn squarified(weights: &[f64], whole: Tile) -> Vec<Tile> {
    let scale = whole.w * whole.h / weights.iter().sum::<f64>();
    let areas: Vec<f64> = weights.iter().map(|weight| weight * scale).collect();
    let mut tiles = vec![];
    let mut left = whole;
    let mut begin = 0;
    while begin < areas.len() {
        let side = left.w.min(left.h).max(f64::MIN_POSITIVE);
        let mut end = begin + 1;
        while end < areas.len()
            && worst(&areas[begin..=end], side) <= worst(&areas[begin..end], side)
        {
            end += 1;
        }
        let row = &areas[begin..end];
        let total: f64 = row.iter().sum();
        let depth = total / side;
        let mut at = 0.0;
        for area in row {
            let length = area / depth;
            tiles.push(match left.w >= left.h {
                true => Tile { x: left.x, y: left.y + at, w: depth, h: length },
                false => Tile { x: left.x + at, y: left.y, w: length, h: depth },
            });
            at += length;
        }
        left = match left.w >= left.h {
            true => Tile { x: left.x + depth, w: (left.w - depth).max(0.0), ..left },
            false => Tile { y: left.y + depth, h: (left.h - depth).max(0.0), ..left },
        };
        begin = end;
    }
    tiles
}

/// How far from square the worst tile of a row along `side` is.
fn worst(row: &[f64], side: f64) -> f64 {
    let total: f64 = row.iter().sum();
    let ratio = |area: &f64| {
        let (a, b) = (side * side * area, total * total);
        (a / b).max(b / a)
    };
    row.iter().map(ratio).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_fill_the_whole_each_by_its_weight() {
        let whole = Tile { x: 10.0, y: 5.0, w: 600.0, h: 400.0 };
        let weights = [6.0, 6.0, 4.0, 3.0, 2.0, 2.0, 1.0];
        let tiles = squarified(&weights, whole);
        assert_eq!(tiles.len(), 7);
        for (tile, weight) in tiles.iter().zip(weights) {
            assert!((tile.w * tile.h - weight * 10_000.0).abs() < 1e-6);
            assert!(tile.x >= 10.0 - 1e-9 && tile.x + tile.w <= 610.0 + 1e-9);
            assert!(tile.y >= 5.0 - 1e-9 && tile.y + tile.h <= 405.0 + 1e-9);
            assert!((tile.w / tile.h).max(tile.h / tile.w) < 3.0, "{tile:?}");
        }
        assert_eq!(squarified(&[], whole), []);
        assert_eq!(squarified(&[2.0], whole), [whole]);
    }
}
