//! What a client of rosbridge sends.
//!
//! Clients differ in how they write it: numbers for strings, floats for integers, a stamped message
//! for a plain one, a list for named arguments. Everything that can be understood is accepted. For
//! the rest the sender gets a sentence, and the connection goes on: the next message may be a stop.

use std::time::Duration;

use serde_json::Value;
use slamlab_core::robot::Command;

/// A request, and the sender's name for it.
#[derive(Debug, PartialEq)]
pub(super) struct Request {
    /// Sent back unchanged, whatever it is.
    pub(super) id: Option<Value>,
    pub(super) asked: Asked,
}

/// What is asked. Fields that only tune the answer (queues, compression, types) are ignored.
#[derive(Debug, PartialEq)]
pub(super) enum Asked {
    Subscribe {
        topic: String,
        throttle: Duration,
    },
    Unsubscribe {
        topic: String,
    },
    Advertise {
        topic: String,
    },
    Publish {
        topic: String,
        msg: Value,
    },
    CallService {
        service: String,
        args: Value,
    },
    /// A request that needs no answer.
    Nothing,
}

/// Why a request cannot be done, for its sender.
#[derive(Debug, PartialEq)]
pub(super) struct NotUnderstood {
    pub(super) id: Option<Value>,
    pub(super) why: String,
}

impl Request {
    /// Reads a message.
    pub(super) fn read(text: &str) -> Result<Self, NotUnderstood> {
        let whole: Value = serde_json::from_str(text).map_err(|error| NotUnderstood {
            id: None,
            why: format!("this is no JSON: {error}"),
        })?;
        let id = whole.get("id").cloned().filter(|id| !id.is_null());
        match asked(whole) {
            Ok(asked) => Ok(Self { id, asked }),
            Err(why) => Err(NotUnderstood { id, why }),
        }
    }
}

fn asked(mut whole: Value) -> Result<Asked, String> {
    let op = text(&whole, "op")?;
    let topic = |whole: &Value| Ok::<_, String>(rooted(&text(whole, "topic")?));
    Ok(match op.as_str() {
        "subscribe" => Asked::Subscribe {
            topic: topic(&whole)?,
            throttle: throttle(whole.get("throttle_rate")),
        },
        "unsubscribe" => Asked::Unsubscribe {
            topic: topic(&whole)?,
        },
        "advertise" => Asked::Advertise {
            topic: topic(&whole)?,
        },
        "publish" => Asked::Publish {
            topic: topic(&whole)?,
            msg: taken(&mut whole, "msg"),
        },
        "call_service" => Asked::CallService {
            service: rooted(&text(&whole, "service")?),
            args: taken(&mut whole, "args"),
        },
        "unadvertise" | "set_level" => Asked::Nothing,
        other => return Err(format!("the operation {other:?} is not known here")),
    })
}

fn text(whole: &Value, key: &str) -> Result<String, String> {
    let value = whole.get(key).and_then(Value::as_str);
    value
        .map(str::to_owned)
        .ok_or_else(|| format!("{key} is missing, or no text"))
}

fn taken(whole: &mut Value, key: &str) -> Value {
    whole.get_mut(key).map(Value::take).unwrap_or_default()
}

/// The name with a leading slash: with and without it, names mean the same.
fn rooted(name: &str) -> String {
    match name.starts_with('/') {
        true => name.to_owned(),
        false => format!("/{name}"),
    }
}

/// Converts milliseconds; a value that is not a time throttles nothing.
fn throttle(value: Option<&Value>) -> Duration {
    let millis = value.and_then(Value::as_f64).unwrap_or(0.0);
    Duration::try_from_secs_f64(1e-3 * millis).unwrap_or_default()
}

/// `geometry_msgs/Twist` or `geometry_msgs/TwistStamped`, as far as a robot on a floor can follow
/// it. A missing component is 0, as in ROS; a component of another type is an error, and so is a
/// message without both vectors.
pub(super) fn velocity(msg: &Value) -> Result<Command, String> {
    let twist = msg.get("twist").unwrap_or(msg);
    let part = |vector: &str, axis: &str| {
        let Some(vector) = twist.get(vector) else {
            return Ok(0.0);
        };
        match vector.as_object().map(|vector| vector.get(axis)) {
            Some(None) => Ok(0.0),
            Some(Some(value)) => value.as_f64().ok_or(()),
            None => Err(()),
        }
    };
    let has_any = ["linear", "angular"]
        .into_iter()
        .any(|vector| twist.get(vector).is_some());
    match (part("linear", "x"), part("angular", "z")) {
        (Ok(forward), Ok(turn)) if has_any => Ok(Command::Velocity { forward, turn }),
        _ => Err("expected a Twist or a TwistStamped: {\"linear\": {\"x\": m/s}, \"angular\": {\"z\": rad/s}}".into()),
    }
}

/// An argument of a service, by its name or as the only element of a list.
pub(super) fn argument<'a>(args: &'a Value, name: &str) -> Option<&'a Value> {
    match args {
        Value::Array(list) => list.first().filter(|_| list.len() == 1),
        _ => args.get(name),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn read(message: &Value) -> Request {
        Request::read(&message.to_string()).unwrap()
    }

    #[test]
    fn what_roslib_says_is_read() {
        let subscribe = json!({ "op": "subscribe", "id": "subscribe:/scan:1", "type": "sensor_msgs/LaserScan",
            "topic": "/scan", "compression": "none", "throttle_rate": 100, "queue_length": 0 });
        let request = read(&subscribe);
        assert_eq!(request.id, Some(json!("subscribe:/scan:1")));
        let (topic, throttle) = ("/scan".to_owned(), Duration::from_millis(100));
        assert_eq!(request.asked, Asked::Subscribe { topic, throttle });
        let call = json!({ "op": "call_service", "service": "slamlab/stop" });
        let service = "/slamlab/stop".to_owned();
        let args = Value::Null;
        assert_eq!(read(&call).asked, Asked::CallService { service, args });
    }

    /// Regression: each of these closed the connection, so the client could no longer send a stop.
    #[test]
    fn slips_that_can_be_understood_are_no_slips() {
        let throttles = [
            json!(100.0),
            json!(-1),
            json!("fast"),
            json!(1e300),
            json!(null),
        ];
        for (rate, millis) in throttles.into_iter().zip([100, 0, 0, 0, 0]) {
            let request =
                json!({ "op": "subscribe", "topic": "scan", "throttle_rate": rate, "id": 7 });
            let Request { id, asked } = read(&request);
            let (topic, throttle) = ("/scan".to_owned(), Duration::from_millis(millis));
            assert_eq!(
                (id, asked),
                (Some(json!(7)), Asked::Subscribe { topic, throttle })
            );
        }
        assert_eq!(
            read(&json!({ "op": "set_level", "level": "none" })).asked,
            Asked::Nothing
        );
    }

    #[test]
    fn what_cannot_be_understood_is_said_to_whom_asked() {
        for (message, why) in [
            ("{", "this is no JSON"),
            ("[]", "op is missing"),
            (r#"{"op":"png","id":8}"#, "\"png\" is not known"),
            (r#"{"op":"publish","id":8}"#, "topic is missing"),
            (
                r#"{"op":"call_service","id":8,"service":3}"#,
                "service is missing",
            ),
        ] {
            let said = Request::read(message).unwrap_err();
            assert!(said.why.contains(why), "{message}: {}", said.why);
            assert_eq!(said.id.is_some(), message.contains("id"));
        }
    }

    #[test]
    fn a_twist_is_read_plain_and_stamped_and_nothing_else_is() {
        let twist = json!({ "linear": { "x": 0.1, "y": 0 }, "angular": { "z": -0.5 } });
        let (forward, turn) = (0.1, -0.5);
        let stamped = json!({ "header": { "frame_id": "base_link" }, "twist": twist });
        for msg in [&twist, &stamped] {
            assert_eq!(velocity(msg), Ok(Command::Velocity { forward, turn }));
        }
        let turn = json!({ "angular": { "z": 1 } });
        let (forward, rate) = (0.0, 1.0);
        assert_eq!(
            velocity(&turn),
            Ok(Command::Velocity {
                forward,
                turn: rate
            })
        );
        for wrong in [
            json!(null),
            json!({}),
            json!({ "twist": {} }),
            json!({ "linear": 0.1 }),
            json!({ "linear": { "x": "fast" } }),
            json!({ "linear": { "x": null }, "angular": { "z": 0 } }),
        ] {
            assert!(velocity(&wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn arguments_come_by_name_or_alone() {
        for args in [json!({ "force": true }), json!([true])] {
            assert_eq!(argument(&args, "force"), Some(&json!(true)));
        }
        assert_eq!(argument(&json!([1, 2]), "force"), None);
        assert_eq!(argument(&Value::Null, "force"), None);
    }
}
