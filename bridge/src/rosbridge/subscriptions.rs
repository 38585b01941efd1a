//! What a client has subscribed to.
//!
//! In: its `subscribe` and `unsubscribe`. Out: whether a message of a topic must be sent now.
//!
//! A client may subscribe to a topic more than once, each time with its own `id`: roslib does so
//! for each `Topic` object that a program makes. Messages are sent once for all of them, at the
//! highest rate that one of them asks for; the client drops what is too much for the others.
//!
//! Source: rosbridge v2 protocol specification, `subscribe` and `unsubscribe`.

use std::collections::BTreeMap;
use std::time::Duration;

use serde_json::Value;

/// Most subscriptions of one client.
const MOST: usize = 64;
/// Longest `id` as JSON, bytes: each is kept in memory.
const LONGEST_ID: usize = 256;

/// Topics with their subscriptions; each topic here has at least one.
#[derive(Debug, Default)]
pub(super) struct Subscriptions(BTreeMap<String, Wanted>);

/// The subscriptions of one topic.
#[derive(Debug, Default)]
struct Wanted {
    /// Least interval between messages, by the subscription's `id` as JSON, which is empty for a
    /// subscription without one.
    throttles: BTreeMap<String, Duration>,
    sent: Option<Duration>,
}

impl Subscriptions {
    /// Subscribes; a later subscription with the same `id` replaces this one.
    ///
    /// # Errors    Why that is not possible, for the client.
    pub(super) fn add(
        &mut self,
        topic: String,
        id: Option<&Value>,
        throttle: Duration,
    ) -> Result<(), String> {
        let id = key(id);
        if id.len() > LONGEST_ID {
            return Err(format!("an id has at most {LONGEST_ID} bytes"));
        }
        let known = self.0.get(&topic);
        let is_new = known.is_none_or(|wanted| !wanted.throttles.contains_key(&id));
        let count: usize = self.0.values().map(|wanted| wanted.throttles.len()).sum();
        if is_new && count >= MOST {
            return Err(format!("a client has at most {MOST} subscriptions"));
        }
        let wanted = self.0.entry(topic).or_default();
        wanted.throttles.insert(id, throttle);
        // A new subscription must not wait because of a message that was sent for another.
        wanted.sent = None;
        Ok(())
    }

    /// Ends the subscription with this `id`, or all of the topic if `id` is none.
    pub(super) fn remove(&mut self, topic: &str, id: Option<&Value>) {
        let Some(wanted) = self.0.get_mut(topic) else {
            return;
        };
        if id.is_some() {
            wanted.throttles.remove(&key(id));
        }
        if id.is_none() || wanted.throttles.is_empty() {
            self.0.remove(topic);
        }
    }

    /// Whether a message of the topic must be sent now; if so, it counts as sent.
    pub(super) fn is_due(&mut self, topic: &str, now: Duration) -> bool {
        let Some(wanted) = self.0.get_mut(topic) else {
            return false;
        };
        let Some(throttle) = wanted.throttles.values().min() else {
            return false;
        };
        let is_due = wanted.sent.is_none_or(|sent| now >= sent + *throttle);
        if is_due {
            wanted.sent = Some(now);
        }
        is_due
    }
}

fn key(id: Option<&Value>) -> String {
    id.map(Value::to_string).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    const SCAN: &str = "/scan";

    fn of(subscribed: &[(Option<Value>, u64)]) -> Subscriptions {
        let mut all = Subscriptions::default();
        for (id, millis) in subscribed {
            let throttle = Duration::from_millis(*millis);
            all.add(SCAN.to_owned(), id.as_ref(), throttle).unwrap();
        }
        all
    }

    /// How many messages of one second, one every 10 ms, are sent.
    fn sent(all: &mut Subscriptions) -> usize {
        let times = (0..100).map(|at| Duration::from_millis(10 * at));
        times.filter(|now| all.is_due(SCAN, *now)).count()
    }

    #[test]
    fn only_the_subscription_that_is_named_ends_and_all_where_none_is() {
        let (one, two) = (Some(json!("subscribe:/scan:1")), Some(json!(2)));
        let both = [(one.clone(), 0), (two.clone(), 0), (None, 0)];
        let mut all = of(&both);
        all.remove(SCAN, two.as_ref());
        all.remove(SCAN, Some(&json!("2")));
        all.remove("/odom", None);
        assert_eq!(sent(&mut all), 100);
        all.remove(SCAN, None);
        assert_eq!(sent(&mut all), 0);
        let mut all = of(&both[..2]);
        all.remove(SCAN, one.as_ref());
        all.remove(SCAN, two.as_ref());
        assert_eq!(sent(&mut all), 0);
    }

    #[test]
    fn the_smallest_throttle_of_those_that_stand_counts() {
        let ids = [1, 2].map(|id| Some(json!(id)));
        for [first, second] in [[100, 500], [500, 100]] {
            let mut all = of(&[(ids[0].clone(), first), (ids[1].clone(), second)]);
            assert_eq!(sent(&mut all), 10);
        }
        let mut all = of(&[(ids[0].clone(), 100), (ids[1].clone(), 500)]);
        all.remove(SCAN, ids[0].as_ref());
        assert_eq!(sent(&mut all), 2);
        // With the same id it is the same subscription, with another throttle.
        let mut all = of(&[(ids[0].clone(), 100), (ids[0].clone(), 500)]);
        assert_eq!(sent(&mut all), 2);
    }

    #[test]
    fn what_a_client_can_have_the_bridge_keep_is_bounded() {
        let mut all = Subscriptions::default();
        let mut add = |id: Value| all.add(SCAN.to_owned(), Some(&id), Duration::ZERO);
        for id in 0..MOST {
            assert_eq!(add(json!(id)), Ok(()));
        }
        assert!(add(json!(MOST)).unwrap_err().contains("64 subscriptions"));
        assert_eq!(add(json!(0)), Ok(()), "it is there already");
        assert!(add(json!("x".repeat(LONGEST_ID))).is_err());
    }
}
