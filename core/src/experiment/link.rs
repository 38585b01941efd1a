//! An experiment as a line of text, short enough for an address: its beginning, what a person did,
//! and the result.
//!
//! ```text
//! run&world=office&sensor=lidar&method=line-ekf&seed=7&set=ekf.gate:9.2&do=120:goto,3.2,1.5;300:stop&until=400&hash=0123456789abcdef
//! ```
//!
//! | field | |
//! |---|---|
//! | `world`, `sensor`, `method`, `seed` | by their names; all are required |
//! | `drawn` | in place of `world`: a world file that comes with the link, packed |
//! | `mode` | the mode at the beginning: `explore` (default) or `manual` |
//! | `cycle` | `1`: it drives by the cycle |
//! | `set` | settings that differ from their defaults, `KEY:NUMBER`, separated by `;` |
//! | `do` | what was done, `PERIOD:ACTION`, separated by `;`, in order of time; `PERIOD~:…` if the pilot had already decided on the period |
//! | `until`, `hash` | periods until the link was made, and the hash of the state then |
//!
//! Actions are `explore`, `manual`, `goto,X,Y`, `drive,FORWARD,TURN`, `stop`, `kidnap`,
//! `door,NUMBER,1` (or 0: shut), `cycle,1` (or 0) and `set,KEY:NUMBER,…`: all settings that differ
//! from their defaults. Lengths are in metres, angles in radians; a period is
//! [`super::CONTROL_PERIOD`]. Text before a `#` is ignored, so a whole address is a link as well.

mod drawing;

use std::fmt::{self, Write as _};

use nalgebra::Point2;

use super::{Action, ExperimentConfig, TimedAction};
use crate::format::world;
use crate::pilot::Mode;
use crate::settings::{Scope, SettingError, Settings, Source};
use crate::sim::{SensorKind, World, worlds};
use crate::slam::Method;

/// Longer links are not read, bytes, not counting a world that comes with them: the actions in a
/// link take many times as much memory as their letters.
const MOST_BYTES: usize = 64_000;
/// The same for the letters of a world that comes with it.
const MOST_DRAWN: usize = 1_400_000;

/// Why a text is not a link, or an experiment cannot be written as one.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// Longer than browsers accept.
    #[error("the link is {0} bytes long, at most {MOST_BYTES}")]
    TooLong(usize),
    /// Does not begin with `run&`.
    #[error("that is no link to an experiment: such a one has `#run&world=…`")]
    NoLink,
    /// A required field is missing.
    #[error("the link has no `{0}`")]
    Missing(&'static str),
    /// A field with an unknown name.
    #[error("the link has `{0}`, which is no field of one")]
    Field(String),
    /// A field with an invalid value.
    #[error("the link's `{field}` is `{found}`, expected {expected}")]
    Value {
        /// Its name.
        field: &'static str,
        /// Its value.
        found: String,
        /// What it should be.
        expected: &'static str,
    },
    /// A world too large to be packed into a link, or unpacked from one.
    #[error("the world of the link is {0} bytes long, at most {most}", most = drawing::MOST_TEXT)]
    DrawingTooLong(usize),
    /// A world in the link that cannot be unpacked.
    #[error("the world in the link is damaged: it was perhaps not copied as a whole")]
    Damaged,
    /// A world in the link that was unpacked, but that no robot can be in.
    #[error("the world in the link: {0}")]
    Drawing(String),
    /// There is no built-in world with that name.
    #[error("the link's world is `{0}`, expected one of {expected}", expected = worlds::NAMES.join(", "))]
    World(String),
    /// A setting is wrong.
    #[error("the link's settings: {0}")]
    Setting(#[from] SettingError),
}

/// Where an experiment takes place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// In a built-in world, by its name.
    Builtin(String),
    /// In one that comes with the link: the text of its file.
    Drawn(String),
}

impl Place {
    /// The world.
    ///
    /// # Errors    [`LinkError::World`], [`LinkError::Drawing`].
    pub fn load(&self) -> Result<World, LinkError> {
        match self {
            Self::Builtin(name) => {
                worlds::builtin(name).ok_or_else(|| LinkError::World(name.clone()))
            }
            Self::Drawn(text) => {
                let read = world::read(text.as_bytes());
                read.map_err(|fault| LinkError::Drawing(fault.to_string()))
            }
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Builtin(name) => name,
            Self::Drawn(_) => "a world of its own",
        })
    }
}

/// An experiment that can be repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Where it takes place.
    pub world: Place,
    /// The robot's sensor.
    pub sensor: SensorKind,
    /// How the pose is estimated.
    pub method: Method,
    /// Seed of all noise.
    pub seed: u64,
    /// The mode at the beginning: by hand or exploring.
    pub mode: Mode,
    /// Whether it drives by the cycle.
    pub cycle: bool,
    /// Settings that differ from their defaults.
    pub settings: Vec<(String, f64)>,
    /// What was done.
    pub actions: Vec<TimedAction>,
    /// Periods until the link was made, and the hash of the state then.
    pub result: Option<(u64, u64)>,
}

impl Link {
    /// Reads a link, or an address with a link after its `#`.
    ///
    /// # Errors    [`LinkError`], naming the first field that is wrong.
    pub fn read(text: &str) -> Result<Self, LinkError> {
        if text.len() > MOST_BYTES + MOST_DRAWN {
            return Err(LinkError::TooLong(text.len()));
        }
        let behind = text.split_once('#').map_or(text, |(_, behind)| behind);
        let fields = behind.trim().strip_prefix("run&");
        let fields = fields.ok_or(LinkError::NoLink)?;
        // A text that is too long is reported first, whatever it contains.
        let drawn = fields.split("&drawn=").nth(1).unwrap_or_default();
        let drawn = drawn.split('&').next().map_or(0, str::len);
        if drawn > MOST_DRAWN || text.len() - drawn > MOST_BYTES {
            return Err(LinkError::TooLong(text.len()));
        }
        let mut given = Given::default();
        for field in fields.split('&').filter(|field| !field.is_empty()) {
            let (name, value) = field.split_once('=').unwrap_or((field, ""));
            let Some(at) = NAMES.iter().position(|known| *known == name) else {
                return Err(LinkError::Field(name.chars().take(SHOWN).collect()));
            };
            if let Some(place) = given.0.get_mut(at) {
                *place = Some(value);
            }
        }
        given.link()
    }

    /// The text of the link. Addresses and messengers may allow less than this module can read:
    /// callers that share it should say so.
    ///
    /// # Errors    [`LinkError::TooLong`], [`LinkError::DrawingTooLong`].
    pub fn write(&self) -> Result<String, LinkError> {
        let (sensor, method, seed) = (self.sensor.name(), self.method.name(), self.seed);
        let mut text = "run".to_owned();
        if let Place::Builtin(name) = &self.world {
            write!(text, "&world={name}").ok();
        }
        write!(text, "&sensor={sensor}&method={method}&seed={seed}").ok();
        if self.mode == Mode::Manual {
            text += "&mode=manual";
        }
        if self.cycle {
            text += "&cycle=1";
        }
        if !self.settings.is_empty() {
            text += "&set=";
            text += &pairs(&self.settings, ";");
        }
        let defaults = self.defaults()?;
        for (at, timed) in self.actions.iter().enumerate() {
            text += if at == 0 { "&do=" } else { ";" };
            let decided = if timed.is_decided { "~" } else { "" };
            let what = words(&timed.action, &defaults);
            // Writing to a text cannot fail.
            write!(text, "{}{decided}:{what}", timed.period).ok();
        }
        if let Some((until, hash)) = self.result {
            write!(text, "&until={until}&hash={hash:016x}").ok();
        }
        if text.len() > MOST_BYTES {
            return Err(LinkError::TooLong(text.len()));
        }
        // At the end: if a link was cut short, it is the world that is incomplete, and so this is
        // noticed.
        if let Place::Drawn(world) = &self.world {
            text += "&drawn=";
            text += &drawing::pack(world)?;
        }
        Ok(text)
    }

    /// The run at its beginning, and its settings before any change.
    ///
    /// # Errors    [`LinkError::World`], [`LinkError::Drawing`], [`LinkError::Setting`].
    pub fn config(&self) -> Result<(ExperimentConfig, Settings), LinkError> {
        let world = self.world.load()?;
        let robot = world.robot.model();
        let defaults = Settings::of(self.sensor.model(), &robot);
        let settings = self.changed(&defaults, self.settings.clone())?;
        let config = ExperimentConfig {
            method: self.method,
            mode: self.mode,
            cycle: self.cycle,
            ..ExperimentConfig::of(&settings, world, robot, self.seed)
        };
        Ok((config, defaults))
    }

    fn defaults(&self) -> Result<Settings, LinkError> {
        let robot = self.world.load()?.robot.model();
        Ok(Settings::of(self.sensor.model(), &robot))
    }

    fn changed(
        &self,
        defaults: &Settings,
        changes: Vec<(String, f64)>,
    ) -> Result<Settings, LinkError> {
        let scope = Scope {
            source: Source::Simulation,
            method: self.method,
        };
        let mut settings = defaults.clone();
        settings.take(&scope, changes)?;
        Ok(settings)
    }
}

const NAMES: [&str; 11] = [
    "world", "sensor", "method", "seed", "mode", "cycle", "set", "do", "until", "hash", "drawn",
];

/// The value of each of [`NAMES`] in a text.
#[derive(Default)]
struct Given<'a>([Option<&'a str>; NAMES.len()]);

impl Given<'_> {
    fn link(&self) -> Result<Link, LinkError> {
        let Self(
            [
                world,
                sensor,
                method,
                seed,
                mode,
                cycle,
                set,
                done,
                until,
                hash,
                drawn,
            ],
        ) = *self;
        let world = match (world, drawn) {
            // A mistyped world is reported first, whatever else is missing.
            (Some(name), None) if !worlds::NAMES.contains(&name) => {
                return Err(LinkError::World(name.to_owned()));
            }
            (Some(name), None) => Place::Builtin(name.to_owned()),
            (None, Some(letters)) => Place::Drawn(drawing::unpack(letters)?),
            (None, None) => return Err(LinkError::Missing("world")),
            (Some(_), Some(_)) => {
                return Err(wrong("world", "both `world` and `drawn`", "one of them"));
            }
        };
        let sensor = sensor.ok_or(LinkError::Missing("sensor"))?;
        let method = method.ok_or(LinkError::Missing("method"))?;
        let seed = seed.ok_or(LinkError::Missing("seed"))?;
        let mut link = Link {
            world,
            sensor: (sensor.parse().ok())
                .ok_or_else(|| wrong("sensor", sensor, "the name of a sensor"))?,
            method: (method.parse().ok())
                .ok_or_else(|| wrong("method", method, "the name of a method"))?,
            seed: whole("seed", seed)?,
            mode: match mode {
                None | Some("explore") => Mode::Explore,
                Some("manual") => Mode::Manual,
                Some(other) => return Err(wrong("mode", other, "`explore` or `manual`")),
            },
            cycle: cycle.is_some_and(|cycle| cycle == "1"),
            settings: set.map_or(Ok(vec![]), |set| settings("set", set, ';'))?,
            actions: vec![],
            result: None,
        };
        // World and settings must be known before actions are read.
        let (config, defaults) = link.config()?;
        let actions = done.into_iter().flat_map(|done| done.split(';'));
        let doors = config.world.doors.len();
        for action in actions.filter(|action| !action.is_empty()) {
            let timed = link.action(action, &defaults, doors)?;
            if link
                .actions
                .last()
                .is_some_and(|last| order(last) > order(&timed))
            {
                return Err(wrong("do", action, "actions in the order of time"));
            }
            link.actions.push(timed);
        }
        link.result = match (until, hash) {
            (Some(until), Some(hash)) => {
                let found = u64::from_str_radix(hash, 16).ok();
                let hash = found.ok_or_else(|| wrong("hash", hash, "16 hexadecimal digits"))?;
                Some((whole("until", until)?, hash))
            }
            (None, None) => None,
            (Some(_), None) => return Err(LinkError::Missing("hash")),
            (None, Some(_)) => return Err(LinkError::Missing("until")),
        };
        Ok(link)
    }
}

fn order(timed: &TimedAction) -> (u64, bool) {
    (timed.period, timed.is_decided)
}

impl Link {
    fn action(
        &self,
        text: &str,
        defaults: &Settings,
        doors: usize,
    ) -> Result<TimedAction, LinkError> {
        let expected = "actions as `120:goto,3.2,1.5`";
        let bad = || wrong("do", text, expected);
        let (when, what) = text.split_once(':').ok_or_else(bad)?;
        let (period, is_decided) = match when.strip_suffix('~') {
            Some(period) => (period, true),
            None => (when, false),
        };
        let (name, given) = what.split_once(',').unwrap_or((what, ""));
        let numbers: Vec<f64> = match name {
            "set" => vec![],
            _ => (given.split(',').filter(|number| !number.is_empty()))
                .map(|number| number.parse().ok().filter(|n: &f64| n.is_finite()))
                .collect::<Option<_>>()
                .ok_or_else(bad)?,
        };
        let action = match (name, numbers.as_slice()) {
            ("explore", []) => Action::SetMode(Mode::Explore),
            ("manual", []) => Action::SetMode(Mode::Manual),
            ("goto", &[x, y]) => Action::SetMode(Mode::GoTo(Point2::new(x, y))),
            ("drive", &[forward, turn]) => Action::Drive([forward, turn]),
            ("stop", []) => Action::Stop,
            ("kidnap", []) => Action::Kidnap,
            ("door", &[door, open]) if door >= 0.0 && door < doors as f64 => Action::SetDoor {
                door: door as usize,
                open: open > 0.0,
            },
            ("cycle", &[on]) => Action::SetCycle(on > 0.0),
            ("set", _) => {
                let changes = settings("do", given, ',')?;
                Action::Configure(Box::new(self.changed(defaults, changes)?))
            }
            _ => return Err(bad()),
        };
        Ok(TimedAction {
            period: whole("do", period)?,
            is_decided,
            action,
        })
    }
}

fn words(action: &Action, defaults: &Settings) -> String {
    let flag = |yes: bool| u8::from(yes);
    match action {
        Action::SetMode(Mode::Explore) => "explore".to_owned(),
        Action::SetMode(Mode::Manual) => "manual".to_owned(),
        Action::SetMode(Mode::GoTo(goal)) => format!("goto,{},{}", goal.x, goal.y),
        Action::Drive([forward, turn]) => format!("drive,{forward},{turn}"),
        Action::Stop => "stop".to_owned(),
        Action::Kidnap => "kidnap".to_owned(),
        Action::SetDoor { door, open } => format!("door,{door},{}", flag(*open)),
        Action::SetCycle(cycle) => format!("cycle,{}", flag(*cycle)),
        Action::Configure(settings) => {
            format!("set,{}", pairs(&settings.changes_from(defaults), ","))
        }
    }
}

fn pairs(settings: &[(String, f64)], apart: &str) -> String {
    let pairs: Vec<String> = (settings.iter())
        .map(|(key, number)| format!("{key}:{number}"))
        .collect();
    pairs.join(apart)
}

fn settings(field: &'static str, text: &str, apart: char) -> Result<Vec<(String, f64)>, LinkError> {
    let pairs = text.split(apart).filter(|pair| !pair.is_empty());
    let read = |pair: &str| {
        let (key, number) = pair.split_once(':')?;
        Some((key.to_owned(), number.parse().ok()?))
    };
    pairs
        .map(|pair| read(pair).ok_or_else(|| wrong(field, pair, "settings as `ekf.gate:9.2`")))
        .collect()
}

fn whole(field: &'static str, text: &str) -> Result<u64, LinkError> {
    let number = text.parse().ok();
    number.ok_or_else(|| wrong(field, text, "a whole number"))
}

/// Letters of an invalid value that are quoted.
const SHOWN: usize = 60;

fn wrong(field: &'static str, found: &str, expected: &'static str) -> LinkError {
    LinkError::Value {
        field,
        found: found.chars().take(SHOWN).collect(),
        expected,
    }
}
