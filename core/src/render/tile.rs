use super::shuffle::shuffled;

/// A picture in square tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tiling {
    width: u32,
    height: u32,
    side: u32,
    columns: u32,
    rows: u32,
}

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tile {
    /// Left column.
    pub x: u32,
    /// Upper row.
    pub y: u32,
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
}

impl Tiling {
    /// Greatest side of a tile: the index of a pixel in it has 16 bits.
    pub const SIDE_MAX: u32 = 256;

    /// A picture of `width × height` pixels in tiles of `side × side`, those at the right and lower edge smaller.
    #[must_use]
    pub const fn new(width: u32, height: u32, side: u32) -> Self {
        let side = if side == 0 { 1 } else { side };
        Self { width, height, side, columns: width.div_ceil(side), rows: height.div_ceil(side) }
    }

    /// Width of the picture \[pixels\].
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Number of tiles.
    #[must_use]
    pub const fn len(&self) -> u32 {
        self.columns.saturating_mul(self.rows)
    }

    /// Whether the picture has no pixel.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Tiles that follow one another in the [random order](Self::shuffled): a square of two by two.
    pub const RUN: u32 = 4;

    /// Tile `index`: by bands of two rows, each column down or up, every second band from right to left, so that a tile lies beside
    /// the one before it, and finds its blocks in the cache.
    #[must_use]
    pub fn tile(&self, index: u32) -> Option<Tile> {
        if index >= self.len() {
            return None;
        }
        let band = self.columns.saturating_mul(2);
        let (above, at) = (index.checked_div(band)?.wrapping_mul(2), index.checked_rem(band)?);
        let is_whole = above.wrapping_add(1) < self.rows;
        let (column, below) = if is_whole { (at / 2, at.div_ceil(2) & 1) } else { (at, 0) };
        let is_forth = above.is_multiple_of(4);
        let column =
            if is_forth { column } else { self.columns.wrapping_sub(1).wrapping_sub(column) };
        let row = above.wrapping_add(below);
        let (x, y) = (column.wrapping_mul(self.side), row.wrapping_mul(self.side));
        let width = self.width.saturating_sub(x).min(self.side);
        let height = self.height.saturating_sub(y).min(self.side);
        Some(Tile { x, y, width, height })
    }

    /// The tile at a place of a seeded random order, so that parts of the picture go to nodes all over the mesh, at different times
    /// (dissertation 4.3): of runs of [`RUN`](Self::RUN) tiles at first, so that who takes one finds the blocks of one tile in the cache for the
    /// next, and of tiles at the end, so that dear neighbours do not come last together. Anyone can compute it; O(1) on average, and no table.
    #[must_use]
    pub fn shuffled(&self, place: u32, seed: u64) -> Option<Tile> {
        let (len, runs) = (self.len(), self.len() / Self::RUN);
        let single = (runs - runs / 4) * Self::RUN;
        let place = match place.checked_sub(single) {
            Some(place) => single + shuffled(place, len - single, !seed)?,
            None => place,
        };
        let run = shuffled(place / Self::RUN, runs, seed);
        self.tile(run.map_or(place, |run| run * Self::RUN + place % Self::RUN))
    }
}

/// A camera ray of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Place {
    /// Column in the picture.
    pub(crate) x: u32,
    /// Row in the picture.
    pub(crate) y: u32,
    /// Index of the pixel in the tile, row by row.
    pub(crate) pixel: u16,
    /// The camera sample.
    pub(crate) sample: u32,
}

/// The camera rays of a tile: squares of 4 × 4 pixels, in each sample by sample. So 64 in a row are 16 neighbouring
/// pixels, and their rays stay close together from the eye to the lights.
#[derive(Debug, Clone)]
pub(crate) struct Places {
    tile: Tile,
    samples: u32,
    /// Square, sample and pixel of the square that come next.
    square: u32,
    sample: u32,
    at: u32,
    /// Where the square lies in the tile.
    x: u32,
    y: u32,
}

/// Pixels along a square.
const SQUARE: u32 = 4;

impl Places {
    pub(super) const fn new(tile: Tile, samples: u32) -> Self {
        Self::resume(tile, samples, [0; 3])
    }

    /// Goes on from a [`state`](Self::state).
    pub(crate) const fn resume(tile: Tile, samples: u32, [square, sample, at]: [u32; 3]) -> Self {
        let columns = tile.width.div_ceil(SQUARE);
        let (row, column) = match (square.checked_div(columns), square.checked_rem(columns)) {
            (Some(row), Some(column)) => (row, column),
            _ => (u32::MAX, 0),
        };
        let (x, y) = (column.saturating_mul(SQUARE), row.saturating_mul(SQUARE));
        Self { tile, samples, square, sample, at, x, y }
    }

    /// Where it is.
    pub(crate) const fn state(&self) -> [u32; 3] {
        [self.square, self.sample, self.at]
    }

    /// Goes on at the next of these pixels of the square, or behind it: `false`.
    fn pass_to(&mut self, pixels: u16) -> bool {
        let left = pixels.unbounded_shr(self.at);
        if left == 0 {
            self.at = 0;
            self.step();
            return false;
        }
        self.at = self.at.wrapping_add(left.trailing_zeros());
        true
    }

    /// Goes on behind the last pixel of a square.
    fn step(&mut self) {
        self.sample = self.sample.wrapping_add(1);
        if self.sample < self.samples {
            return;
        }
        self.sample = 0;
        self.square = self.square.wrapping_add(1);
        self.x = self.x.wrapping_add(SQUARE);
        if self.x >= self.tile.width {
            (self.x, self.y) = (0, self.y.wrapping_add(SQUARE));
        }
    }
}

impl Iterator for Places {
    type Item = Place;

    #[cfg_attr(feature = "bundles", inline(always))]
    fn next(&mut self) -> Option<Place> {
        while self.y < self.tile.height && self.samples > 0 {
            // Two rows of two in each quarter: a Morton curve.
            let (x, y) = (self.at & 1 | self.at >> 1 & 2, self.at >> 1 & 1 | self.at >> 2 & 2);
            let (x, y) = (self.x.wrapping_add(x), self.y.wrapping_add(y));
            let sample = self.sample;
            self.at = self.at.wrapping_add(1) % (SQUARE * SQUARE);
            if self.at == 0 {
                self.step();
            }
            if x < self.tile.width && y < self.tile.height {
                let pixel = y.wrapping_mul(self.tile.width).wrapping_add(x) as u16;
                let (x, y) = (self.tile.x.wrapping_add(x), self.tile.y.wrapping_add(y));
                return Some(Place { x, y, pixel, sample });
            }
        }
        None
    }
}

/// Where the columns of a square stand on its curve, and the rows.
const COLUMNS: [u16; 4] = [0, 1, 4, 5];
const ROWS: [u16; 4] = [0, 2, 8, 10];

/// Those of some pixels of the picture.
#[derive(Debug, Clone)]
pub(super) struct SomePlaces<'o> {
    places: Places,
    /// Whether a pixel is among them, row by row from the picture's top; `None` for all.
    only: Option<&'o [bool]>,
    /// Columns of the picture.
    width: u32,
    /// Which pixels of a square are, as bits by their place on its curve.
    square: Option<u32>,
    pixels: u16,
}

impl<'o> SomePlaces<'o> {
    pub(super) const fn new(places: Places, only: Option<&'o [bool]>, width: u32) -> Self {
        Self { places, only, width, square: None, pixels: 0 }
    }

    /// The pixels of the square that comes next.
    fn pixels(&self, only: &[bool]) -> u16 {
        let Places { tile, x, y, .. } = self.places;
        let columns = tile.width.saturating_sub(x).min(SQUARE) as usize;
        let first = tile.y.wrapping_add(y).wrapping_mul(self.width);
        let mut begin = first.wrapping_add(tile.x).wrapping_add(x);
        let mut pixels = 0;
        for (_, row) in (y..tile.height).zip(ROWS) {
            let begins = only.get(begin as usize..).unwrap_or_default();
            for (&is_wanted, column) in begins.iter().take(columns).zip(COLUMNS) {
                pixels |= u16::from(is_wanted) << (row + column);
            }
            begin = begin.wrapping_add(self.width);
        }
        pixels
    }
}

impl Iterator for SomePlaces<'_> {
    type Item = Place;

    #[cfg_attr(feature = "bundles", inline(always))]
    fn next(&mut self) -> Option<Place> {
        let Some(only) = self.only else { return self.places.next() };
        while self.places.y < self.places.tile.height {
            if self.square != Some(self.places.square) {
                (self.square, self.pixels) = (Some(self.places.square), self.pixels(only));
            }
            if self.places.pass_to(self.pixels) {
                return self.places.next();
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pixels_of_the_greatest_tile_have_names_of_their_own() {
        let tile = Tiling::new(1000, 1000, Tiling::SIDE_MAX).tile(0).unwrap();
        let mut seen = [false; 1 << 16];
        for place in Places::new(tile, 1) {
            assert!(!std::mem::replace(&mut seen[usize::from(place.pixel)], true));
        }
        assert!(!seen.contains(&false));
    }

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (width, height, side) in [(1, 1, 8), (17, 9, 4), (64, 64, 32), (5, 40, 1), (0, 7, 8)] {
            let tiling = Tiling::new(width, height, side);
            let mut seen = std::collections::BTreeSet::new();
            for tile in (0..tiling.len()).map(|i| tiling.tile(i).unwrap()) {
                for y in 0..tile.height {
                    for x in 0..tile.width {
                        assert!(seen.insert((tile.x + x, tile.y + y)));
                    }
                }
            }
            assert_eq!(seen.len() as u32, width * height);
            assert!(seen.iter().all(|&(x, y)| x < width && y < height));
            assert_eq!(tiling.tile(tiling.len()), None);
        }
    }

    #[test]
    fn a_random_order_has_every_tile_once() {
        let tiling = Tiling::new(50, 31, 8);
        let corner = |tile: Tile| (tile.x, tile.y);
        let tiles = |by: &dyn Fn(u32) -> Option<Tile>| -> Vec<_> {
            (0..tiling.len()).map(|place| corner(by(place).unwrap())).collect()
        };
        let mut shuffled = tiles(&|place| tiling.shuffled(place, 7));
        let mut all = tiles(&|place| tiling.tile(place));
        assert_ne!(shuffled, all);
        shuffled.sort_unstable();
        all.sort_unstable();
        assert_eq!(shuffled, all);
        assert_eq!(tiling.shuffled(tiling.len(), 7), None);
    }

    #[test]
    fn neighbours_in_order_are_neighbours_in_the_picture() {
        for (height, rows) in [(30, 4), (40, 5), (8, 1)] {
            let tiling = Tiling::new(50, height, 8);
            let tiles: Vec<_> = (0..tiling.len()).map(|i| tiling.tile(i).unwrap()).collect();
            assert_eq!(tiles.len(), 7 * rows);
            for (pair, index) in tiles.windows(2).zip(1..) {
                let apart = pair[0].x.abs_diff(pair[1].x) + pair[0].y.abs_diff(pair[1].y);
                assert!(apart == 8 || apart == 16 && index % 14 == 0, "{index} of {height}");
            }
        }
    }

    #[test]
    fn a_random_order_is_of_squares_and_of_single_tiles_at_the_end() {
        let tiling = Tiling::new(64, 48, 8);
        let tiles: Vec<_> = (0..48).map(|place| tiling.shuffled(place, 3).unwrap()).collect();
        let is_square = |run: &[Tile]| {
            run.iter().all(|tile| (tile.x / 16, tile.y / 16) == (run[0].x / 16, run[0].y / 16))
        };
        let squares: Vec<_> = tiles.chunks(Tiling::RUN as usize).map(is_square).collect();
        assert_eq!(squares, [[true; 9].as_slice(), &[false; 3]].concat());
    }

    #[test]
    fn places_are_all_samples_of_all_pixels_in_small_squares() {
        for (width, height, samples) in [(8, 8, 4), (3, 5, 1), (1, 1, 7), (10, 4, 2)] {
            let tile = Tile { x: 100, y: 200, width, height };
            let places: Vec<_> = Places::new(tile, samples).collect();
            let mut rest = Places::new(tile, samples);
            for at in 0..=places.len() {
                let resumed = Places::resume(tile, samples, rest.state());
                assert!(resumed.eq(places[at..].iter().copied()));
                rest.next();
            }
            let all: std::collections::BTreeSet<_> =
                places.iter().map(|p| (p.x, p.y, p.sample)).collect();
            assert_eq!(all.len() as u32, width * height * samples);
            assert_eq!(places.len(), all.len());
            for p in places {
                let (x, y) = (p.x - 100, p.y - 200);
                assert!(x < width && y < height && p.sample < samples);
                assert_eq!(u32::from(p.pixel), y * width + x);
            }
        }
        let tile = Tile { x: 0, y: 0, width: 8, height: 8 };
        assert_eq!(Places::resume(tile, 4, [u32::MAX; 3]).next(), None);
        for bundle in Places::new(tile, 4).collect::<Vec<_>>().chunks(64) {
            assert!(
                bundle.iter().all(|p| p.x / 4 == bundle[0].x / 4 && p.y / 4 == bundle[0].y / 4)
            );
        }
    }

    #[test]
    fn some_places_come_in_the_order_of_all() {
        let tile = Tile { x: 3, y: 2, width: 10, height: 9 };
        let width = 15;
        for keep in [0, 1, 3, 7, 50, 1000] {
            let pixels: Vec<_> = (0..width * 12_u32).map(|i| i * 7919 % 1000 < keep).collect();
            let some = SomePlaces::new(Places::new(tile, 2), Some(&pixels), width);
            let of_all = Places::new(tile, 2).filter(|p| pixels[(p.y * width + p.x) as usize]);
            assert!(some.eq(of_all), "{keep}");
        }
        for (samples, only) in [(2, [].as_slice()), (0, &[true; 180])] {
            let none = SomePlaces::new(Places::new(tile, samples), Some(only), width);
            assert_eq!(none.count(), 0);
        }
    }
}
