use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use crate::cores;

/// Runs jobs on all cores, or so many threads, and gives their results in the order of the jobs.
///
/// A job that panics gives an error and does not stop the others.
pub(super) fn run<J: Sync, R: Send>(
    jobs: &[J],
    threads: Option<u32>,
    work: impl Fn(&J) -> R + Sync,
) -> Vec<Result<R, String>> {
    let threads = cores::threads(threads).clamp(1, jobs.len().max(1));
    let next = AtomicUsize::new(0);
    let results: Vec<_> = jobs.iter().map(|_| Mutex::new(None)).collect();
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some((job, result)) = {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    jobs.get(i).zip(results.get(i))
                } {
                    let ended = catch_unwind(AssertUnwindSafe(|| work(job)));
                    // The hook has reported the panic.
                    let ended = ended.map_err(|_| "a mistake in kiloray: it panicked".to_owned());
                    if let Ok(mut result) = result.lock() {
                        *result = Some(ended);
                    }
                }
            });
        }
    });
    results
        .into_iter()
        .map(|result| result.into_inner().ok().flatten().unwrap_or_else(|| Err("not run".into())))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_the_order_of_the_jobs() {
        let jobs: Vec<u64> = (0..100).collect();
        let slow_first = |&n: &u64| (0..(100 - n) * 1000).fold(n, |a, _| std::hint::black_box(a));
        for threads in [1, 2, 7] {
            let all = run(&jobs, Some(threads), slow_first);
            assert!(all.into_iter().map(Result::unwrap).eq(0..100));
        }
        assert!(run(&[] as &[u64], None, |&n| n).is_empty());
    }

    #[test]
    fn a_panic_is_the_error_of_its_job_alone() {
        let all = run(&[1, 2, 3], Some(2), |&n| if n == 2 { panic!("two") } else { n });
        assert_eq!((&all[0], &all[2]), (&Ok(1), &Ok(3)));
        assert!(all[1].is_err());
    }
}
