//! Rectangles in a rectangle, each with the area of its weight and as square as possible.
//!
//! M. Bruls, K. Huizing, J. J. van Wijk, "Squarified treemaps", Data Visualization 2000 (recalled, not read).

use crate::report::ranking::LoopRow;
use std::collections::BTreeMap;

/// A rectangle: left, top, width and height.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
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

/// The area of loops without one.
pub const NOWHERE: &str = "no area";
/// Height of the name of an area.
pub const NAME: f64 = 16.0;

/// An area of the plant on a map.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct AreaTile {
    /// Name.
    pub area: String,
    /// Position and size; the name takes [`NAME`] of its height.
    pub tile: Tile,
    /// Loops.
    pub loops: Vec<LoopTile>,
}

/// A loop on a map.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct LoopTile {
    /// Place in the ranking, from 0.
    pub place: usize,
    /// Tile.
    pub tile: Tile,
}

/// The name of an area, and the places and weights of its loops.
type OfArea<'a> = (&'a str, Vec<(usize, f64)>);

/// The plant on a map: areas, and loops in them, with the sizes of their weights.
pub fn map<'a>(loops: impl IntoIterator<Item = &'a LoopRow>, whole: Tile) -> Vec<AreaTile> {
    let mut areas: BTreeMap<&str, Vec<(usize, f64)>> = BTreeMap::new();
    for (place, row) in loops.into_iter().enumerate() {
        let area = row.area.as_deref().unwrap_or(NOWHERE);
        areas.entry(area).or_default().push((place, row.weight));
    }
    let weight = |loops: &[(usize, f64)]| loops.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut areas: Vec<OfArea<'_>> = areas.into_iter().collect();
    areas.sort_by(|a, b| weight(&b.1).total_cmp(&weight(&a.1)));
    let weights: Vec<f64> = areas.iter().map(|(_, loops)| weight(loops)).collect();
    let area_of = |(of, tile): (OfArea<'_>, Tile)| {
        let (area, mut loops) = of;
        // The largest first makes tiles squarer. Of equal weights the most urgent comes first.
        loops.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let within = Tile { y: tile.y + NAME, h: (tile.h - NAME).max(1.0), ..tile };
        let weights: Vec<f64> = loops.iter().map(|(_, weight)| *weight).collect();
        let tiles = loops.iter().zip(squarified(&weights, within));
        let loops = tiles.map(|((place, _), tile)| LoopTile { place: *place, tile }).collect();
        AreaTile { area: area.to_owned(), tile, loops }
    };
    areas.into_iter().zip(squarified(&weights, whole)).map(area_of).collect()
}

/// A tile of `whole` for each weight, in the order of the weights. Tiles are squarer if large weights come first.
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

/// The largest ratio of sides of the tiles in a row along `side`.
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
