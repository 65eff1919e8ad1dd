//! A view fitted to a picture shows all that it showed.

use kiloray_core::scene::{View, ViewKind};
use kiloray_render::framing::fitted;

fn view(kind: ViewKind, size: [f32; 2]) -> View {
    View {
        kind: kind as u32,
        name: [0; 20],
        position: [0.0; 3],
        direction: [0.0, 1.0, 0.0],
        up: [0.0, 0.0, 1.0],
        size,
        offset: [0.0; 2],
        clip: [0.0; 2],
    }
}

#[test]
fn a_wider_picture_shows_more_at_the_sides() {
    // tan 45° twice is tan 63.435°.
    let wide = fitted(view(ViewKind::Perspective, [90.0, 90.0]), 200, 100);
    assert!((wide.size[0] - 126.869_9).abs() < 1e-3 && wide.size[1] == 90.0);
    let tall = fitted(view(ViewKind::Parallel, [2.0, 1.0]), 100, 100);
    assert_eq!(tall.size, [2.0, 2.0]);
    assert_eq!(fitted(view(ViewKind::Parallel, [3.0, 2.0]), 300, 200).size, [3.0, 2.0]);
}

#[test]
fn what_a_shifted_view_shows_stays_in_the_middle() {
    let offset = [1.0, -0.5];
    let shifted = View { offset, ..view(ViewKind::Parallel, [1.0, 1.0]) };
    let (wide, tall) = (fitted(shifted, 200, 100), fitted(shifted, 100, 200));
    assert_eq!((wide.size, wide.offset), ([2.0, 1.0], [0.5, -0.5]));
    assert_eq!((tall.size, tall.offset), ([1.0, 2.0], [1.0, -0.25]));
}

#[test]
fn rounding_to_pixels_changes_nothing() {
    let view = view(ViewKind::Parallel, [1.6, 1.0]);
    assert_eq!(fitted(view, 512, 320), view);
    assert_eq!(fitted(view, 100, 63), view);
}
