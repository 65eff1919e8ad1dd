//! `kiloray-fuzz [--seconds N] [--seed N] [--replay FILE] [TARGET..]`: see the library.

use std::path::PathBuf;
use std::process::ExitCode;
use std::thread;
use std::time::{Duration, Instant};
use std::{env, fs};

use kiloray_fuzz::{Finding, Run, Target};

fn main() -> ExitCode {
    match run() {
        Ok(code) => code,
        Err(message) => {
            eprintln!("{message}");
            eprintln!("usage: kiloray-fuzz [--seconds N] [--seed N] [--replay FILE] [TARGET..]");
            eprintln!("targets: {}", Target::ALL.map(Target::name).join(" "));
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<ExitCode, String> {
    let (mut seconds, mut seed, mut replay, mut targets) = (600, None, None, Vec::new());
    let mut arguments = env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} lacks a value"));
        let number =
            |text: String| text.parse::<u64>().map_err(|_| format!("`{text}` is no number"));
        match argument.as_str() {
            "--seconds" => seconds = number(value()?)?,
            "--seed" => seed = Some(number(value()?)?),
            "--replay" => replay = Some(value()?),
            name => targets.push(Target::from_name(name).ok_or(format!("no target `{name}`"))?),
        }
    }
    if targets.is_empty() {
        targets.extend(Target::ALL);
    }
    thread::spawn(watch);
    if let Some(file) = replay {
        let input = fs::read(&file).map_err(|e| format!("{file}: {e}"))?;
        for target in targets {
            let answer = Run::replay(target, &input);
            println!("{}: {answer:?}", target.name());
        }
        return Ok(ExitCode::SUCCESS);
    }
    let seed = seed.unwrap_or_else(|| fastrand::u64(..));
    println!("seed {seed}, {seconds} s for {} targets", targets.len());
    let mut good = true;
    for (index, &target) in targets.iter().enumerate() {
        let left = targets.len() - index;
        let share = Duration::from_secs(seconds) / targets.len() as u32;
        let until = Some(Instant::now() + share);
        let report = Run { target, seed, inputs_max: u64::MAX >> 1, until }.run();
        println!(
            "{}: {} inputs, {} answers, at most {} KiB and {:.0?}, {} targets left",
            target.name(),
            report.inputs,
            report.answers,
            report.memory_peak >> 10,
            report.longest,
            left - 1,
        );
        if let Some(finding) = report.finding {
            keep(target, &finding);
            good = false;
        }
    }
    Ok(if good { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Ends the process when an input hangs or eats all memory.
fn watch() {
    loop {
        thread::sleep(Duration::from_millis(50));
        if let Some((target, finding)) = Run::stuck() {
            keep(target, &finding);
            std::process::exit(1);
        }
    }
}

/// Writes what was found, and says how to run it again.
fn keep(target: Target, finding: &Finding) {
    let dir = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("found");
    // Named by its content: the same finding twice is one file.
    let hash = finding
        .input
        .iter()
        .fold(0xcbf2_9ce4_8422_2325u64, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
    let path = dir.join(format!("{}-{hash:016x}", target.name()));
    let kept = fs::create_dir_all(&dir).and_then(|()| fs::write(&path, &finding.input));
    println!("{}: {}", target.name(), finding.what);
    match kept {
        Ok(()) => println!("again: kiloray-fuzz {} --replay {}", target.name(), path.display()),
        Err(error) => println!("could not be kept in {}: {error}", path.display()),
    }
}
