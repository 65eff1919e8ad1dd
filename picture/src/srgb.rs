/// IEC 61966-2-1, clipped to [0, 1]; no number is black.
#[must_use]
pub fn encode(linear: f64) -> f64 {
    // In this order a NaN becomes 0.
    let x = f64::min(1.0, linear.max(0.0));
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`encode`].
#[must_use]
pub fn decode(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_survives_the_way_back() {
        for i in 0..=255u8 {
            let linear = decode(f64::from(i) / 255.0);
            assert!((encode(linear) * 255.0 - f64::from(i)).abs() < 1e-3);
        }
    }
}
