//! The link to an RP6: who is at the other end, and whether a command has reached it.
//!
//! In: bytes from the line, commands, time. Out: bytes for the line, events. It has neither clock
//! nor port: the owner of the port calls [`Link::receive`] with the bytes that arrived and
//! [`Link::tick`] regularly (every 10 ms is enough), and writes the bytes of [`Link::take_output`].
//!
//! ```text
//!             [RP6BOOT]                 [READY] -> sends `s`
//!   Listening ---------> BootLoader --------------------------+
//!      |  quiet for 0.5 s                                      |
//!      v                                                       v
//!   Greeting <------ silence, or a Hello nobody asked for -- Running
//!      |   \---------------- Hello with our nonce ----------->  ^
//!      | nobody answers                                         |
//!      v                                                        |
//!   ResetNeeded <--- EMERGENCY SHUTDOWN (from any phase)        |
//!      \------------------ [RP6BOOT], or a Hello ---------------+
//! ```
//!
//! 1. Opening the port may reset the robot. Then its boot loader speaks, and anything but `s` would
//!    confuse it. So nothing is sent at first, and nothing from `[RP6BOOT]` until `[READY]`.
//! 2. Otherwise the robot is greeted with a nonce until it answers with the same one. A greeting
//!    makes it stand still.
//! 3. Commands go one at a time. Each is resent until it is acknowledged, so none is overtaken and
//!    none is carried out twice. Speeds are not resent: while another command waits for its
//!    acknowledgement, the newest speed waits too, until a later command replaces it. A look aside
//!    does not replace it, because the servo is not the tracks.
//! 4. `Stop` and `EStop` wait for nothing and discard everything that waits.
//! 5. Nothing survives a break of the link: queue and arming are lost, and the link always comes
//!    back disarmed.

#[cfg(test)]
mod tests;
mod text;
mod types;

use std::collections::VecDeque;

pub use self::types::{Down, LinkError, LinkEvent, Phase};

use self::text::{Heard, TextWatch};
use super::{Command, CommandResult, Decoder, Frame, Hello, Report, encode};
use crate::robot::Stamp;
use crate::wire::Tally;

/// How long to listen for a boot loader after opening, s.
const LISTEN: f64 = 0.5;
/// Interval of greetings, s.
const GREET_EVERY: f64 = 0.25;
/// Unanswered greetings after which somebody has to reset the robot. It is still greeted, once
/// every 2 s.
const GREETINGS: u32 = 8;
/// Time after which a command without acknowledgement is resent, s: a frame each way, after one of
/// telemetry, takes 0.02 s at 38400 baud.
const RETRY_AFTER: f64 = 0.06;
/// How often a command is sent before the link counts as broken.
const TRIES: u32 = 5;
/// Silence after which the link counts as broken, s.
const SILENCE: f64 = 1.0;
/// Time that the boot loader and the start of the program may take, s.
const BOOT: f64 = 3.0;
/// Greetings are this much slower when a reset is needed.
const SLOW_GREETING: f64 = 8.0;
/// Commands that may wait.
const LONGEST_QUEUE: usize = 8;

/// A command that has been sent and not acknowledged.
#[derive(Clone, Copy, Debug)]
struct Outstanding {
    command: Command,
    sequence: u8,
    sent: Stamp,
    tries: u32,
}

/// The host's end of the link.
#[derive(Clone, Debug)]
pub struct Link {
    phase: Phase,
    /// When the phase began, when a good frame last arrived, when the last greeting was sent.
    since: Stamp,
    heard: Stamp,
    greeted: Option<Stamp>,
    greetings: u32,
    nonce: u8,
    sequence: u8,
    is_armed: bool,
    outstanding: Option<Outstanding>,
    queue: VecDeque<Command>,
    /// The newest speed (or sign of life) that waits.
    latest: Option<Command>,
    decoder: Decoder<Report>,
    text: TextWatch,
    output: Vec<u8>,
    events: VecDeque<LinkEvent>,
}

impl Link {
    /// A link over a port that was just opened. `nonce` distinguishes this opening from earlier
    /// ones; the caller counts it or draws it at random.
    #[must_use]
    pub fn new(now: Stamp, nonce: u8) -> Self {
        Self {
            phase: Phase::Listening,
            since: now,
            heard: now,
            greeted: None,
            greetings: 0,
            nonce,
            sequence: 0,
            is_armed: false,
            outstanding: None,
            queue: VecDeque::new(),
            latest: None,
            decoder: Decoder::default(),
            text: TextWatch::default(),
            output: Vec::new(),
            events: VecDeque::new(),
        }
    }

    /// The phase of the link.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Whether commands may move the robot.
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.is_armed
    }

    /// Counts of the bytes received.
    #[must_use]
    pub fn tally(&self) -> Tally {
        self.decoder.tally()
    }

    /// Lets commands move the robot, until the link breaks or [`Link::disarm`].
    ///
    /// # Errors    [`LinkError::NotRunning`].
    pub fn arm(&mut self) -> Result<(), LinkError> {
        self.check_running()?;
        self.is_armed = true;
        Ok(())
    }

    /// Lets no command move the robot any more, and stops it.
    pub fn disarm(&mut self, now: Stamp) {
        self.is_armed = false;
        if self.phase == Phase::Running {
            self.overtake(Command::Stop, now);
        }
    }

    /// Takes a command for the robot.
    ///
    /// # Errors    [`LinkError`]: no robot, not armed, too many commands wait. `Stop` and `EStop`
    /// of a running robot never fail.
    pub fn command(&mut self, command: Command, now: Stamp) -> Result<(), LinkError> {
        self.check_running()?;
        if matches!(command, Command::Stop | Command::EStop) {
            self.overtake(command, now);
            return Ok(());
        }
        if command.moves() && !self.is_armed {
            return Err(LinkError::Disarmed);
        }
        if command.is_reliable() {
            if self.queue.len() >= LONGEST_QUEUE {
                return Err(LinkError::QueueFull);
            }
            if !command.looks_aside() {
                self.latest = None;
            }
            self.queue.push_back(command);
        } else if !matches!((command, self.latest), (Command::Alive, Some(_))) {
            self.latest = Some(command);
        }
        self.send_next(now);
        Ok(())
    }

    /// Takes bytes as they arrive.
    pub fn receive(&mut self, bytes: &[u8], now: Stamp) {
        for &byte in bytes {
            if let Some(heard) = self.text.push(byte) {
                self.hear(heard, now);
            }
            if let Some(frame) = self.decoder.push_byte(byte) {
                self.take(frame, now);
            }
        }
    }

    /// Lets time pass: resends, greets, detects silence.
    pub fn tick(&mut self, now: Stamp) {
        match self.phase {
            Phase::Listening if now.since(self.since) >= LISTEN => self.greet_anew(now),
            Phase::BootLoader if now.since(self.since) >= BOOT => self.greet_anew(now),
            Phase::Greeting => self.greet_if_due(1.0, now),
            Phase::ResetNeeded => self.greet_if_due(SLOW_GREETING, now),
            Phase::Running if now.since(self.heard) >= SILENCE => {
                self.go_down(Down::Silence, now);
            }
            Phase::Running => self.send_again_if_due(now),
            Phase::Listening | Phase::BootLoader => (),
        }
    }

    /// The port is gone. Afterwards the link listens as if just opened, under another nonce.
    pub fn close(&mut self, now: Stamp) {
        self.lose(Down::Closed);
        self.decoder.restart();
        self.text = TextWatch::default();
        self.output.clear();
        self.enter(Phase::Listening, now);
    }

    /// Bytes to be written to the line.
    #[must_use]
    pub fn take_output(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.output)
    }

    /// The next event.
    pub fn next_event(&mut self) -> Option<LinkEvent> {
        self.events.pop_front()
    }

    fn check_running(&self) -> Result<(), LinkError> {
        match self.phase {
            Phase::Running => Ok(()),
            phase => Err(LinkError::NotRunning { phase }),
        }
    }

    fn hear(&mut self, heard: Heard, now: Stamp) {
        match heard {
            // Also if ready arrives without the boot loader's name: its first line may have been
            // lost.
            Heard::BootLoader | Heard::Ready => {
                self.lose(Down::Restarted);
                if heard == Heard::Ready {
                    self.output.push(b's');
                }
                self.enter(Phase::BootLoader, now);
            }
            Heard::EmergencyShutdown => {
                self.lose(Down::EmergencyShutdown);
                if self.phase != Phase::ResetNeeded {
                    self.enter(Phase::ResetNeeded, now);
                }
            }
        }
    }

    fn take(&mut self, frame: Frame<Report>, now: Stamp) {
        self.heard = now;
        match frame.message {
            Report::Hello(hello) => self.take_hello(hello, now),
            // Sent before the restart of robot or link: ignored until the robot has greeted back.
            _ if self.phase != Phase::Running => (),
            Report::Ack { of, result } => self.take_ack(of, result, now),
            Report::Telemetry(telemetry) => self.events.push_back(LinkEvent::Telemetry(telemetry)),
            Report::Ranger(ranger) => self.events.push_back(LinkEvent::Ranger(ranger)),
        }
    }

    fn take_hello(&mut self, hello: Hello, now: Stamp) {
        if hello.protocol != super::PROTOCOL {
            self.lose(Down::OtherProtocol(hello.protocol));
            // If the phase were entered again, the robot would be greeted at once, and answer at
            // once.
            if self.phase != Phase::ResetNeeded {
                self.enter(Phase::ResetNeeded, now);
            }
            return;
        }
        let is_answer = hello.nonce == self.nonce && hello.nonce != 0;
        if is_answer && self.phase == Phase::Running {
            return; // To a greeting that was sent twice.
        }
        if is_answer && self.greetings > 0 {
            self.enter(Phase::Running, now);
            self.events.push_back(LinkEvent::Up(hello));
            return;
        }
        // It spoke first: it has just started. A greeting makes sure that it also hears us.
        if hello.nonce == 0 {
            self.lose(Down::Restarted);
            self.greet_anew(now);
        }
    }

    fn take_ack(&mut self, of: u8, result: CommandResult, now: Stamp) {
        let Some(done) = self.outstanding.filter(|o| o.sequence == of) else {
            return; // Of a speed, or of a command that was overtaken.
        };
        self.outstanding = None;
        self.events.push_back(LinkEvent::Acknowledged {
            command: done.command,
            result,
        });
        self.send_next(now);
    }

    /// Sends at once, and drops everything that waits.
    fn overtake(&mut self, command: Command, now: Stamp) {
        self.drop_waiting();
        self.queue.push_back(command);
        self.send_next(now);
    }

    fn send_next(&mut self, now: Stamp) {
        if self.outstanding.is_some() {
            return;
        }
        if let Some(command) = self.queue.pop_front() {
            let sequence = self.send(&command);
            self.outstanding = Some(Outstanding {
                command,
                sequence,
                sent: now,
                tries: 1,
            });
        } else if let Some(command) = self.latest.take() {
            self.send(&command);
        }
    }

    fn send(&mut self, command: &Command) -> u8 {
        self.sequence = self.sequence.wrapping_add(1);
        self.output.extend(encode(self.sequence, command));
        self.sequence
    }

    fn send_again_if_due(&mut self, now: Stamp) {
        let Some(waiting) = &mut self.outstanding else {
            return;
        };
        if now.since(waiting.sent) < RETRY_AFTER {
            return;
        }
        if waiting.tries >= TRIES {
            self.go_down(Down::Unanswered, now);
            return;
        }
        waiting.tries += 1;
        waiting.sent = now;
        self.output
            .extend(encode(waiting.sequence, &waiting.command));
    }

    fn greet_anew(&mut self, now: Stamp) {
        self.enter(Phase::Greeting, now);
        self.greet(now);
    }

    fn greet_if_due(&mut self, slower: f64, now: Stamp) {
        let every = GREET_EVERY * slower;
        if self.greeted.is_some_and(|last| now.since(last) < every) {
            return;
        }
        if self.phase == Phase::Greeting && self.greetings >= GREETINGS {
            self.events.push_back(LinkEvent::Down(Down::NobodyThere));
            self.enter(Phase::ResetNeeded, now);
            self.greeted = Some(now);
            return;
        }
        self.greet(now);
    }

    fn greet(&mut self, now: Stamp) {
        let nonce = self.nonce;
        self.send(&Command::Greet { nonce });
        self.greeted = Some(now);
        self.greetings = self.greetings.saturating_add(1);
    }

    fn go_down(&mut self, why: Down, now: Stamp) {
        self.lose(why);
        self.greet_anew(now);
    }

    /// Drops everything that depended on the robot being there. Reports it once.
    fn lose(&mut self, why: Down) {
        let is_news = self.phase == Phase::Running
            || matches!(why, Down::EmergencyShutdown | Down::OtherProtocol(_))
                && self.phase != Phase::ResetNeeded;
        self.is_armed = false;
        self.drop_waiting();
        if is_news {
            self.events.push_back(LinkEvent::Down(why));
        }
    }

    fn drop_waiting(&mut self) {
        let waiting = self.outstanding.take().map(|o| o.command);
        let dropped = waiting.into_iter().chain(self.queue.drain(..));
        self.events.extend(dropped.map(LinkEvent::Dropped));
        self.latest = None;
    }

    fn enter(&mut self, phase: Phase, now: Stamp) {
        if phase == Phase::Greeting || phase == Phase::Listening {
            // A new nonce: a late answer to an old greeting is no answer. 0 is reserved for the
            // robot.
            self.nonce = self.nonce.checked_add(1).unwrap_or(1);
            self.greetings = 0;
        }
        self.phase = phase;
        self.since = now;
        self.heard = now;
        self.greeted = None;
    }
}
