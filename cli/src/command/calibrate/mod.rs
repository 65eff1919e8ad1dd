//! `kiloray calibrate`: how long the operations of a node take on this machine.

mod bytes;
mod file;
mod fit;
mod picture;

use kiloray_sim::Profile;
use rayon::prelude::*;

pub(super) use self::file::read;
use self::{
    fit::{Row, fit, rounded},
    picture::Picture,
};
use crate::{
    args,
    console::{duration, line},
    cores,
    failure::{self, Outcome},
    output::Output,
    progress::Progress,
};

/// What the fit sees: each operation is much of some picture, and little of another.
const SEEN: [Picture; 21] = [
    Picture { scene: "cornell", side: 128, zoom: 1.0, samples: 4 },
    Picture { scene: "cornell", side: 192, zoom: 1.0, samples: 1 },
    Picture { scene: "cornell", side: 64, zoom: 6.0, samples: 16 },
    Picture { scene: "colour-cube:3", side: 96, zoom: 1.0, samples: 2 },
    Picture { scene: "colour-cube:6", side: 64, zoom: 4.0, samples: 2 },
    Picture { scene: "colour-cube:20", side: 64, zoom: 1.0, samples: 2 },
    Picture { scene: "sphereflake:2", side: 96, zoom: 1.0, samples: 2 },
    Picture { scene: "sphereflake", side: 48, zoom: 1.0, samples: 2 },
    Picture { scene: "sphereflake", side: 48, zoom: 6.0, samples: 2 },
    Picture { scene: "glass", side: 64, zoom: 1.0, samples: 2 },
    Picture { scene: "glass", side: 64, zoom: 6.0, samples: 4 },
    Picture { scene: "sinc", side: 64, zoom: 1.0, samples: 4 },
    Picture { scene: "sinc:40", side: 48, zoom: 3.0, samples: 4 },
    Picture { scene: "sinc:100", side: 128, zoom: 1.0, samples: 2 },
    Picture { scene: "conference", side: 64, zoom: 1.0, samples: 2 },
    Picture { scene: "conference", side: 128, zoom: 1.0, samples: 2 },
    Picture { scene: "conference", side: 64, zoom: 6.0, samples: 2 },
    Picture { scene: "studio", side: 64, zoom: 1.0, samples: 2 },
    Picture { scene: "studio", side: 128, zoom: 1.0, samples: 2 },
    Picture { scene: "studio", side: 64, zoom: 6.0, samples: 4 },
    Picture { scene: "furnace", side: 64, zoom: 1.0, samples: 4 },
];
/// What it does not see: how well it predicts them says how good it is. The greater are such as people render, of those that take long the middle.
const UNSEEN: [Picture; 9] = [
    Picture { scene: "cornell", side: 256, zoom: 1.0, samples: 4 },
    Picture { scene: "glass", side: 128, zoom: 2.0, samples: 2 },
    Picture { scene: "sphereflake:4", side: 128, zoom: 2.0, samples: 1 },
    Picture { scene: "conference", side: 128, zoom: 2.0, samples: 2 },
    Picture { scene: "colour-cube:20", side: 128, zoom: 2.0, samples: 2 },
    Picture { scene: "cornell", side: 96, zoom: 3.0, samples: 8 },
    Picture { scene: "glass", side: 64, zoom: 3.0, samples: 4 },
    Picture { scene: "sphereflake", side: 64, zoom: 3.0, samples: 4 },
    Picture { scene: "colour-cube:12", side: 64, zoom: 2.0, samples: 4 },
];
/// What is left of their sides where it has to be quick.
const QUICK: u32 = 4;
/// Errors of those above which the figures are not to be relied on: usually the machine was busy.
const DOUBTFUL: f64 = 0.2;

/// What was measured.
struct Machine {
    /// Of pictures that the fit sees.
    seen: Vec<Row>,
    /// Of others.
    unseen: Vec<Row>,
    /// What follows.
    profile: Profile,
}

/// Measures and writes.
pub(super) fn run(arguments: &args::Calibrate) -> Outcome {
    let quiet = arguments.quiet;
    let name = file::name(&arguments.output)?;
    let output = Output::create(&arguments.output)?;
    let threads = cores::threads(arguments.threads);
    let size = |picture: Picture| {
        let side = if arguments.quick { picture.side / QUICK } else { picture.side };
        Picture { side, ..picture }
    };
    let (known, others) = (SEEN.map(size), UNSEEN.map(size));
    let Machine { seen, unseen, mut profile } =
        measure(&known, &others, threads, arguments.repeats, quiet)?;

    let worst = unseen.iter().map(|row| row.error(&profile).abs()).fold(0.0, f64::max);
    let within = within(worst);
    profile.name = name.into();
    profile.source = format!(
        "measured by kiloray {} calibrate{}, {threads} threads of a machine with {} ({}); pictures that the fit did not see are predicted within {within}",
        env!("CARGO_PKG_VERSION"),
        if arguments.quick { " --quick" } else { "" },
        std::env::consts::ARCH,
        std::env::consts::OS,
    )
    .into();
    file::write(&profile, output)?;

    if quiet {
        return Ok(());
    }
    if cfg!(debug_assertions) {
        failure::warn(
            "so fast is a build for development; 'cargo run --release -- calibrate' measures what others run",
        );
    }
    if worst > DOUBTFUL {
        let again = if arguments.quick { "without --quick" } else { "when the machine is quiet" };
        failure::warn(&format!(
            "pictures that were not used differ by up to {within}: measure again {again}"
        ));
    }
    if arguments.output.as_os_str() == "-" {
        return Ok(());
    }
    print("used for the fit", &known, &seen, &profile)?;
    print("not used", &others, &unseen, &profile)?;
    let path = arguments.output.display();
    line(format_args!("{path}: use it with 'kiloray sim SCENE --profile {path}'"))
}

/// Counts on all cores, then measures with so many threads at once. The pictures take turns, so that what else the machine does for a while is shared out.
fn measure(
    known: &[Picture],
    others: &[Picture],
    threads: usize,
    repeats: u32,
    quiet: bool,
) -> Outcome<Machine> {
    let pictures = || known.iter().chain(others);
    let all = pictures().count() as u64;
    let bar = Progress::new("counting", all, quiet);
    let counted = known.par_iter().chain(others).map(|picture| {
        bar.message(picture.to_string());
        picture.count().inspect(|_| bar.advance())
    });
    let mut subjects = counted.collect::<Outcome<Vec<_>>>()?;
    drop(bar);
    let bar = Progress::new("measuring", all * u64::from(repeats), quiet);
    for round in 1..=repeats {
        for (picture, subject) in pictures().zip(&mut subjects) {
            bar.message(format!("round {round} of {repeats}: {picture}"));
            subject.time(threads)?;
            bar.advance();
        }
    }
    drop(bar);
    let mut seen: Vec<Row> = subjects.into_iter().map(|subject| subject.row).collect();
    let unseen = seen.split_off(known.len());
    let (copy, check) = (rounded(bytes::copy_ns()), rounded(bytes::check_ns()?));
    let profile = Profile { copy, check, ..fit(&seen) };
    Ok(Machine { seen, unseen, profile })
}

/// The whole percentage that nothing exceeds.
fn within(worst: f64) -> String {
    format!("{:.0} %", (100.0 * worst).ceil())
}

fn print(title: &str, pictures: &[Picture], measured: &[Row], profile: &Profile) -> Outcome {
    let table = table(title, pictures, measured, profile);
    table.iter().try_for_each(|row| line(format_args!("{row}")))
}

/// Pictures, as they were measured and are predicted.
fn table(title: &str, pictures: &[Picture], measured: &[Row], profile: &Profile) -> Vec<String> {
    // One width for both tables, and for the longest names.
    let names = SEEN.iter().chain(&UNSEEN).map(|picture| picture.to_string().chars().count());
    let first = names.max().unwrap_or(0);
    let width = profile.name.chars().count().max(12);
    let title_width = first + 2;
    let head =
        format!("{title:<title_width$} {:>9} {:>width$} {:>8}", "measured", profile.name, "pc");
    let rows = pictures.iter().zip(measured).map(|(picture, row)| {
        format!(
            "  {picture:<first$} {:>9} {:>width$} {:>8}",
            duration(row.ns as u64),
            format!("{:+.1} %", 100.0 * row.error(profile)),
            format!("{:+.0} %", 100.0 * row.error(&Profile::PC)),
        )
    });
    std::iter::once(head).chain(rows).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use kiloray_core::node::Work;

    #[test]
    fn predictions_are_as_near_as_they_are_said_to_be() {
        let said = [0.0, 0.151, 0.165, 0.17, 1.0].map(within);
        assert_eq!(said, ["0 %", "16 %", "17 %", "17 %", "100 %"]);
    }

    #[test]
    fn columns_are_as_wide_as_their_longest_name() {
        let measured: Vec<_> = SEEN
            .iter()
            .map(|_| {
                let mut row = Row::new(&Work::default(), 1);
                row.ns = 1e6;
                row
            })
            .collect();
        for name in ["short", "a-machine-with-a-long-name"] {
            let profile = Profile { name: name.into(), ..Profile::PC };
            let table = table("used for the fit", &SEEN, &measured, &profile);
            let widths: Vec<_> = table.iter().map(|row| row.chars().count()).collect();
            assert_eq!(widths, vec![widths[0]; SEEN.len() + 1], "{table:#?}");
            assert!(table[0].contains(&format!(" {name} ")), "{}", table[0]);
        }
    }
}
