//! The rules under inputs in any order, against a plain restatement of what must always hold.

use std::time::Duration;

use proptest::prelude::*;

use super::*;

fn any_asked() -> impl Strategy<Value = Asked> {
    let epoch = || 0_u32..6;
    prop_oneof![
        1 => any::<bool>().prop_map(|force| ToBridge::Take { force }.into()),
        1 => epoch().prop_map(|epoch| ToBridge::Renew { epoch }.into()),
        1 => epoch().prop_map(|epoch| ToBridge::Release { epoch }.into()),
        8 => epoch().prop_map(|epoch| ToBridge::Arm { epoch }.into()),
        // The sequence and the time seen are replaced by valid ones below, most of the time.
        20 => (epoch(), 0_u32..3, 0_u64..700).prop_map(|(e, s, seen)| drive(e, s, seen)),
        3 => (epoch(), 0_u32..3, 0_u64..700).prop_map(|(e, s, seen)| hold(e, s, seen)),
        1 => Just(ToBridge::Stop.into()),
        1 => Just(ToBridge::EmergencyStop.into()),
        3 => epoch().prop_map(|epoch| ToBridge::ResetEmergencyStop { epoch }.into()),
        1 => Just(ToBridge::ResetMap.into()),
    ]
}

fn any_input() -> impl Strategy<Value = Input> {
    let client = prop_oneof![4 => Just(A), 2 => Just(B), 1 => Just(WATCHER)];
    prop_oneof![
        20 => (client, any_asked()).prop_map(|(client, Asked(sequence, asked))| Input::Asks(client, sequence, asked)),
        1 => (1_u32..4).prop_map(Input::Gone),
        1 => any::<bool>().prop_map(Input::Robot),
        1 => Just(Input::Fault(DisarmReason::Bumper)),
        4 => Just(Input::Tick),
    ]
}

/// Makes most driving messages valid: with the epoch of the lease, the next sequence, and a time
/// seen not long ago.
fn likely(input: Input, lease: Option<u32>, sequence: u32, now: Duration) -> Input {
    let seen_at = |ago: u64| now.saturating_sub(at(ago));
    let epoch_of = |epoch: u32| {
        if epoch > 1 {
            lease.unwrap_or(epoch)
        } else {
            epoch
        }
    };
    let Input::Asks(client, later, mut asked) = input else {
        return input;
    };
    match &mut asked {
        ToBridge::Arm { epoch } | ToBridge::ResetEmergencyStop { epoch } => {
            *epoch = epoch_of(*epoch);
        }
        ToBridge::Drive(DriveBody { epoch, seen, .. }) | ToBridge::Hold { epoch, seen, .. } => {
            *epoch = epoch_of(*epoch);
            *seen = seen_at(*seen / 1000).as_micros() as u64;
        }
        _ => (),
    }
    Input::Asks(client, sequence + later, asked)
}

/// The knowledge of a bystander that sees only inputs and outputs.
#[derive(Default)]
struct Bystander {
    lease: Option<(ClientId, u32)>,
    highest_epoch: u32,
    is_armed: bool,
    is_emergency: bool,
    is_up: bool,
    /// When the robot was last ordered to run or go on, until it was ordered to stop.
    runs_since: Option<Duration>,
    sequence: u32,
    moves: u32,
}

impl Bystander {
    fn see(&mut self, now: Duration, input: &Input, out: &[Output]) -> Result<(), TestCaseError> {
        if let &Input::Robot(is_up) = input {
            self.is_up = is_up;
        }
        for output in out {
            self.output(now, input, output)?;
        }
        let is_good_hold =
            matches!(input, Input::Asks(_, _, ToBridge::Hold { .. })) && out.is_empty();
        if let Input::Asks(client, _, ToBridge::Arm { epoch }) = input
            && out.contains(&Output::Changed)
            && self.lease == Some((client.id, *epoch))
        {
            self.is_armed = true;
        }
        if is_good_hold && self.runs_since.is_some() {
            self.runs_since = Some(now);
        }
        if let Some(since) = self.runs_since {
            prop_assert!(
                now < since + at(200),
                "it runs {:?} after its last message",
                now - since
            );
        }
        Ok(())
    }

    fn output(
        &mut self,
        now: Duration,
        input: &Input,
        output: &Output,
    ) -> Result<(), TestCaseError> {
        match *output {
            Output::Order(Order::Command(Command::Stop)) => self.runs_since = None,
            Output::Order(Order::Command(_)) => {
                let Input::Asks(client, sequence, ToBridge::Drive(body)) = input else {
                    return Err(TestCaseError::fail(format!("{input:?} moved the robot")));
                };
                prop_assert_eq!(self.lease, Some((client.id, body.epoch)));
                prop_assert!(
                    client.role.may_drive() && self.is_armed && !self.is_emergency && self.is_up
                );
                prop_assert!(*sequence > self.sequence);
                prop_assert!(now - Duration::from_micros(body.seen) <= at(300));
                self.sequence = *sequence;
                self.runs_since = Some(now);
                self.moves += 1;
            }
            Output::Order(Order::EmergencyStop) => {
                (self.is_emergency, self.is_armed, self.runs_since) = (true, false, None);
            }
            Output::Order(Order::ResetEmergencyStop) => self.is_emergency = false,
            Output::Granted(client, lease) => {
                prop_assert!(lease.epoch > self.highest_epoch, "an epoch was used twice");
                prop_assert!(self.runs_since.is_none(), "taking over must stop first");
                (self.lease, self.highest_epoch) = (Some((client, lease.epoch)), lease.epoch);
                (self.sequence, self.is_armed) = (0, false);
            }
            _ => (),
        }
        Ok(())
    }

    /// The state that the rules report must match what the bystander saw.
    fn compare(&mut self, safety: &Safety) -> Result<(), TestCaseError> {
        self.is_armed &= safety.is_armed();
        prop_assert_eq!(self.is_armed, safety.is_armed());
        prop_assert_eq!(self.is_emergency, safety.is_emergency());
        let is_ready = safety.driver().is_some() && self.is_up && !self.is_emergency;
        prop_assert!(!safety.is_armed() || is_ready);
        prop_assert!(
            self.runs_since.is_none() || safety.is_armed(),
            "disarmed, and it runs"
        );
        if safety.driver().is_none() {
            self.lease = None;
        }
        Ok(())
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn in_any_order_of_things_nothing_moves_that_may_not(
        inputs in prop::collection::vec((any_input(), 0_u64..120), 1..120)
    ) {
        let mut safety = Safety::default();
        let mut bystander = Bystander::default();
        let mut now = at(0);
        for input in [Input::Robot(true), Input::Asks(A, 0, ToBridge::Take { force: false }), Input::Asks(A, 0, ToBridge::Arm { epoch: 1 })] {
            let out = safety.on(now, input.clone());
            bystander.see(now, &input, &out)?;
        }
        for (input, pause) in inputs {
            let until = now + at(pause);
            // As the hub does: whatever expires earlier is processed when it does.
            while let Some(due) = safety.deadline().filter(|due| *due <= until) {
                now = now.max(due);
                let out = safety.on(now, Input::Tick);
                bystander.see(now, &Input::Tick, &out)?;
                bystander.compare(&safety)?;
            }
            now = until;
            let input = likely(input, bystander.lease.map(|lease| lease.1), bystander.sequence, now);
            let out = safety.on(now, input.clone());
            bystander.see(now, &input, &out)?;
            bystander.compare(&safety)?;
        }
    }
}

/// Without this, the property above would also hold if nothing ever moved.
#[test]
fn the_random_inputs_do_move_the_robot() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let mut moves = 0;
    for _ in 0..100 {
        let inputs = prop::collection::vec(any_input(), 60)
            .new_tree(&mut runner)
            .unwrap()
            .current();
        let mut safety = driven();
        let mut bystander = Bystander {
            lease: Some((A.id, 1)),
            highest_epoch: 1,
            is_armed: true,
            is_up: true,
            sequence: 1,
            ..Bystander::default()
        };
        for (millis, input) in inputs.into_iter().enumerate() {
            let now = at(millis as u64);
            let input = likely(
                input,
                bystander.lease.map(|lease| lease.1),
                bystander.sequence,
                now,
            );
            let out = safety.on(now, input.clone());
            bystander.see(now, &input, &out).unwrap();
            bystander.compare(&safety).unwrap();
        }
        moves += bystander.moves;
    }
    assert!(moves > 50, "{moves} moves in 100 runs");
}
