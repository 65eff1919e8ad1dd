use crate::{Picture, PictureError, Undersampling, filled};
use kiloray_core::render::Tile;

/// The rounds over all tiles that a picture takes: one, or several with some pixels in each.
#[derive(Debug)]
pub(crate) struct Rounds {
    undersampled: Option<Undersampled>,
    /// Rounds that are done, and those that there can be.
    done: u32,
    most: u32,
}

impl Rounds {
    pub(crate) fn new(
        undersampling: Option<Undersampling>,
        picture: &Picture,
    ) -> Result<Self, PictureError> {
        let undersampled = undersampling.map(|u| Undersampled::new(u, picture)).transpose()?;
        let most = undersampled.as_ref().map_or(1, |first| first.side.ilog2() + 1);
        Ok(Self { undersampled, done: 0, most })
    }

    /// The pixels of this round, row by row from the top; `None` for all.
    pub(crate) fn wanted(&self) -> Option<&[bool]> {
        self.undersampled.as_ref().map(|round| round.wanted.as_slice())
    }

    /// Whether nothing of a tile is traced in this round.
    pub(crate) fn skips(&self, tile: Tile, width: u32) -> bool {
        let row = |y: u32| index(tile.x, y, width)..index(tile.x, y, width) + tile.width as usize;
        self.wanted().is_some_and(|wanted| {
            (tile.y..tile.y + tile.height).all(|y| !wanted[row(y)].contains(&true))
        })
    }

    /// Goes on to the next round, when all tiles of this one are in the picture: `false` at the end.
    pub(crate) fn next(&mut self, picture: &mut Picture) -> bool {
        self.done += 1;
        self.undersampled.as_mut().is_some_and(|round| round.next(picture))
    }

    /// Tiles that are done and tiles of all rounds, by those of this one.
    pub(crate) fn progress(&self, done: u32, tiles: u32) -> (u64, u64) {
        let tiles = u64::from(tiles);
        (u64::from(self.done) * tiles + u64::from(done), u64::from(self.most) * tiles)
    }

    /// How many pixels are not traced.
    pub(crate) fn interpolated(&self) -> u64 {
        let traced = self.undersampled.iter().flat_map(|last| &last.traced);
        traced.filter(|&&traced| !traced).count() as u64
    }
}

/// A picture of which only some pixels are traced: corners of squares first, then what lies between corners that differ, down to every pixel.
/// Between those that are alike it is interpolated (Radiance's `rpict -ps -pt`; Mitchell 1987).
///
/// Squares lie on a grid of the whole picture, and a traced pixel is the one of a picture in which all are traced. So neither tiles nor threads decide
/// about any bit.
#[derive(Debug)]
struct Undersampled {
    contrast: f32,
    /// The median brightness of the upper left corners of the first squares, from when they are traced.
    usual: Option<f32>,
    /// Along the squares of this round \[pixels\].
    side: u32,
    /// The upper left corners of the squares of this round: indices of pixels, row by row from the top.
    squares: Vec<u32>,
    /// What is traced in this round, and what was in any, row by row from the top.
    wanted: Vec<bool>,
    traced: Vec<bool>,
}

impl Undersampled {
    /// The first round: the corners of all squares.
    fn new(undersampling: Undersampling, picture: &Picture) -> Result<Self, PictureError> {
        let (width, height) = (picture.width, picture.height);
        let Undersampling { spacing, contrast } = undersampling;
        let side = spacing.clamp(1, Undersampling::SPACING_MAX);
        let side = 1 << side.ilog2();
        let starts = |len: u32| (0..len.saturating_sub(1).max(1)).step_by(side as usize);
        let rows = starts(height).flat_map(|y| starts(width).map(move |x| y * width + x));
        let mut first = Self {
            contrast,
            usual: None,
            side,
            squares: rows.collect(),
            wanted: filled(width, height, false)?,
            traced: filled(width, height, false)?,
        };
        first.want(picture);
        Ok(first)
    }

    /// Interpolates between corners that are alike, now that they are traced, and goes on to the next round: `false` if there is none.
    fn next(&mut self, picture: &mut Picture) -> bool {
        let usual = *self.usual.get_or_insert_with(|| {
            let corners = self.squares.iter().map(|&at| picture.pixels[at as usize]);
            median(corners.map(brightness).collect())
        });
        // Squares of one pixel have nothing between their corners.
        while self.side > 1 {
            let half = self.side / 2;
            let mut open = Vec::new();
            for at in std::mem::take(&mut self.squares) {
                let square = Square::new(at, self.side, picture);
                if square.is_alike(picture, self.contrast, usual) {
                    self.interpolate(&square, picture);
                    continue;
                }
                let Square { x, y, right, below } = square;
                let columns = [x, x + half].into_iter().filter(|&at| at == x || at < right);
                for y in [y, y + half].into_iter().filter(|&at| at == y || at < below) {
                    open.extend(columns.clone().map(|x| y * picture.width + x));
                }
            }
            (self.squares, self.side) = (open, half);
            // Those that are cut off may have no new corner.
            if self.want(picture) {
                return true;
            }
        }
        false
    }

    /// Wants the corners of all squares that are not traced yet. Returns whether there are any.
    fn want(&mut self, picture: &Picture) -> bool {
        self.wanted.fill(false);
        let mut any = false;
        for &at in &self.squares {
            for corner in Square::new(at, self.side, picture).corners(picture.width) {
                if !self.traced[corner] {
                    (self.traced[corner], self.wanted[corner], any) = (true, true, true);
                }
            }
        }
        any
    }

    /// Enters what lies between the corners of a square and is not traced.
    fn interpolate(&self, square: &Square, picture: &mut Picture) {
        let [a, b, c, d] = square.corners(picture.width).map(|at| picture.pixels[at]);
        let step = |from: u32, to: u32| 1.0 / (to - from).max(1) as f32;
        let (across, down) = (step(square.x, square.right), step(square.y, square.below));
        for y in square.y..=square.below {
            let part = (y - square.y) as f32 * down;
            let (left, right) = (between(a, c, part), between(b, d, part));
            let row = index(square.x, y, picture.width)..=index(square.right, y, picture.width);
            let pixels = picture.pixels[row.clone()].iter_mut().zip(&self.traced[row]);
            for (x, (pixel, _)) in pixels.enumerate().filter(|(_, (_, traced))| !**traced) {
                *pixel = between(left, right, x as f32 * across);
            }
        }
    }
}

/// A square, cut off at the picture's last column and row, and without width or height where these are the first.
struct Square {
    x: u32,
    y: u32,
    right: u32,
    below: u32,
}

impl Square {
    fn new(at: u32, side: u32, picture: &Picture) -> Self {
        let (x, y) = (at % picture.width, at / picture.width);
        let (right, below) =
            ((x + side).min(picture.width - 1), (y + side).min(picture.height - 1));
        Self { x, y, right, below }
    }

    /// Indices of its corners, the upper ones first.
    fn corners(&self, width: u32) -> [usize; 4] {
        let &Self { x, y, right, below } = self;
        [(x, y), (right, y), (x, below), (right, below)].map(|(x, y)| index(x, y, width))
    }

    /// Whether no channel differs from corner to corner by more than this part of the darkest corner's brightness, or of the `usual` one where that is more.
    fn is_alike(&self, picture: &Picture, contrast: f32, usual: f32) -> bool {
        let corners = self.corners(picture.width).map(|at| picture.pixels[at]);
        let darkest = corners.map(brightness).into_iter().fold(f32::INFINITY, f32::min);
        let most = contrast * darkest.max(usual);
        (0..3).all(|channel| {
            let values = corners.map(|corner| corner[channel]);
            let low = values.into_iter().fold(f32::INFINITY, f32::min);
            let high = values.into_iter().fold(f32::NEG_INFINITY, f32::max);
            high - low <= most
        })
    }
}

/// The brightest channel.
fn brightness([r, g, b]: [f32; 3]) -> f32 {
    r.max(g).max(b)
}

fn median(mut of: Vec<f32>) -> f32 {
    let middle = of.len() / 2;
    of.select_nth_unstable_by(middle, f32::total_cmp);
    of[middle]
}

fn index(x: u32, y: u32, width: u32) -> usize {
    y as usize * width as usize + x as usize
}

fn between(from: [f32; 3], to: [f32; 3], part: f32) -> [f32; 3] {
    std::array::from_fn(|i| from[i] * (1.0 - part) + to[i] * part)
}
