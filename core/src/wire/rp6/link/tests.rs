use super::*;
use crate::wire::rp6::ResetCause;
use crate::wire::rp6::fixture::hello;

/// A link, a clock, and the robot's end of the line according to the protocol.
struct Bench {
    link: Link,
    now: f64,
    to_robot: Decoder<Command>,
    sequence: u8,
}

impl Bench {
    fn new() -> Self {
        Self {
            link: Link::new(Stamp(0), 40),
            now: 0.0,
            to_robot: Decoder::default(),
            sequence: 0,
        }
    }

    fn running() -> Self {
        let mut bench = Self::new();
        bench.pass(0.6);
        bench.answer_greeting();
        assert_eq!(bench.link.phase(), Phase::Running);
        assert!(matches!(bench.events()[..], [LinkEvent::Up(_)]));
        bench
    }

    fn stamp(&self) -> Stamp {
        Stamp::from_seconds(self.now)
    }

    /// Lets time pass in steps of 10 ms; returns what was sent.
    fn pass(&mut self, seconds: f64) -> Vec<Frame<Command>> {
        let end = self.now + seconds;
        let mut sent = Vec::new();
        while self.now < end {
            self.now += 0.01;
            self.link.tick(self.stamp());
            sent.extend(self.sent());
        }
        sent
    }

    fn sent(&mut self) -> Vec<Frame<Command>> {
        let bytes = self.link.take_output();
        self.to_robot.push(&bytes).collect()
    }

    fn say(&mut self, report: &Report) {
        self.sequence = self.sequence.wrapping_add(1);
        let bytes = encode(self.sequence, report);
        self.link.receive(&bytes, self.stamp());
    }

    fn text(&mut self, text: &str) {
        self.link.receive(text.as_bytes(), self.stamp());
    }

    fn hello(&mut self, nonce: u8) {
        self.say(&Report::Hello(hello(nonce)));
    }

    /// Waits for the next greeting and answers it.
    fn answer_greeting(&mut self) {
        let nonce = self.link.nonce;
        self.hello(nonce);
        let _ = self.link.take_output();
    }

    fn ack(&mut self, of: u8) {
        let result = CommandResult::Done;
        self.say(&Report::Ack { of, result });
    }

    fn events(&mut self) -> Vec<LinkEvent> {
        std::iter::from_fn(|| self.link.next_event()).collect()
    }

    fn command(&mut self, command: Command) -> Result<(), LinkError> {
        self.link.command(command, self.stamp())
    }
}

const FORWARD: Command = Command::Forward { way_um: 500_000 };
const SPEED: Command = Command::Velocity {
    forward_mm_s: 100,
    turn_mrad_s: 0,
};

fn commands(frames: &[Frame<Command>]) -> Vec<Command> {
    frames.iter().map(|f| f.message).collect()
}

#[test]
fn nothing_is_sent_while_a_boot_loader_may_listen_then_the_robot_is_greeted() {
    let mut bench = Bench::new();
    assert_eq!(bench.pass(0.45), []);
    let sent = bench.pass(0.2);
    assert!(matches!(sent[..], [Frame { message: Command::Greet { nonce }, .. }] if nonce != 0));
    bench.answer_greeting();
    assert_eq!(bench.link.phase(), Phase::Running);
    assert!(!bench.link.is_armed());
}

#[test]
fn the_boot_loader_gets_its_s_only_after_ready() {
    let mut bench = Bench::new();
    bench.text("\n[RP6B");
    bench.text("OOT]\n\n");
    assert_eq!(bench.link.phase(), Phase::BootLoader);
    bench.pass(1.0);
    assert_eq!(bench.link.take_output(), b"");
    bench.text("[READY]");
    assert_eq!(bench.link.take_output(), b"s");
    // The program starts and speaks first; that alone is not enough, because it may not hear us.
    bench.hello(0);
    assert_eq!(bench.link.phase(), Phase::Greeting);
    assert_eq!(bench.sent().len(), 1);
    bench.answer_greeting();
    assert_eq!(bench.link.phase(), Phase::Running);
}

#[test]
fn a_program_that_does_not_start_is_greeted_and_then_needs_a_reset_and_comes_back_by_one() {
    let mut bench = Bench::new();
    bench.text("[RP6BOOT]\n[READY]\n");
    assert_eq!(bench.pass(10.0).len(), 8 + 2);
    assert_eq!(bench.link.phase(), Phase::ResetNeeded);
    assert_eq!(bench.events(), [LinkEvent::Down(Down::NobodyThere)]);
    bench.text("[RP6BOOT]\n[READY]\n");
    assert_eq!(bench.link.take_output(), b"s");
    bench.hello(0);
    bench.answer_greeting();
    assert_eq!(bench.link.phase(), Phase::Running);
    assert!(!bench.link.is_armed());
}

#[test]
fn a_late_answer_to_an_old_greeting_is_none() {
    let mut bench = Bench::new();
    bench.pass(0.6);
    let old = bench.link.nonce.wrapping_sub(1);
    bench.hello(old);
    assert_eq!(bench.link.phase(), Phase::Greeting);
}

#[test]
fn what_moves_needs_arming_and_every_break_disarms() {
    let breaks: [fn(&mut Bench); 5] = [
        |b| drop(b.pass(1.1)),
        |b| b.text("##### EMERGENCY SHUTDOWN #####"),
        |b| b.text("[RP6BOOT]"),
        |b| b.hello(0),
        |b| b.link.close(Stamp::from_seconds(b.now)),
    ];
    let reasons = [
        Down::Silence,
        Down::EmergencyShutdown,
        Down::Restarted,
        Down::Restarted,
        Down::Closed,
    ];
    for (break_it, reason) in breaks.into_iter().zip(reasons) {
        let mut bench = Bench::running();
        assert_eq!(bench.command(FORWARD), Err(LinkError::Disarmed));
        assert_eq!(bench.command(SPEED), Err(LinkError::Disarmed));
        assert_eq!(bench.command(Command::Alive), Ok(()));
        assert_eq!(bench.link.arm(), Ok(()));
        assert_eq!(bench.command(FORWARD), Ok(()));
        break_it(&mut bench);
        let events = bench.events();
        let silent = reason == Down::Silence;
        // If a command waits and nothing is heard, the link is unanswered before it is silent.
        let down = LinkEvent::Down(if silent { Down::Unanswered } else { reason });
        assert!(events.contains(&down), "{events:?}");
        assert!(events.contains(&LinkEvent::Dropped(FORWARD)), "{events:?}");
        assert!(!bench.link.is_armed());
        assert!(matches!(
            bench.command(Command::Stop),
            Err(LinkError::NotRunning { .. })
        ));
        assert!(matches!(
            bench.link.arm(),
            Err(LinkError::NotRunning { .. })
        ));
    }
}

#[test]
fn silence_breaks_a_link_that_waits_for_nothing() {
    let mut bench = Bench::running();
    let sent = bench.pass(1.1);
    assert_eq!(bench.events(), [LinkEvent::Down(Down::Silence)]);
    assert!(matches!(commands(&sent)[..], [Command::Greet { .. }]));
}

#[test]
fn a_command_is_sent_again_with_its_own_number_until_it_is_acknowledged() {
    let mut bench = Bench::running();
    bench.link.arm().expect("it runs");
    bench.command(FORWARD).expect("it is armed");
    let mut sent = bench.sent();
    sent.extend(bench.pass(0.14));
    assert_eq!(commands(&sent), [FORWARD; 3]);
    assert!(sent.iter().all(|f| f.sequence == sent[0].sequence));
    bench.ack(sent[0].sequence.wrapping_add(1));
    bench.ack(sent[0].sequence);
    let expected = LinkEvent::Acknowledged {
        command: FORWARD,
        result: CommandResult::Done,
    };
    assert_eq!(bench.events(), [expected]);
    assert_eq!(bench.pass(0.5), []);
}

#[test]
fn speeds_wait_for_a_command_and_only_the_newest_is_sent() {
    let mut bench = Bench::running();
    bench.link.arm().expect("it runs");
    bench
        .command(Command::SetRate { period_ms: 50 })
        .expect("room");
    let first = bench.sent();
    let slow = Command::Velocity {
        forward_mm_s: 10,
        turn_mrad_s: 0,
    };
    bench.command(slow).expect("armed");
    bench.command(SPEED).expect("armed");
    bench.command(Command::Alive).expect("running");
    assert_eq!(bench.sent(), []);
    bench.ack(first[0].sequence);
    assert_eq!(commands(&bench.sent()), [SPEED]);
}

#[test]
fn a_stop_overtakes_everything_that_waits() {
    let mut bench = Bench::running();
    bench.link.arm().expect("it runs");
    bench.command(FORWARD).expect("armed");
    bench
        .command(Command::Turn { angle_urad: 1 })
        .expect("room");
    bench.command(SPEED).expect("armed");
    bench.sent();
    bench.command(Command::EStop).expect("never refused");
    let sent = bench.sent();
    assert_eq!(commands(&sent), [Command::EStop]);
    let dropped = [
        LinkEvent::Dropped(FORWARD),
        LinkEvent::Dropped(Command::Turn { angle_urad: 1 }),
    ];
    assert_eq!(bench.events(), dropped);
    bench.ack(sent[0].sequence);
    assert_eq!(bench.pass(0.3), []);
}

#[test]
fn the_queue_is_bounded() {
    let mut bench = Bench::running();
    let servo = Command::Servo { angle_mrad: 0 };
    // One is under way, the others wait.
    for _ in 0..=LONGEST_QUEUE {
        assert_eq!(bench.command(servo), Ok(()));
    }
    assert_eq!(bench.command(servo), Err(LinkError::QueueFull));
    assert_eq!(bench.command(Command::Stop), Ok(()));
}

#[test]
fn disarming_stops_the_robot() {
    let mut bench = Bench::running();
    bench.link.arm().expect("it runs");
    bench.link.disarm(bench.stamp());
    assert_eq!(commands(&bench.sent()), [Command::Stop]);
    assert_eq!(bench.command(SPEED), Err(LinkError::Disarmed));
}

#[test]
fn another_version_of_the_protocol_is_named_once_and_greeted_slowly() {
    let mut bench = Bench::new();
    bench.pass(0.6);
    let hello = Report::Hello(Hello {
        protocol: 77,
        firmware: [9, 0],
        nonce: 0,
        cause: ResetCause::PowerOn,
        capabilities: 0,
        length_mm: 0,
        width_mm: 0,
        track_width_mm: 0,
        count_nm: 0,
        max_speed_mm_s: 0,
        ranger_angles_mrad: Vec::new(),
    });
    bench.say(&hello);
    assert_eq!(bench.link.phase(), Phase::ResetNeeded);
    // It answers each greeting; its firmware might be replaced meanwhile, so it is still greeted.
    let mut greetings = 0;
    for _ in 0..400 {
        if !bench.pass(0.01).is_empty() {
            greetings += 1;
            bench.say(&hello);
        }
    }
    assert!((2..=3).contains(&greetings), "{greetings} in 4 s");
    assert_eq!(bench.events(), [LinkEvent::Down(Down::OtherProtocol(77))]);
    assert_eq!(bench.link.phase(), Phase::ResetNeeded);
}

/// Before, a driver lost each speed that waited for the acknowledgement of a look aside.
#[test]
fn a_look_aside_does_not_take_the_place_of_a_speed_that_waits() {
    let look = Command::Sweep {
        from_mrad: 524,
        to_mrad: 524,
        step_mrad: 1,
    };
    let round = Command::Sweep {
        from_mrad: -785,
        to_mrad: 785,
        step_mrad: 20,
    };
    for (sweep, goes_on) in [(look, true), (round, false)] {
        let mut bench = Bench::running();
        bench.link.arm().unwrap();
        bench.command(Command::SetRate { period_ms: 20 }).unwrap();
        let first = bench.sent();
        bench.command(SPEED).unwrap();
        bench.command(sweep).unwrap();
        bench.ack(first[0].sequence);
        let second = bench.sent();
        assert_eq!(commands(&second), [sweep]);
        bench.ack(second[0].sequence);
        let rest = commands(&bench.sent());
        assert_eq!(rest == [SPEED], goes_on, "{sweep:?}: {rest:?}");
    }
}
