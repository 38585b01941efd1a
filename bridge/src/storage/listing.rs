//! Lists the store without asking it too often: each list costs a request there, and anyone who may
//! watch may ask.
//!
//! In: how to list it. Out: the last list, no older than [`FRESH`], or why there is none.

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::Mutex;
use tokio::time::Instant;

/// How long a list, or the error in its place, stays valid.
const FRESH: Duration = Duration::from_secs(5);

/// A piece in the store.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Stored {
    pub(super) name: String,
    pub(super) bytes: u64,
}

/// The pieces in the store, or a sentence why they are not known.
pub(super) type Answer = Result<Vec<Stored>, String>;

/// The last answer of the store, and when it came.
#[derive(Clone, Debug, Default)]
pub(super) struct Listing(Arc<Mutex<Kept>>);

type Kept = Option<(Instant, Arc<Answer>)>;

impl Listing {
    /// The last answer or, if it is too old, the answer of `ask`. Only one such request is open at
    /// a time, and all callers wait for its answer.
    ///
    /// The request runs on a task of its own: if a caller goes away, the answer is kept for the
    /// next one, and the request need not begin again.
    pub(super) async fn get(
        &self,
        ask: impl Future<Output = Answer> + Send + 'static,
    ) -> Arc<Answer> {
        let kept = Arc::clone(&self.0);
        let asked = tokio::spawn(async move {
            let mut kept = kept.lock().await;
            if let Some((at, answer)) = &*kept
                && at.elapsed() < FRESH
            {
                return Arc::clone(answer);
            }
            let answer = Arc::new(ask.await);
            *kept = Some((Instant::now(), Arc::clone(&answer)));
            answer
        });
        let failed = |error: tokio::task::JoinError| Arc::new(Err(error.to_string()));
        asked.await.unwrap_or_else(failed)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// A store that answers after a second, and counts how often it is asked.
    #[derive(Clone, Default)]
    struct Store(Arc<AtomicUsize>);

    impl Store {
        async fn list(self) -> Answer {
            self.0.fetch_add(1, Ordering::Relaxed);
            tokio::time::sleep(Duration::from_secs(1)).await;
            Err("the bucket is not there".to_owned())
        }

        fn asked(&self) -> usize {
            self.0.load(Ordering::Relaxed)
        }
    }

    #[tokio::test(start_paused = true)]
    async fn many_who_ask_cost_the_store_one_question_each_few_seconds() {
        let (listing, store) = (Listing::default(), Store::default());
        for _ in 0..50 {
            let _ = listing.get(store.clone().list()).await;
        }
        assert_eq!(store.asked(), 1);
        tokio::time::advance(FRESH).await;
        let both = [(); 2].map(|()| listing.get(store.clone().list()));
        let answers = futures_util::future::join_all(both).await;
        assert!(answers.iter().all(|answer| answer.is_err()));
        assert_eq!(
            store.asked(),
            2,
            "one at a time, and the second has its answer"
        );
    }

    #[tokio::test(start_paused = true)]
    async fn who_asks_and_goes_makes_nobody_ask_again() {
        let (listing, store) = (Listing::default(), Store::default());
        for _ in 0..50 {
            let soon = Duration::from_millis(10);
            let _ = tokio::time::timeout(soon, listing.get(store.clone().list())).await;
        }
        let _ = listing.get(store.clone().list()).await;
        assert_eq!(store.asked(), 1);
    }
}
