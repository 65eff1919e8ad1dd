use serde_json::json;

use crate::{
    args,
    compare::{Measures, bright, false_colour, measure, relative_errors, smooth},
    console::line,
    failure::{self, Failure, Outcome},
    output::Output,
    picture::{self, Format, Picture, Read},
};

/// Measures and prints.
pub(super) fn run(arguments: &args::Compare) -> Outcome {
    let picture_out = match &arguments.output {
        Some(path) if Format::of(path)? != Format::Png => {
            return Err(Failure::usage(format_args!(
                "{}: the difference is written as .png",
                path.display()
            )));
        }
        Some(path) => Some(Output::create(path)?),
        None => None,
    };
    let json_out = arguments.json.as_deref().map(Output::create).transpose()?;

    let Read { picture: reference, is_png } = picture::read(&arguments.reference)?;
    let image = same_size(arguments, &reference, &arguments.image)?;
    if is_png != image.is_png && !arguments.quiet {
        let png = if is_png { &arguments.reference } else { &arguments.image };
        failure::warn(&format!(
            "{}: a PNG is made for the eye, by an exposure and a curve; beside linear radiance its measures say little: compare .exr or .hdr",
            png.display()
        ));
    }
    let image = image.picture;
    let everywhere = vec![true; reference.pixels.len()];
    let mut rows = vec![("all", measure(&reference, &image, &everywhere))];
    let smooth = smooth(&reference, arguments.edge);
    rows.push(("smooth", measure(&reference, &image, &smooth)));
    if let Some(path) = &arguments.mask {
        let mask = bright(&same_size(arguments, &reference, path)?.picture);
        let measures = measure(&reference, &image, &mask);
        if measures.is_none() {
            return Err(Failure::file(path, "no pixel of the mask is brighter than one half"));
        }
        rows.push(("mask", measures));
    }

    if let Some(output) = picture_out {
        let rgb = false_colour(&relative_errors(&reference, &image));
        let bytes = picture::png_bytes(reference.width, reference.height, &rgb);
        output.write(&bytes.map_err(Failure::new)?)?;
    }
    let to_standard = json_out.is_some() && arguments.json.as_deref() == Some("-".as_ref());
    if let Some(output) = json_out {
        let measures: serde_json::Map<_, _> =
            rows.iter().map(|(name, m)| ((*name).to_owned(), json!(m))).collect();
        let value = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "reference": arguments.reference,
            "image": arguments.image,
            "width": reference.width,
            "height": reference.height,
            "measures": measures,
        });
        output.write(format!("{value:#}\n").as_bytes())?;
    }
    if !arguments.quiet && !to_standard {
        print(&rows)?;
    }
    let Some(all) = rows[0].1 else { return Ok(()) };
    match arguments.fail_above {
        // A NaN is above everything.
        Some(limit) if !matches!(all.relative_rmse.partial_cmp(&limit), Some(o) if o.is_le()) => {
            Err(Failure::new(format_args!(
                "{}: the relative RMSE is {:.6}, above {limit}",
                arguments.image.display(),
                all.relative_rmse
            )))
        }
        _ => Ok(()),
    }
}

fn same_size(
    arguments: &args::Compare,
    reference: &Picture,
    path: &std::path::Path,
) -> Outcome<Read> {
    let read = picture::read(path)?;
    let image = &read.picture;
    if (image.width, image.height) == (reference.width, reference.height) {
        return Ok(read);
    }
    Err(Failure::file(
        path,
        format!(
            "is {} x {} pixels, but {} is {} x {}; pictures of one size are needed",
            image.width,
            image.height,
            arguments.reference.display(),
            reference.width,
            reference.height
        ),
    ))
}

fn print(rows: &[(&str, Option<Measures>)]) -> Outcome {
    line(format_args!(
        "{:<7} {:>9} {:>10} {:>26} {:>12} {:>12} {:>10} {:>10} {:>10} {:>10}",
        "",
        "pixels",
        "mean ratio",
        "red, green, blue",
        "RMSE",
        "rel. RMSE",
        "p50",
        "p90",
        "p99",
        "max"
    ))?;
    for (name, measures) in rows {
        let Some(m) = measures else {
            line(format_args!("{name:<7} {:>9}", 0))?;
            continue;
        };
        let [r, g, b] = m.mean_ratio_rgb;
        line(format_args!(
            "{name:<7} {:>9} {:>10.6} {:>26} {:>12.4e} {:>12.6} {:>10.2e} {:>10.2e} {:>10.2e} {:>10.2e}",
            m.pixels,
            m.mean_ratio,
            format!("{r:.5} {g:.5} {b:.5}"),
            m.rmse,
            m.relative_rmse,
            m.p50,
            m.p90,
            m.p99,
            m.max
        ))?;
    }
    Ok(())
}
