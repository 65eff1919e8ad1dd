use serde::Serialize;

use crate::picture::Picture;

/// Error measures over some pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Measures {
    /// Pixels that count.
    pub(crate) pixels: u64,
    /// Mean of the image over the mean of the reference.
    pub(crate) mean_ratio: f64,
    /// The same for red, green and blue.
    pub(crate) mean_ratio_rgb: [f64; 3],
    /// Root of the mean squared difference, over channels.
    pub(crate) rmse: f64,
    /// RMSE over the mean of the reference.
    pub(crate) relative_rmse: f64,
    /// Relative error that half of the channels do not exceed.
    pub(crate) p50: f64,
    /// .. nine tenths.
    pub(crate) p90: f64,
    /// .. 99 of 100.
    pub(crate) p99: f64,
    /// The greatest relative error.
    pub(crate) max: f64,
}

/// Relative error of each channel: |image - reference| over the reference, but at least 1 % of its mean.
pub(crate) fn relative_errors(reference: &Picture, image: &Picture) -> Vec<[f64; 3]> {
    let floor = 0.01 * mean(reference.pixels.iter());
    let pairs = reference.pixels.iter().zip(&image.pixels);
    pairs
        .map(|(r, i)| {
            std::array::from_fn(|c| {
                let (r, i) = (f64::from(r[c]), f64::from(i[c]));
                // 0 for 0, also in a black picture.
                if r == i { 0.0 } else { (i - r).abs() / r.max(floor) }
            })
        })
        .collect()
}

/// Measures over the pixels for which `mask` is true; `None` if there is none.
pub(crate) fn measure(reference: &Picture, image: &Picture, mask: &[bool]) -> Option<Measures> {
    let count = mask.iter().filter(|&&m| m).count();
    if count == 0 {
        return None;
    }
    let chosen = || (0..mask.len()).filter(|&i| mask[i]);
    let squares: f64 = chosen()
        .flat_map(|i| reference.pixels[i].into_iter().zip(image.pixels[i]))
        .map(|(r, i)| (f64::from(i) - f64::from(r)).powi(2))
        .sum();
    let rmse = (squares / (3 * count) as f64).sqrt();
    let sum = |picture: &Picture, c: usize| -> f64 {
        chosen().map(|i| f64::from(picture.pixels[i][c])).sum()
    };
    let [r, g, b] = [0, 1, 2].map(|c| (sum(image, c), sum(reference, c)));
    let (of_image, of_reference) = (r.0 + g.0 + b.0, r.1 + g.1 + b.1);

    let errors = relative_errors(reference, image);
    let mut sorted: Vec<f64> = chosen().flat_map(|i| errors[i]).collect();
    sorted.sort_by(f64::total_cmp);
    Some(Measures {
        pixels: count as u64,
        mean_ratio: ratio(of_image, of_reference),
        mean_ratio_rgb: [r, g, b].map(|(image, reference)| ratio(image, reference)),
        rmse,
        relative_rmse: if rmse == 0.0 { 0.0 } else { rmse / (of_reference / (3 * count) as f64) },
        p50: percentile(&sorted, 0.50),
        p90: percentile(&sorted, 0.90),
        p99: percentile(&sorted, 0.99),
        max: percentile(&sorted, 1.0),
    })
}

/// Nothing is as much as nothing.
fn ratio(image: f64, reference: f64) -> f64 {
    if image == reference { 1.0 } else { image / reference }
}

/// Linear between the two nearest ranks; `sorted` is not empty.
fn percentile(sorted: &[f64], part: f64) -> f64 {
    let rank = part * (sorted.len() - 1) as f64;
    let (low, high) = (sorted[rank.floor() as usize], sorted[rank.ceil() as usize]);
    if low == high { low } else { low + (high - low) * rank.fract() }
}

/// Over all channels.
pub(super) fn mean<'a>(pixels: impl ExactSizeIterator<Item = &'a [f32; 3]>) -> f64 {
    let count = (3 * pixels.len()) as f64;
    pixels.flatten().map(|&c| f64::from(c)).sum::<f64>() / count
}
