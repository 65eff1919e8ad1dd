use plotters::style::RGBColor;

/// Stands for the colour of text in what plotters draws; [`themed`] replaces it.
pub(super) const INK: RGBColor = RGBColor(1, 2, 3);

/// Colours of series that can be told apart, by the colour-blind as well, on white and on black (Okabe & Ito).
pub(crate) const SERIES: [RGBColor; 8] = [
    RGBColor(0x1f, 0x83, 0xc4),
    RGBColor(0xe6, 0x7e, 0x22),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0x8a, 0x7d, 0x5a),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x9a, 0x6f, 0xd8),
];

/// Steps of the colours of a map: few enough to group cells by them.
pub(super) const STEPS: usize = 48;

/// A colour as it is written in HTML.
pub(crate) fn css(color: RGBColor) -> String {
    let RGBColor(r, g, b) = color;
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The colour of a value from 0 to 1, by its step.
pub(crate) fn heat(value: f64) -> (usize, String) {
    let step = (value.clamp(0.0, 1.0) * (STEPS - 1) as f64).round() as usize;
    let colour = colorous::VIRIDIS.eval_continuous(step as f64 / (STEPS - 1) as f64);
    (step, format!("#{colour:x}"))
}

/// The drawing with the colour of the text around it.
pub(super) fn themed(svg: &str) -> String {
    // A number with more decimals than can be seen is longer only.
    svg.replace("\"#010203\"", "\"currentColor\"").replace(" opacity=\"1\"", "")
}
