use kiloray_core::scene::View;
use kiloray_core::shade::Settings;

/// What a person chooses for a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The camera.
    pub view: View,
    /// Samples, bounces and seed.
    pub settings: Settings,
    /// Bytes for everything that a node holds; `None` for the file as it is and all cores.
    pub memory: Option<usize>,
    /// Threads; 0 for as many as there are cores. A node with a given memory is one thread.
    pub threads: usize,
    /// How boxes and triangles are tested.
    pub lanes: Lanes,
    /// Most rays in a batch; 0 for the default. Decides about speed only.
    pub batch: usize,
    /// How pixels are left out; `None` where all are traced.
    pub undersampling: Option<Undersampling>,
}

/// Fewer camera rays than pixels: at the corners of squares, and within only where corners differ. Between, the picture is interpolated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Undersampling {
    /// Along the squares \[pixels\]: the power of two that is not above it.
    pub spacing: u32,
    /// By how much a channel may differ between the corners of a square that is interpolated: this part of the darkest corner's brightness (its brightest
    /// channel), or of the median brightness of the first squares' upper left corners where that is more.
    pub contrast: f32,
}

impl Undersampling {
    /// Greatest squares \[pixels\].
    pub const SPACING_MAX: u32 = 32;

    /// Squares of so many pixels; `None` where each is a pixel, and all are traced.
    #[must_use]
    pub fn new(spacing: u32, contrast: f32) -> Option<Self> {
        (spacing > 1).then_some(Self { spacing, contrast })
    }
}

/// How boxes and triangles are tested. The hits are the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Lanes {
    /// As is quickest on this machine.
    #[default]
    Auto,
    /// One by one, as a small processor does.
    Scalar,
}

impl Options {
    /// A picture of a view, with all else as it is by default.
    #[must_use]
    pub fn new(width: u32, height: u32, view: View) -> Self {
        Self {
            width,
            height,
            view,
            settings: Settings::default(),
            memory: None,
            threads: 0,
            lanes: Lanes::Auto,
            batch: 0,
            undersampling: None,
        }
    }
}
