use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use fastrand::Rng;
use peak_alloc::PeakAlloc;

use crate::mutate::mutate;
use crate::{Target, seeds};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Memory that an input may take while it is parsed \[bytes\]: 64 MiB, and 256 for each byte.
#[must_use]
pub const fn memory_max(input_len: usize) -> usize {
    (64 << 20) + 256 * input_len
}

/// Time that an input may take. Milliseconds are usual; a busy machine needs room.
const TIME_MAX: Duration = Duration::from_secs(10);
/// Inputs that are kept for further mutation.
const KEPT_MAX: usize = 4096;

/// A run over one target.
#[derive(Debug, Clone)]
pub struct Run {
    /// What is fuzzed.
    pub target: Target,
    /// Where the random numbers begin.
    pub seed: u64,
    /// Greatest number of mutations.
    pub inputs_max: u64,
    /// When it ends at the latest.
    pub until: Option<Instant>,
}

/// What a run found.
#[derive(Debug)]
pub struct Report {
    /// Inputs that were parsed, seeds included.
    pub inputs: u64,
    /// Different answers: errors and notes without their numbers and names.
    pub answers: usize,
    /// Most memory that an input took \[bytes\].
    pub memory_peak: usize,
    /// Longest time that an input took.
    pub longest: Duration,
    /// The first input that broke a promise.
    pub finding: Option<Finding>,
}

/// An input that broke a promise.
#[derive(Debug)]
pub struct Finding {
    /// The input.
    pub input: Vec<u8>,
    /// What happened.
    pub what: String,
}

/// The input being parsed, for whoever watches over time.
static CURRENT: Mutex<Option<(Target, Instant, Vec<u8>)>> = Mutex::new(None);

impl Run {
    /// Parses the seeds, then mutations of them and of what was kept.
    ///
    /// # Panics
    /// If no directory for the inputs can be made.
    #[must_use]
    pub fn run(&self) -> Report {
        let dir = directory().expect("a directory for the inputs");
        let mut rng = Rng::with_seed(self.seed);
        let mut pool = seeds(self.target);
        let mut report = Report {
            inputs: 0,
            answers: 0,
            memory_peak: 0,
            longest: Duration::ZERO,
            finding: None,
        };
        let mut answers = HashSet::new();
        let first = pool.len() as u64;
        let text = self.target.is_text();
        for n in 0..first + self.inputs_max {
            if self.until.is_some_and(|until| Instant::now() >= until) {
                break;
            }
            let input = if n < first {
                pool[n as usize].clone()
            } else {
                let pick = |rng: &mut Rng| rng.usize(..pool.len());
                let (seed, other) = (pick(&mut rng), pick(&mut rng));
                mutate(&mut rng, &pool[seed], &pool[other], text)
            };
            match self.try_input(&input, dir.path(), &mut report) {
                Err(what) => {
                    report.finding = Some(Finding { input, what });
                    break;
                }
                // What is answered for the first time is worth changing further.
                Ok(answer) => {
                    let new = answers.insert(answer);
                    if new && n >= first && pool.len() < KEPT_MAX {
                        pool.push(input);
                    }
                }
            }
        }
        report.answers = answers.len();
        report
    }

    /// Parses one input, and measures it.
    fn try_input(
        &self,
        input: &[u8],
        dir: &std::path::Path,
        report: &mut Report,
    ) -> Result<String, String> {
        report.inputs += 1;
        let begin = Instant::now();
        set_current(Some((self.target, begin, input.to_vec())));
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        let answer = catch_unwind(AssertUnwindSafe(|| self.target.feed(input, dir)));
        let memory = MEMORY.peak_usage().saturating_sub(before);
        let time = begin.elapsed();
        set_current(None);
        report.memory_peak = report.memory_peak.max(memory);
        report.longest = report.longest.max(time);
        let answer = answer.map_err(|payload| {
            let text = payload.downcast_ref::<String>().cloned();
            let text = text.or_else(|| payload.downcast_ref::<&str>().map(ToString::to_string));
            format!("panic: {}", text.unwrap_or_default())
        })?;
        if memory > memory_max(input.len()) {
            return Err(format!("{memory} bytes of memory for {} of input", input.len()));
        }
        if time > TIME_MAX {
            return Err(format!("{time:?} for {} bytes of input", input.len()));
        }
        Ok(kind_of(&answer))
    }

    /// Parses one input, as [`run`](Self::run) does.
    ///
    /// # Errors
    /// If it breaks a promise.
    ///
    /// # Panics
    /// If no directory for the input can be made.
    pub fn replay(target: Target, input: &[u8]) -> Result<String, String> {
        let dir = directory().expect("a directory for the input");
        let run = Self { target, seed: 0, inputs_max: 0, until: None };
        let mut report = run.run();
        run.try_input(input, dir.path(), &mut report)
    }

    /// The input that has been parsed for too long, or takes too much memory, if there is one: a
    /// second thread asks, as a hang answers nobody.
    #[must_use]
    pub fn stuck() -> Option<(Target, Finding)> {
        let current = CURRENT.lock().unwrap_or_else(|e| e.into_inner());
        let (target, begin, input) = current.as_ref()?;
        let memory = MEMORY.current_usage();
        let what = if begin.elapsed() > TIME_MAX * 2 {
            "it hangs".to_owned()
        } else if memory > 16 * memory_max(input.len()) {
            format!("{memory} bytes of memory, and growing")
        } else {
            return None;
        };
        Some((*target, Finding { input: input.clone(), what }))
    }
}

fn set_current(current: Option<(Target, Instant, Vec<u8>)>) {
    *CURRENT.lock().unwrap_or_else(|e| e.into_inner()) = current;
}

/// A directory in memory where there is one: some file systems wait for the disk when a file is
/// written again.
fn directory() -> std::io::Result<tempfile::TempDir> {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir())
}

/// An answer without its numbers, names and paths.
fn kind_of(answer: &str) -> String {
    // What is quoted may hold quotes itself.
    let ends = answer.split('`').next().into_iter().chain(answer.rsplit('`').next());
    let words = ends.flat_map(str::split_whitespace).filter(|word| !word.contains('/'));
    let letters = |word: &str| word.chars().filter(|c| c.is_alphabetic()).collect::<String>();
    words.map(letters).collect::<Vec<_>>().join(" ")
}
