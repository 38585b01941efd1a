//! Independent runs side by side.

use anyhow::Result;

/// Runs each piece of work by itself, on as many threads as there are processors.
pub(crate) fn each<T: Send>(
    count: usize,
    work: impl Fn(usize) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let work = &work;
    let own = |thread: usize| {
        move || {
            (thread..count)
                .step_by(threads)
                .map(|i| (i, work(i)))
                .collect()
        }
    };
    let mut done: Vec<(usize, Result<T>)> = std::thread::scope(|scope| {
        let started: Vec<_> = (0..threads)
            .map(|thread| scope.spawn(own(thread)))
            .collect();
        let joined = started.into_iter().map(|thread| {
            let nothing: Vec<(usize, Result<T>)> = vec![];
            thread.join().unwrap_or(nothing)
        });
        joined.flatten().collect()
    });
    done.sort_by_key(|(i, _)| *i);
    if done.len() < count {
        anyhow::bail!("{} of {count} runs broke off", count - done.len());
    }
    done.into_iter().map(|(_, result)| result).collect()
}
