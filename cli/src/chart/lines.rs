use plotters::{
    prelude::*,
    style::{FontFamily, TextStyle},
};

use super::ink::{INK, SERIES, themed};

/// A chart of values over something that grows.
#[derive(Debug)]
pub(crate) struct Lines<'a> {
    pub(crate) title: &'a str,
    pub(crate) x: Scale,
    /// What is across, with its unit.
    pub(crate) x_name: &'a str,
    /// What is up, with its unit.
    pub(crate) y_name: &'a str,
    /// From zero evenly, or doubling from the least.
    pub(crate) y: Scale,
    /// The top; as high as the lines if `None`.
    pub(crate) y_max: Option<f64>,
    pub(crate) lines: Vec<Line>,
    pub(crate) size: [u32; 2],
    /// It stands in a file of its own, and brings its colours.
    pub(crate) alone: bool,
}

/// A line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    pub(crate) name: String,
    pub(crate) mark: Mark,
    pub(crate) colour: usize,
    pub(crate) points: Vec<(f64, f64)>,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mark {
    Line,
    /// A line with a dot at each point.
    Dots,
    /// Filled to the bottom.
    Area,
    /// For comparison: thin, in the colour of the text.
    Thin,
}

/// What the places across mean.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Scale {
    Even,
    /// Doubling; labels are numbers with what follows them.
    Doubling,
    /// Names, at 0, 1, 2, ..
    Names(Vec<String>),
}

impl Scale {
    fn place(&self, x: f64) -> f64 {
        if *self == Self::Doubling { x.max(f64::MIN_POSITIVE).log2() } else { x }
    }

    fn label(&self, place: f64) -> String {
        let whole = (place - place.round()).abs() < 1e-6;
        match self {
            Self::Even => short(place),
            Self::Doubling if whole => short(place.round().exp2()),
            Self::Names(names) if whole && place >= 0.0 => {
                names.get(place.round() as usize).cloned().unwrap_or_default()
            }
            Self::Doubling | Self::Names(_) => String::new(),
        }
    }
}

/// A number with no more figures than it needs.
fn short(x: f64) -> String {
    match x.abs() {
        a if a >= 1e9 => format!("{} G", short(x / 1e9)),
        a if a >= 1e6 => format!("{} M", short(x / 1e6)),
        a if a >= 1e5 => format!("{} k", short(x / 1e3)),
        _ => {
            let text = format!("{x:.3}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
    }
}

impl Lines<'_> {
    /// Draws it; empty if there is nothing to draw.
    pub(crate) fn svg(&self) -> String {
        let mut svg = String::new();
        // Drawing to a string fails where the picture has no room for its axes.
        if self.draw(&mut svg).is_err() {
            return String::new();
        }
        let svg = themed(&svg);
        if !self.alone {
            return svg;
        }
        const STYLE: &str = "<style>svg{color:#222;background:#fff}@media(prefers-color-scheme:dark){svg{color:#ddd;background:#161618}}</style>";
        match svg.find('>') {
            Some(end) => format!("{}{STYLE}{}", &svg[..=end], &svg[end + 1..]),
            None => svg,
        }
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error + '_>> {
        let is_shown = |p: &&(f64, f64)| p.1.is_finite() && (self.y == Scale::Even || p.1 > 0.0);
        let all = || self.lines.iter().flat_map(|line| &line.points).filter(is_shown);
        let xs = || all().map(|p| self.x.place(p.0));
        let (left, right) =
            (xs().fold(f64::INFINITY, f64::min), xs().fold(f64::NEG_INFINITY, f64::max));
        if left > right {
            return Err("no points".into());
        }
        let margin = match self.x {
            Scale::Names(_) => 0.3,
            _ if left == right => 0.5,
            Scale::Doubling => 0.15,
            Scale::Even => 0.0,
        };
        let ys = || all().map(|p| self.y.place(p.1));
        let highest = ys().fold(f64::NEG_INFINITY, f64::max);
        let (bottom, top) = match self.y {
            Scale::Even => (0.0, self.y_max.unwrap_or(highest * 1.06)),
            _ => ((ys().fold(f64::INFINITY, f64::min) + 0.1).floor(), highest + 0.2),
        };
        let top = if top > bottom { top } else { bottom + 1.0 };

        let root = SVGBackend::with_string(svg, self.size.into()).into_drawing_area();
        let font =
            |size: i32| TextStyle::from((FontFamily::SansSerif, size).into_font()).color(&INK);
        let mut builder = ChartBuilder::on(&root);
        builder.margin(8).margin_right(16).x_label_area_size(42).y_label_area_size(58);
        if !self.title.is_empty() {
            builder.caption(self.title, font(16));
        }
        let mut chart = builder.build_cartesian_2d(left - margin..right + margin, bottom..top)?;
        let places = match &self.x {
            Scale::Even => 8,
            _ => ((right - left) as usize + 1).clamp(2, 16),
        };
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(INK.mix(0.12))
            .axis_style(INK.mix(0.5))
            .label_style(font(12))
            .axis_desc_style(font(13))
            .x_desc(self.x_name)
            .y_desc(self.y_name)
            .x_labels(places)
            .y_labels(if self.y == Scale::Even { 6 } else { (top - bottom) as usize + 1 })
            .x_label_formatter(&|x| self.x.label(*x))
            .y_label_formatter(&|y| self.y.label(*y))
            .draw()?;
        for line in &self.lines {
            let colour =
                if line.mark == Mark::Thin { INK } else { SERIES[line.colour % SERIES.len()] };
            let points: Vec<_> = line
                .points
                .iter()
                .filter(is_shown)
                .map(|&(x, y)| (self.x.place(x), self.y.place(y).min(top)))
                .collect();
            let style = match line.mark {
                Mark::Thin => INK.mix(0.4).stroke_width(1),
                _ => colour.stroke_width(2),
            };
            let drawn = match line.mark {
                Mark::Area => {
                    chart.draw_series(AreaSeries::new(points, bottom, colour.mix(0.85)))?
                }
                _ => {
                    if line.mark == Mark::Dots {
                        let dot = |&p: &(f64, f64)| Circle::new(p, 3, colour.filled());
                        chart.draw_series(points.iter().map(dot))?;
                    }
                    // There is nothing between two names.
                    let apart = line.mark == Mark::Dots && matches!(self.x, Scale::Names(_));
                    let points = if apart { Vec::new() } else { points };
                    chart.draw_series(LineSeries::new(points, style))?
                }
            };
            if !line.name.is_empty() {
                let key = if line.mark == Mark::Thin { INK.mix(0.4) } else { colour.mix(1.0) };
                drawn.label(&line.name).legend(move |(x, y)| {
                    Rectangle::new([(x, y - 3), (x + 14, y + 3)], key.filled())
                });
            }
        }
        if self.lines.iter().filter(|line| !line.name.is_empty()).count() > 1 {
            let place = |p: &(f64, f64)| {
                let part = |x: f64, low: f64, high: f64| (x - low) / (high - low).max(1e-9);
                [part(self.x.place(p.0), left, right), part(self.y.place(p.1), bottom, top)]
            };
            let places: Vec<_> = all().map(place).collect();
            chart
                .configure_series_labels()
                .position(emptiest(&places))
                .label_font(font(12))
                .legend_area_size(18)
                .margin(6)
                .draw()?;
        }
        root.present()?;
        drop(chart);
        drop(root);
        Ok(())
    }
}

/// The corner with the fewest points near it.
fn emptiest(points: &[[f64; 2]]) -> SeriesLabelPosition {
    let corners = [
        (SeriesLabelPosition::UpperLeft, [0.0, 1.0]),
        (SeriesLabelPosition::LowerLeft, [0.0, 0.0]),
        (SeriesLabelPosition::UpperRight, [1.0, 1.0]),
        (SeriesLabelPosition::LowerRight, [1.0, 0.0]),
    ];
    let near = |corner: [f64; 2]| {
        let is_near = |p: &&[f64; 2]| (0..2).all(|i| (p[i] - corner[i]).abs() < 0.4);
        points.iter().filter(is_near).count()
    };
    corners
        .into_iter()
        .min_by_key(|(_, corner)| near(*corner))
        .map_or(SeriesLabelPosition::UpperLeft, |(position, _)| position)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(x: Scale, points: Vec<(f64, f64)>) -> String {
        let line = Line { name: "a line".into(), mark: Mark::Dots, colour: 0, points };
        let other = Line { name: "another".into(), ..line.clone() };
        Lines {
            title: "a title",
            x,
            x_name: "across",
            y_name: "up",
            y: Scale::Even,
            y_max: None,
            lines: vec![line, other],
            size: [500, 300],
            alone: true,
        }
        .svg()
    }

    #[test]
    fn a_chart_says_what_it_shows_in_the_colour_of_the_text() {
        let svg = lines(Scale::Doubling, vec![(1.0, 1.0), (2.0, 1.9), (64.0, 40.0)]);
        for text in ["a title", "across", "up", "a line", "another", ">\n64\n<", "currentColor"] {
            assert!(svg.contains(text), "no {text} in {svg}");
        }
        assert!(svg.starts_with("<svg") && svg.contains("prefers-color-scheme"));
        assert!(!svg.contains("#010203"));
    }

    #[test]
    fn odd_values_are_drawn_or_left_out() {
        assert_eq!(lines(Scale::Even, vec![]), "");
        assert_eq!(lines(Scale::Even, vec![(0.0, f64::NAN)]), "");
        assert!(lines(Scale::Even, vec![(3.0, 0.0)]).contains("a line"));
        let names = Scale::Names(vec!["hybrid".into(), "data".into()]);
        assert!(lines(names, vec![(0.0, 1.0), (1.0, f64::INFINITY)]).contains("hybrid"));
    }

    #[test]
    fn names_are_not_joined() {
        let points = vec![(0.0, 1.0), (1.0, 2.0)];
        let names = Scale::Names(vec!["hybrid".into(), "data".into()]);
        let [apart, joined] = [names, Scale::Even].map(|x| lines(x, points.clone()));
        assert_eq!([&apart, &joined].map(|svg| svg.matches("<circle").count()), [4, 4]);
        let strokes = |svg: &str| svg.matches(r#"stroke-width="2""#).count();
        assert_eq!([&apart, &joined].map(|svg| strokes(svg)), [0, 2]);
    }

    #[test]
    fn doubling_upwards_leaves_zeros_out() {
        let line = Line {
            name: String::new(),
            mark: Mark::Dots,
            colour: 0,
            points: vec![(1.0, 1.0), (2.0, 0.0), (4.0, 4.0)],
        };
        let chart = Lines {
            title: "",
            x: Scale::Doubling,
            x_name: "",
            y_name: "",
            y: Scale::Doubling,
            y_max: None,
            lines: vec![line],
            size: [500, 300],
            alone: false,
        };
        let svg = chart.svg();
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(svg.matches(">\n4\n<").count() == 2, "{svg}");
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [0.0, 0.25, 3.0, 1234.5, 250_000.0, 2e6].map(short),
            ["0", "0.25", "3", "1234.5", "250 k", "2 M"]
        );
    }
}
