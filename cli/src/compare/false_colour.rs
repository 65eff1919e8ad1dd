/// Least relative error that shows.
const LEAST: f64 = 1e-3;

/// 8-bit RGB of the worst relative error of each pixel, on a logarithmic scale from 0.1 % to 100 %;
/// the colours (matplotlib's inferno) are even to the eye, dark to bright.
pub(crate) fn false_colour(errors: &[[f64; 3]]) -> Vec<u8> {
    errors
        .iter()
        .flat_map(|&[r, g, b]| {
            let worst = r.max(g).max(b);
            let part = (worst / LEAST).log10() / -LEAST.log10();
            // What is no number is the worst; 0 has the logarithm -inf.
            let part =
                if [r, g, b].iter().any(|e| e.is_nan()) { 1.0 } else { part.clamp(0.0, 1.0) };
            let colour = colorous::INFERNO.eval_continuous(part);
            [colour.r, colour.g, colour.b]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worse_is_brighter() {
        let sum =
            |e: f64| -> u32 { false_colour(&[[e, 0.0, 0.0]]).iter().map(|&c| u32::from(c)).sum() };
        assert_eq!(sum(0.0), sum(0.0009));
        assert!(sum(0.002) > sum(0.001) && sum(0.5) > sum(0.1));
        assert_eq!(sum(1.0), sum(50.0));
        assert_eq!(sum(f64::NAN), sum(1.0));
    }
}
