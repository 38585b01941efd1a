//! What a robot does when its driver is gone, over real sockets: it stops, or returns home if that
//! was allowed, and anybody can stop it on the way.

use std::time::Duration;

use slamlab_bridge::rights::{Files, Keys, RightsFile};
use slamlab_bridge::token::Token;
use slamlab_bridge::{Config, HomeConfig, MapConfig, RunError};
use slamlab_core::live::HomingConfig;
use slamlab_core::wire::message::{DisarmReason, FromBridge, Role, SafetyBody, ToBridge, close};
use slamlab_tests::calm::async_on_a_calm_machine;
use tempfile::TempDir;
use tokio::time::Instant;

use super::client::{Bridge, Came, Client};
use super::streams::simulated;

/// A timeout: whatever is awaited comes sooner or never.
const NEVER: Duration = Duration::from_secs(60);

struct Scene {
    bridge: Bridge,
    rights: RightsFile,
    /// Token of a driver who is not the owner.
    anna: Token,
    _folder: TempDir,
}

fn config() -> Config {
    let right = "home".parse().unwrap();
    let when = HomingConfig {
        on_link_loss: true,
        ..HomingConfig::default()
    };
    Config {
        map: Some(MapConfig {
            home: Some(HomeConfig { right, when }),
            ..MapConfig::default()
        }),
        ..simulated()
    }
}

impl Scene {
    async fn start() -> Self {
        Self::start_with(config()).await
    }

    async fn start_with(config: Config) -> Self {
        let folder = TempDir::new().unwrap();
        let token = folder.path().join("token");
        let owner = Token::load_or_create(&token).unwrap();
        let rights = RightsFile::at(folder.path().join("rights.toml"));
        let noon = "2026-11-27T12:00:00Z".parse().unwrap();
        let add = |name: &str| {
            rights
                .add(name.parse().unwrap(), Role::Driver, noon)
                .unwrap()
        };
        add("home");
        let anna = add("anna");
        let keys = Keys::Files(Files {
            token,
            rights: rights.clone(),
        });
        let bridge = Bridge::start_with(config, keys, owner.reveal().to_owned()).await;
        Self {
            bridge,
            rights,
            anna,
            _folder: folder,
        }
    }

    /// A driver who drives the robot away from where it was armed, and then disappears.
    async fn drive_away(&self, watch: &mut Watch) {
        let mut driver = self.bridge.armed().await;
        watch.go(Duration::from_millis(500)).await;
        let four = Duration::from_secs(4);
        tokio::join!(driver.drive_for(four, 0.2), watch.go(four));
        drop(driver);
    }
}

/// A watcher without a token.
struct Watch {
    client: Client,
    /// Distance of the robot from the origin of the map, m.
    away: f64,
    safety: SafetyBody,
    said: Vec<String>,
    next_beat: Instant,
}

impl Watch {
    async fn of(bridge: &Bridge) -> Self {
        Self {
            client: bridge.watcher().await,
            away: 0.0,
            safety: SafetyBody::default(),
            said: vec![],
            next_beat: Instant::now(),
        }
    }

    async fn next(&mut self) {
        if Instant::now() >= self.next_beat {
            self.next_beat = Instant::now() + Duration::from_secs(1);
            self.client.say(ToBridge::Heartbeat).await;
        }
        match self.client.next().await {
            Came::Message(FromBridge::Pose(body)) => {
                let [x, y, _] = body.pose;
                self.away = x.hypot(y);
            }
            Came::Message(FromBridge::Safety(state)) => self.safety = state,
            Came::Message(FromBridge::Notice(notice)) => self.said.push(notice.text),
            Came::Message(_) => (),
            other => panic!("{other:?}"),
        }
    }

    async fn go(&mut self, time: Duration) {
        let until = Instant::now() + time;
        while Instant::now() < until {
            self.next().await;
        }
    }

    async fn until(&mut self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let until = Instant::now() + NEVER;
        while !is_so(self) {
            assert!(
                Instant::now() < until,
                "{what} never: {:?} {} m",
                self.said,
                self.away
            );
            self.next().await;
        }
    }

    fn heard(&self, words: &str) -> bool {
        self.said.iter().any(|text| text.contains(words))
    }
}

#[test]
fn a_robot_whose_driver_is_gone_goes_home_where_a_right_and_a_map_are_there() {
    async_on_a_calm_machine(async || {
        let scene = Scene::start().await;
        let mut watch = Watch::of(&scene.bridge).await;
        watch.go(Duration::from_secs(1)).await;
        scene.drive_away(&mut watch).await;
        watch.until("it is away", |watch| watch.away > 0.5).await;
        watch
            .until("it goes", |watch| watch.heard("goes home"))
            .await;
        let drives = |watch: &Watch| watch.safety.armed && watch.safety.driver_name == "bridge";
        watch.until("it drives", drives).await;
        watch
            .until("it is home", |watch| watch.heard("is at home"))
            .await;
        watch.go(Duration::from_millis(500)).await;
        assert!(watch.away < 0.35, "{} m", watch.away);
        assert!(!watch.safety.armed && watch.safety.driver.is_none());
        scene.bridge.stop().await;
    });
}

/// The battery is low all the time here, which counts after two seconds: by then the robot is away.
#[test]
fn a_robot_whose_battery_is_low_is_taken_from_its_driver_and_goes_home() {
    async_on_a_calm_machine(async || {
        let mut config = config();
        let home = config.map.as_mut().and_then(|map| map.home.as_mut());
        home.unwrap().when = HomingConfig {
            on_low_battery: true,
            low_volts: 50.0,
            ..HomingConfig::default()
        };
        let scene = Scene::start_with(config).await;
        let mut watch = Watch::of(&scene.bridge).await;
        watch.go(Duration::from_secs(1)).await;
        let mut driver = scene.bridge.connect().await;
        assert!(driver.enter(Some(scene.anna.reveal())).await);
        driver.take(false).await;
        driver.arm().await;
        let drive = async {
            let mut ticks = tokio::time::interval(Duration::from_millis(50));
            loop {
                tokio::select! {
                    _ = ticks.tick() => driver.drive(0.3, 0.0).await,
                    came = driver.next() => match came {
                        Came::Message(_) => (),
                        other => break other,
                    },
                }
            }
        };
        let taken = watch.until("it goes home", |watch| {
            watch.heard("The battery is low: the robot goes home")
        });
        let (code, ()) = tokio::join!(drive, taken);
        assert!(matches!(code, Came::Closed(close::TAKEN_OVER)), "{code:?}");
        let farthest = watch.away;
        assert!(farthest > 0.3, "{farthest} m");
        watch
            .until("it is home", |watch| watch.heard("is at home"))
            .await;
        watch.go(Duration::from_millis(500)).await;
        assert!(watch.away < 0.35, "{} m of {farthest}", watch.away);
        assert!(!watch.safety.armed);
        scene.bridge.stop().await;
    });
}

#[test]
fn anybody_stops_a_robot_that_goes_home_and_it_stays_stopped() {
    async_on_a_calm_machine(async || {
        let scene = Scene::start().await;
        let mut watch = Watch::of(&scene.bridge).await;
        watch.go(Duration::from_secs(1)).await;
        scene.drive_away(&mut watch).await;
        let drives = |watch: &Watch| watch.safety.armed && watch.safety.driver_name == "bridge";
        watch.until("it drives", drives).await;
        watch.client.say(ToBridge::Stop).await;
        watch.until("it stops", |watch| !watch.safety.armed).await;
        assert_eq!(watch.safety.reason, DisarmReason::Stop);
        watch.go(Duration::from_secs(1)).await;
        let stood = watch.away;
        watch.go(Duration::from_secs(3)).await;
        assert!(
            (watch.away - stood).abs() < 0.03,
            "{stood} m, then {} m",
            watch.away
        );
        assert!(!watch.safety.armed && watch.heard("it was stopped"));

        // A person takes over from there.
        let mut driver = scene.bridge.armed().await;
        driver.drive_for(Duration::from_millis(300), 0.1).await;
        drop(driver);
        scene.bridge.stop().await;
    });
}

#[test]
fn without_its_right_a_robot_holds_and_a_bridge_without_one_does_not_start() {
    async_on_a_calm_machine(async || {
        let scene = Scene::start().await;
        let mut watch = Watch::of(&scene.bridge).await;
        watch.go(Duration::from_secs(1)).await;
        scene.rights.revoke(&"home".parse().unwrap()).unwrap();
        watch
            .until("it is told", |watch| watch.heard("was taken away"))
            .await;
        scene.drive_away(&mut watch).await;
        watch
            .until("it stops", |watch| {
                !watch.safety.armed && watch.safety.reason == DisarmReason::DriverGone
            })
            .await;
        watch.go(Duration::from_secs(1)).await;
        let stood = watch.away;
        watch.go(Duration::from_secs(4)).await;
        assert!(
            (watch.away - stood).abs() < 0.03,
            "{stood} m, then {} m",
            watch.away
        );
        assert!(!watch.safety.armed);
        scene.bridge.stop().await;

        let listener = slamlab_bridge::bind(([127, 0, 0, 1], 0).into())
            .await
            .unwrap();
        let keys = Keys::Token(Token::random().unwrap());
        let error = match slamlab_bridge::start(listener, Config { keys, ..config() }) {
            Err(RunError::Map(error)) => error.to_string(),
            other => panic!("{other:?}"),
        };
        assert!(
            error.contains("failsafe right home: there is no right of that name"),
            "{error}"
        );
    });
}
