//! A view fitted to a picture: pixels stay square.

use kiloray_core::scene::{View, ViewKind};

/// Width over height of what the view shows; 1 where that is no number.
#[must_use]
pub fn aspect(view: &View) -> f64 {
    let [width, height] = extent(view);
    let aspect = width / height;
    if aspect.is_finite() && aspect > 0.0 { aspect } else { 1.0 }
}

/// The view widened, to the sides or up and down, so that a picture of this size has square pixels;
/// all that it showed is still in the picture.
#[must_use]
pub fn fitted(mut view: View, width: u32, height: u32) -> View {
    let [right, up] = extent(&view);
    let wanted = f64::from(width) / f64::from(height);
    // A rounded size is no other shape.
    if (wanted / aspect(&view) - 1.0).abs() <= 1.0 / f64::from(width.min(height)) {
        return view;
    }
    // Shift and lift are in widths and heights of the picture.
    if wanted > right / up {
        view.offset[0] = (f64::from(view.offset[0]) * (right / up) / wanted) as f32;
        view.size[0] = size(&view, up * wanted);
    } else {
        view.offset[1] = (f64::from(view.offset[1]) * wanted / (right / up)) as f32;
        view.size[1] = size(&view, right / wanted);
    }
    view
}

/// Width and height of the picture, for a perspective at distance ½.
fn extent(view: &View) -> [f64; 2] {
    view.size.map(|size| {
        let size = f64::from(size);
        // By our own libm: the view, and so the picture, is the same on every machine.
        if is_parallel(view) { size } else { libm::tan(size.to_radians() / 2.0) }
    })
}

fn size(view: &View, extent: f64) -> f32 {
    let size = if is_parallel(view) { extent } else { 2.0 * libm::atan(extent).to_degrees() };
    size as f32
}

fn is_parallel(view: &View) -> bool {
    view.kind == ViewKind::Parallel as u32
}
