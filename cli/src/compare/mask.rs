use crate::picture::{Picture, luminance};

/// Pixels whose 3 × 3 neighbourhood varies by less than `edge` (greatest less least luminance, over
/// the greatest) and stays below ten times the mean: without silhouettes and visible lamps, where
/// the pixel filter decides and not the light.
pub(crate) fn smooth(reference: &Picture, edge: f64) -> Vec<bool> {
    let (width, height) = (reference.width as usize, reference.height as usize);
    let bright: Vec<f64> = reference.pixels.iter().map(|&p| luminance(p)).collect();
    let mean = bright.iter().sum::<f64>() / bright.len() as f64;
    let near = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
    let mut mask = Vec::with_capacity(bright.len());
    for y in 0..height {
        for x in 0..width {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for j in near(y, height) {
                for i in near(x, width) {
                    low = low.min(bright[j * width + i]);
                    high = high.max(bright[j * width + i]);
                }
            }
            mask.push(high - low < edge * high.max(0.01 * mean) && high < 10.0 * mean);
        }
    }
    mask
}

/// Pixels brighter than one half.
pub(crate) fn bright(mask: &Picture) -> Vec<bool> {
    mask.pixels.iter().map(|&p| luminance(p) > 0.5).collect()
}
