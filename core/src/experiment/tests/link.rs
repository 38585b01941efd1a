//! Links: a repeated run is the same to the bit, what is written can be read, and everything else
//! is refused in words.

use proptest::prelude::*;

use super::*;
use crate::settings::Settings;
use crate::slam::Method;

fn link(world: &str) -> Link {
    Link {
        world: Place::Builtin(world.to_owned()),
        sensor: SensorKind::Lidar,
        method: Method::LineEkf,
        seed: 5,
        mode: Mode::Explore,
        cycle: false,
        settings: vec![("ekf.gate".to_owned(), 8.5)],
        actions: vec![],
        result: None,
    }
}

fn begun(link: &Link) -> (Experiment, Settings) {
    let (config, defaults) = link.config().unwrap();
    (Experiment::new(config).unwrap(), defaults)
}

/// A person does everything that can be done; the link of it, written and read, leads to the same
/// state.
#[test]
fn what_is_done_again_is_the_same_to_the_bit() {
    let mut original = link("doors");
    let (mut run, defaults) = begun(&original);
    let walk = |run: &mut Experiment, periods: usize| {
        for _ in 0..periods {
            run.step().unwrap();
        }
    };
    walk(&mut run, 40);
    run.set_mode(Mode::GoTo(Point2::new(1.25, 0.1)));
    walk(&mut run, 30);
    run.set_door(0, false).unwrap();
    run.drive(0.123_456_789_012_345_6, -0.3);
    walk(&mut run, 7);
    let mut settings = defaults.clone();
    let scope = crate::settings::Scope {
        source: crate::settings::Source::Simulation,
        method: Method::LineEkf,
    };
    let idle = settings.take(&scope, [("ekf.gate", 12.0)]).unwrap();
    assert!(idle.is_empty());
    run.reconfigure(&settings).unwrap();
    run.stop();
    walk(&mut run, 5);
    run.kidnap(None).unwrap();
    run.set_mode(Mode::Explore);
    walk(&mut run, 40);
    run.set_cycle(true);
    for _ in 0..5 {
        run.next_stage().unwrap();
    }
    // In the middle of a period.
    run.set_mode(Mode::Manual);
    run.set_mode(Mode::Explore);
    walk(&mut run, 20);
    original.actions = run.actions().unwrap().to_vec();
    assert_eq!(original.actions.len(), 10);
    original.result = Some((run.periods(), run.state_hash()));

    let text = original.write().unwrap();
    let read = Link::read(&format!("https://example.org/lab/#{text}")).unwrap();
    assert_eq!(read, original, "{text}");
    let (mut again, _) = begun(&read);
    again.follow(read.actions.clone());
    let (until, hash) = read.result.unwrap();
    while again.periods() < until {
        again.step().unwrap();
    }
    assert_eq!(again.state_hash(), hash, "{text}");
    assert_eq!(again.actions().unwrap(), original.actions, "told again");
    assert_eq!(again.take_followed_settings().as_ref(), Some(&settings));
    assert_eq!(again.take_followed_settings(), None, "told once");
    assert_eq!(run.take_followed_settings(), None, "who chose them knows");

    // It is because of the actions.
    let (mut alone, _) = begun(&read);
    while alone.periods() < until {
        alone.step().unwrap();
    }
    assert_ne!(alone.state_hash(), hash);
}

/// A world of its own, with a heading that does not survive rewriting the file to the bit.
const DRAWN: &str = r#"{ "slamlab_world": 1, "name": "Büro & Flur", "robot": "rp6",
  "start": { "x": 1.0, "y": 1.0, "heading": 0.7300000000000001 },
  "obstacles": [
    { "shape": "polyline", "closed": true, "points": [[0, 0], [5, 0], [5, 4], [0, 4]] },
    { "shape": "rectangle", "centre": [3.1, 2.2], "size": [0.5, 0.3], "angle": 0.4 }
  ],
  "doors": [ { "from": [5, 1], "to": [5, 2] } ] }"#;

fn drawn(text: &str) -> Link {
    Link {
        world: Place::Drawn(text.to_owned()),
        ..link("arena")
    }
}

#[test]
fn a_world_that_somebody_drew_comes_with_the_link_and_to_the_same_state() {
    let mut original = drawn(DRAWN);
    let (mut run, _) = begun(&original);
    for _ in 0..40 {
        run.step().unwrap();
    }
    run.set_door(0, true).unwrap();
    for _ in 0..30 {
        run.step().unwrap();
    }
    original.actions = run.actions().unwrap().to_vec();
    original.result = Some((run.periods(), run.state_hash()));
    let text = original.write().unwrap();
    assert!(text.len() < 700, "{} letters: {text}", text.len());
    assert!(
        text.bytes().all(|b| b.is_ascii_graphic()),
        "an address takes it: {text}"
    );
    let read = Link::read(&text).unwrap();
    assert_eq!(read, original);
    let (mut again, _) = begun(&read);
    again.follow(read.actions.clone());
    let (until, hash) = read.result.unwrap();
    while again.periods() < until {
        again.step().unwrap();
    }
    assert_eq!(again.state_hash(), hash);

    // It is because of the world.
    let (mut elsewhere, _) = begun(&drawn(&DRAWN.replace("3.1, 2.2", "3.2, 2.2")));
    elsewhere.follow(read.actions);
    while elsewhere.periods() < until {
        elsewhere.step().unwrap();
    }
    assert_ne!(elsewhere.state_hash(), hash);
}

#[test]
fn a_link_with_a_world_that_was_cut_is_refused_wherever_it_was_cut() {
    let text = drawn(DRAWN).write().unwrap();
    for length in 4..text.len() {
        let cut = Link::read(&text[..length]);
        assert!(cut.is_err(), "{length} of {}: {cut:?}", text.len());
    }
}

#[test]
fn a_hostile_world_in_a_link_is_refused_in_words() {
    let packed = |text: &[u8]| {
        use std::io::Write as _;
        let mut packer = flate2::write::DeflateEncoder::new(vec![], flate2::Compression::best());
        packer.write_all(text).unwrap();
        let packed = packer.finish().unwrap();
        base64::Engine::encode(&base64::engine::general_purpose::URL_SAFE_NO_PAD, packed)
    };
    let begins = "run&sensor=lidar&method=line-ekf&seed=5&drawn=";
    let bomb = packed(&vec![b' '; 200_000_000]);
    assert!(bomb.len() < 300_000, "little that is much: {}", bomb.len());
    for (drawn, words) in [
        (String::new(), "damaged"),
        ("%%%".to_owned(), "damaged"),
        ("e30".to_owned(), "damaged"),
        (packed(&[0xff, 0xfe]), "damaged"),
        (bomb, "at most 1000000"),
        (packed(b""), "the file is empty"),
        (packed(b"{\"a\":1}"), "world file, line 1"),
        (packed("[".repeat(100_000).as_bytes()), "world file, line 1"),
        ("A".repeat(1_500_000), "bytes long"),
    ] {
        let said = Link::read(&format!("{begins}{drawn}"))
            .unwrap_err()
            .to_string();
        assert!(said.contains(words), "{words}: {said}");
    }
    let said = Link::read(&format!("{begins}e30&world=arena")).unwrap_err();
    assert!(said.to_string().contains("one of them"), "{said}");
    let long = " ".repeat(1_000_001);
    assert_eq!(
        drawn(&long).world.load().map(|_| ()).unwrap_err(),
        LinkError::Drawing("world file: the file is empty, expected a JSON object".to_owned())
    );
    let said = drawing_refused(&(DRAWN.to_owned() + &long));
    assert!(matches!(said, LinkError::DrawingTooLong(_)), "{said}");
}

fn drawing_refused(text: &str) -> LinkError {
    drawn(text).write().unwrap_err()
}

#[test]
fn a_run_from_its_beginning_comes_to_every_earlier_state_and_goes_other_ways_from_there() {
    let (mut run, _) = begun(&link("doors"));
    let mut hashes = vec![run.state_hash()];
    for period in 1..=90 {
        if period == 30 {
            run.set_mode(Mode::GoTo(Point2::new(1.25, 0.1)));
        }
        if period == 60 {
            run.kidnap(None).unwrap();
        }
        run.step().unwrap();
        hashes.push(run.state_hash());
    }
    let mut again = run.again().unwrap();
    for (period, hash) in hashes.iter().enumerate() {
        assert_eq!(again.state_hash(), *hash, "period {period}");
        // On the way there it can be repeated as well.
        if period == 45 {
            let thrice = again.again().unwrap();
            assert!(thrice.has_due() && thrice.state_hash() == hashes[0]);
            let mut forked = again.again().unwrap();
            while forked.periods() < 45 {
                forked.step().unwrap();
            }
            assert!(forked.state_hash() == *hash && forked.has_due());
            forked.drive(0.1, 0.0);
            assert!(!forked.has_due() && forked.has_forked());
            // Of what was done, the kidnapping is left out.
            assert_eq!(forked.actions().unwrap().len(), 2);
        }
        again.step().unwrap();
    }
    assert!(!again.has_due() && !again.has_forked());
    assert_eq!(again.actions().unwrap(), run.actions().unwrap());
    run.kidnap(Some(&Pose2::new(1.0, 1.0, 0.0))).ok();
    assert!(matches!(run.again(), Err(AgainError::Untold(_))));
}

#[test]
fn what_a_list_cannot_tell_makes_no_link() {
    let (mut run, _) = begun(&link("arena"));
    run.step().unwrap();
    assert!(run.actions().unwrap().is_empty());
    run.kidnap(Some(&Pose2::new(1.0, 1.0, 0.0))).ok();
    let why = run.actions().unwrap_err().to_string();
    assert_eq!(
        why,
        "the robot was carried to a pose: that cannot be done again from a list of actions"
    );
}

#[test]
fn what_is_wrong_is_named() {
    let refused = |text: &str| Link::read(text).unwrap_err().to_string();
    let whole = "run&world=doors&sensor=lidar&method=line-ekf&seed=5";
    assert!(Link::read(whole).is_ok());
    for (text, words) in [
        ("", "no link to an experiment"),
        ("#token=abc", "no link to an experiment"),
        ("run&sensor=lidar&method=line-ekf&seed=5", "no `world`"),
        (
            "run&world=moon&sensor=lidar&method=line-ekf&seed=5",
            "world is `moon`, expected one of arena",
        ),
        ("run&world=moon", "world is `moon`, expected one of arena"),
        (
            "run&world=doors&sensor=eye&method=line-ekf&seed=5",
            "`sensor` is `eye`",
        ),
        (
            "run&world=doors&sensor=lidar&method=magic&seed=5",
            "`method` is `magic`",
        ),
        (
            "run&world=doors&sensor=lidar&method=line-ekf&seed=-5",
            "`seed` is `-5`, expected a whole number",
        ),
        (&format!("{whole}&mode=goto"), "`mode` is `goto`"),
        (
            &format!("{whole}&colour=red"),
            "`colour`, which is no field",
        ),
        (&format!("{whole}&set=ekf.gate"), "`set` is `ekf.gate`"),
        (&format!("{whole}&set=ekf.gates:3"), "ekf.gates"),
        (&format!("{whole}&set=ekf.gate:-3"), "Gate of a match is -3"),
        (&format!("{whole}&set=ekf.gate:NaN"), "Gate of a match"),
        (&format!("{whole}&do=5"), "`do` is `5`"),
        (&format!("{whole}&do=5:goto,1"), "`do` is `5:goto,1`"),
        (
            &format!("{whole}&do=5:goto,1,inf"),
            "`do` is `5:goto,1,inf`",
        ),
        (&format!("{whole}&do=5:door,99,1"), "`do` is `5:door,99,1`"),
        (
            &format!("{whole}&do=5:stop;4:stop"),
            "`do` is `4:stop`, expected actions in the order",
        ),
        (
            &format!("{whole}&do=5:set,ekf.gate:x"),
            "`do` is `ekf.gate:x`",
        ),
        (&format!("{whole}&until=5"), "no `hash`"),
        (&format!("{whole}&until=5&hash=xyz"), "`hash` is `xyz`"),
        (&format!("{whole}&until=x&hash=0"), "`until` is `x`"),
        (&"x".repeat(70_000), "no link to an experiment"),
        (
            &format!("{whole}&set={}", "x".repeat(70_000)),
            "bytes long, at most 64000",
        ),
    ] {
        let said = refused(text);
        assert!(said.contains(words), "{words}: {said}");
    }
}

fn action() -> impl Strategy<Value = Action> {
    let number = || -1e6..1e6_f64;
    prop_oneof![
        Just(Action::SetMode(Mode::Explore)),
        Just(Action::SetMode(Mode::Manual)),
        (number(), number()).prop_map(|(x, y)| Action::SetMode(Mode::GoTo(Point2::new(x, y)))),
        (number(), number()).prop_map(|(forward, turn)| Action::Drive([forward, turn])),
        Just(Action::Stop),
        Just(Action::Kidnap),
        (0..2_usize, any::<bool>()).prop_map(|(door, open)| Action::SetDoor { door, open }),
        any::<bool>().prop_map(Action::SetCycle),
    ]
}

proptest! {
    #[test]
    fn what_is_written_is_read(
        seed in any::<u64>(),
        cycle in any::<bool>(),
        manual in any::<bool>(),
        gate in 0.1..100.0_f64,
        mut actions in prop::collection::vec((0..100_000_u64, any::<bool>(), action()), 0..30),
        result in prop::option::of((any::<u64>(), any::<u64>())),
    ) {
        actions.sort_by_key(|(period, is_decided, _)| (*period, *is_decided));
        let actions = actions.into_iter();
        let made = Link {
            seed,
            cycle,
            mode: if manual { Mode::Manual } else { Mode::Explore },
            settings: vec![("ekf.gate".to_owned(), gate)],
            actions: actions.map(|(period, is_decided, action)| TimedAction { period, is_decided, action }).collect(),
            result,
            ..link("doors")
        };
        prop_assert_eq!(Link::read(&made.write().unwrap()).unwrap(), made);
    }

    #[test]
    fn any_text_is_read_or_refused(text in ".{0,200}", fields in "(run&)?[a-z]{0,6}=[ -~]{0,40}(&do=[0-9~:a-z,.;-]{0,40})?") {
        for text in [text, format!("run&world=doors&sensor=lidar&method=line-ekf&seed=5&{fields}")] {
            if let Ok(link) = Link::read(&text) {
                let again = link.write().unwrap();
                prop_assert_eq!(Link::read(&again).unwrap(), link);
            }
        }
    }
}
