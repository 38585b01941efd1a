//! Decodes answers from a stream of bytes, in pieces of any size and with any noise.
//!
//! In: bytes. Out: [`Answer`]s.
//!
//! 1. Between answers, search for a known descriptor, byte by byte.
//! 2. After the descriptor of a single answer, take its bytes; after that of a scan, take nodes or
//!    capsules until [`Decoder::expect_answer`].
//! 3. A node has only three check bits. In step, one good node is enough; out of step,
//!    [`NODES_TO_LOCK`] good ones in a row with successive angles are needed before the first
//!    counts.
//! 4. A capsule has a checksum of 8 bits; out of step, its marks are searched for byte by byte.
//! 5. Throughout, the banner of a restarting sensor is detected among the bytes thrown away.

use super::answer::{Descriptor, Health, Info, Rate};
use super::express::{Capsule, has_marks};
use super::node::{FULL_TURN, Node};
use super::{SYNC, SYNC_OF_ANSWER};
use crate::wire::inbox::{Inbox, Tally};

/// Good nodes in a row before the stream counts as in step again. Out of step by one byte, a node
/// passes its check bits by chance about every other time.
pub const NODES_TO_LOCK: usize = 6;
/// Greatest angle from one node to the next if the stream is in step, 1/64° (20°, either way).
const NEAR: u16 = 20 * 64;
/// The beginning of the sensor's banner.
const BANNER: &[u8] = b"RP LIDAR";

/// Answers of the sensor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// A scan begins.
    Begins(Descriptor),
    /// Its description of itself.
    Info(Info),
    /// Its health.
    Health(Health),
    /// Its sample times.
    Rate(Rate),
    /// A reading of a standard scan.
    Node(Node),
    /// 32 readings of an express scan.
    Capsule {
        /// The capsule.
        capsule: Box<Capsule>,
        /// Whether nothing was lost since the previous capsule, so that this one's angle completes
        /// it.
        follows: bool,
    },
    /// It has restarted, after power-on or reset, and has forgotten all earlier requests.
    Restarted,
}

/// What the decoder is in the middle of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Expects {
    #[default]
    Descriptor,
    Single(Descriptor),
    Nodes {
        in_step: bool,
    },
    Capsules {
        in_step: bool,
    },
}

/// Decodes what the sensor sends.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    inbox: Inbox,
    expects: Expects,
    /// How many bytes of [`BANNER`] the last bytes match.
    banner: usize,
}

/// What was made of the bytes at the front; none if some are missing.
type Step = Option<Made>;

enum Made {
    Answer(Answer),
    Progress,
}

impl Decoder {
    /// Takes bytes as they arrive.
    pub fn extend(&mut self, bytes: &[u8]) {
        self.inbox.extend(bytes);
    }

    /// A request was sent: drops the waiting bytes, ends a scan and searches for the descriptor of
    /// the answer.
    pub fn expect_answer(&mut self) {
        self.inbox.discard(usize::MAX);
        self.expects = Expects::Descriptor;
        self.banner = 0;
    }

    /// Counts of the bytes.
    #[must_use]
    pub fn tally(&self) -> Tally {
        self.inbox.tally()
    }

    fn step(&mut self) -> Step {
        match self.expects {
            Expects::Descriptor => self.descriptor(),
            Expects::Single(descriptor) => self.single(descriptor),
            Expects::Nodes { in_step: true } => self.node(),
            Expects::Nodes { in_step: false } => self.find_nodes(),
            Expects::Capsules { in_step } => self.capsule(in_step),
        }
    }

    fn descriptor(&mut self) -> Step {
        if self.inbox.peek(0)? != [SYNC] || self.inbox.peek(1)? != [SYNC_OF_ANSWER] {
            return self.discard(1);
        }
        let Some(descriptor) = Descriptor::decode(self.inbox.peek(0)?) else {
            self.inbox.reject();
            return self.discard(1);
        };
        self.inbox.accept(Descriptor::LEN);
        self.expects = match descriptor {
            Descriptor::Scan => Expects::Nodes { in_step: true },
            Descriptor::Express => Expects::Capsules { in_step: false },
            Descriptor::Info | Descriptor::Health | Descriptor::Rate => {
                self.expects = Expects::Single(descriptor);
                return Some(Made::Progress);
            }
        };
        Some(Made::Answer(Answer::Begins(descriptor)))
    }

    fn single(&mut self, descriptor: Descriptor) -> Step {
        let inbox = &self.inbox;
        let (length, answer) = match descriptor {
            Descriptor::Info => (Info::LEN, Some(Answer::Info(Info::decode(inbox.peek(0)?)))),
            Descriptor::Health => (
                Health::LEN,
                Health::decode(inbox.peek(0)?).map(Answer::Health),
            ),
            Descriptor::Rate => (Rate::LEN, Some(Answer::Rate(Rate::decode(inbox.peek(0)?)))),
            // Scans are endless; their descriptors are handled elsewhere.
            Descriptor::Scan | Descriptor::Express => (0, None),
        };
        self.expects = Expects::Descriptor;
        if let Some(answer) = answer {
            self.inbox.accept(length);
            return Some(Made::Answer(answer));
        }
        self.inbox.reject();
        self.discard(1)
    }

    fn node(&mut self) -> Step {
        if let Some(node) = Node::decode(self.inbox.peek(0)?) {
            self.inbox.accept(Node::LEN);
            return Some(Made::Answer(Answer::Node(node)));
        }
        self.inbox.reject();
        self.expects = Expects::Nodes { in_step: false };
        self.discard(1)
    }

    /// Out of step: throws bytes away until enough good nodes are in a row.
    fn find_nodes(&mut self) -> Step {
        let mut last: Option<Node> = None;
        for place in 0..NODES_TO_LOCK {
            let Some(node) = Node::decode(self.inbox.peek(place * Node::LEN)?) else {
                return self.discard(1);
            };
            if last.is_some_and(|last| !is_near(last, node)) {
                return self.discard(1);
            }
            last = Some(node);
        }
        self.expects = Expects::Nodes { in_step: true };
        Some(Made::Progress)
    }

    fn capsule(&mut self, in_step: bool) -> Step {
        if !has_marks(self.inbox.peek(0)?) {
            self.expects = Expects::Capsules { in_step: false };
            return self.discard(1);
        }
        let Some(capsule) = Capsule::decode(&self.inbox.peek(0)?) else {
            self.expects = Expects::Capsules { in_step: false };
            self.inbox.reject();
            return self.discard(1);
        };
        self.inbox.accept(Capsule::LEN);
        self.expects = Expects::Capsules { in_step: true };
        Some(Made::Answer(Answer::Capsule {
            follows: in_step && !capsule.starts,
            capsule: Box::new(capsule),
        }))
    }

    fn discard(&mut self, count: usize) -> Step {
        let mut is_banner = false;
        for byte in self.inbox.drain(count) {
            let expected = BANNER.get(self.banner);
            self.banner = if expected == Some(&byte) {
                self.banner + 1
            } else {
                usize::from(BANNER.first() == Some(&byte))
            };
            if self.banner == BANNER.len() {
                self.banner = 0;
                is_banner = true;
            }
        }
        if is_banner {
            self.expects = Expects::Descriptor;
            return Some(Made::Answer(Answer::Restarted));
        }
        Some(Made::Progress)
    }
}

impl Iterator for Decoder {
    type Item = Answer;

    /// The next complete answer.
    fn next(&mut self) -> Option<Answer> {
        loop {
            if let Made::Answer(answer) = self.step()? {
                return Some(answer);
            }
        }
    }
}

fn is_near(before: Node, after: Node) -> bool {
    let step = (after.angle + FULL_TURN - before.angle) % FULL_TURN;
    step.min(FULL_TURN - step) <= NEAR
}
