//! The bindings in a browser, as the page's worker calls them.
#![cfg(target_family = "wasm")]
#![allow(missing_docs)] // a test binary has no public interface

use slamlab_core::experiment::{Experiment, ExperimentConfig};
use slamlab_core::pilot::Mode;
use slamlab_core::robot::RobotModel;
use slamlab_core::sim::{SensorModel, worlds};
use slamlab_core::slam::Method;
use slamlab_web::{
    BasinAsk, BasinAxesName, BasinOutcomeName, BenchResponse, BenchTrial, CloudPair, Decision,
    ErrorKind, FieldChange, FieldName as Field, Gate, Inspection, MethodName, Mode as ModeName,
    Offer, Registered, RegistrationAdvice, RegistrationOffer, ReplaySetup, RunStatus, SavedFile,
    SavedKind, SettingInfo, SettingValues, Setup, SlamView, Submaps, WebClouds, WebError,
    WebLogReader, WebRun,
};
use tsify::{Ts, Tsify};
use wasm_bindgen::JsValue;
use wasm_bindgen_test::{wasm_bindgen_test, wasm_bindgen_test_configure};

wasm_bindgen_test_configure!(run_in_dedicated_worker);

const BLOCK: usize = 64 * 64;
/// Numbers of a submap, see `SUBMAP` of the rows.
const SUBMAP: usize = 17;

fn experiment(world: &str, json: Option<&str>) -> Result<WebRun, String> {
    begin(&setup(world, json))
}

fn begin(setup: &Setup) -> Result<WebRun, String> {
    WebRun::simulate(&ts(setup)).map_err(words)
}

fn setup(world: &str, json: Option<&str>) -> Setup {
    Setup {
        world: world.to_owned(),
        world_json: json.map(str::to_owned),
        sensor: "lidar".to_owned(),
        seed: 7,
        method: MethodName(Method::LineEkf),
        mode: ModeName::Explore,
        cycle: false,
        settings: SettingValues::default(),
        calibration: None,
        prior_map: None,
        lesson: None,
    }
}

/// A value as the page passes it.
fn ts<T: Tsify + serde::Serialize>(value: &T) -> Ts<T> {
    value.into_ts().expect("an object")
}

/// A result as the page receives it.
fn rust<T: Tsify + serde::de::DeserializeOwned>(typed: Result<Ts<T>, WebError>) -> T
where
    T::JsType: Clone,
{
    typed
        .map_err(words)
        .expect("an answer")
        .to_rust()
        .expect("of its type")
}

/// The error as a browser would print it.
fn words(error: WebError) -> String {
    format!("{:?}", JsValue::from(error))
}

fn step(run: &mut WebRun) {
    run.decide();
    run.advance().map_err(words).expect("a good scan");
}

#[wasm_bindgen_test]
fn every_name_that_the_page_offers_begins_a_run() {
    let offer: Offer = rust(slamlab_web::offer());
    assert!(offer.worlds.len() > 5 && offer.sensors.len() > 3 && offer.methods.len() > 2);
    for name in offer.worlds {
        // A run in `campus` takes a while to begin; the core's tests build it.
        if name != "campus" {
            experiment(&name, None).expect("a built-in world");
        }
    }
    for sensor in offer.sensors {
        let setup = Setup {
            sensor: sensor.name.clone(),
            ..setup("arena", None)
        };
        assert!(begin(&setup).is_ok(), "{}", sensor.name);
    }
    for method in offer.methods {
        let setup = Setup {
            method: method.name,
            ..setup("arena", None)
        };
        assert!(begin(&setup).is_ok(), "{}", method.title);
    }
}

/// Distance from the wall at which a robot that is driven towards it by hand comes to a stop, m.
fn room_ahead(run: &mut WebRun) -> f64 {
    run.drive(1.0, 0.0);
    for _ in 0..200 {
        step(run);
    }
    rust(run.status()).x
}

#[wasm_bindgen_test]
fn a_setting_that_goes_back_to_its_default_acts_on_the_run() {
    let wide: SettingValues = [("pilot.gap", 0.5)].into_iter().collect();
    let at = |changes: &[&SettingValues]| {
        let mut run = experiment("arena", None).expect("a built-in world");
        run.manual();
        for changes in changes {
            run.configure(&ts(*changes)).map_err(words).expect("a gap");
        }
        room_ahead(&mut run)
    };
    let usual = at(&[]);
    assert!(at(&[&wide]) < usual - 0.3);
    assert_eq!(at(&[&wide, &SettingValues::default()]), usual);
}

#[wasm_bindgen_test]
fn settings_are_listed_as_they_are_for_the_run() {
    let listed = |sensor: &str| {
        let setup = Setup {
            sensor: sensor.to_owned(),
            ..setup("arena", None)
        };
        let run = begin(&setup).expect("a sensor");
        let none = ts(&SettingValues::default());
        let settings = run.settings(&none).map_err(words).expect("a list");
        let rust = |setting: Ts<SettingInfo>| setting.to_rust().expect("a setting");
        let mut settings = settings.into_iter().map(rust);
        let hit = settings.find(|setting| setting.key == "grid.hit");
        hit.expect("a row of the table").default
    };
    // Rangers see each cell only a few times, so a hit counts more.
    assert!(listed("rangers") > listed("lidar"));
}

#[wasm_bindgen_test]
fn an_experiment_steps_and_has_frames() {
    let mut run = experiment("arena", None).expect("a built-in world");
    for _ in 0..200 {
        step(&mut run);
    }
    let status: RunStatus = rust(run.status());
    assert!((status.time - 10.0).abs() < 1e-9);
    assert!(status.scans > 20 && !status.finished);
    assert_eq!(status.mode, ModeName::Explore);
    let view: SlamView = rust(run.view(0, 0.0));
    assert!(view.scan.len() > 200 && view.scan.len().is_multiple_of(2));
    let lines = view.lines.clone().expect("nobody steps through stages");
    assert!(!lines.is_empty() && lines.len().is_multiple_of(12));
    assert!(!run.truth().is_empty() && run.truth().len().is_multiple_of(4));
    assert!(run.extent() > 10.0 && run.explored() > 0.1 && run.known_area() > 1.0);
    assert_eq!(run.state_hash().len(), 16);
    let files = saved(&run, SavedKind::Map);
    assert_eq!((files.len(), files[0].name.as_str()), (2, "arena.pgm"));
    assert!(files[0].bytes.starts_with(b"P5"));
    assert!(String::from_utf8_lossy(&files[1].bytes).contains("arena.pgm"));
    let files = saved(&run, SavedKind::Carmen);
    assert!(slamlab_core::format::carmen::CarmenLog::parse(&files[0].bytes).is_ok());
    let files = saved(&run, SavedKind::Smap);
    let map = slamlab_core::format::smap::parse(&files[0].bytes).expect("a submap");
    assert!(map.points.len() > 100 && map.path.len() as u32 == status.scans);
    assert!(map.landmarks.len() > 2);
    let mut reader = slamlab_core::replay::LogReader::default();
    let files = saved(&run, SavedKind::Revolutions);
    assert_eq!(files[0].name, "arena-revolutions.txt");
    assert!(reader.push(&files[0].bytes).is_ok());
    let scans = reader.finish().map(|log| log.scans() as u32);
    assert_eq!(scans, Ok(status.scans));
}

fn saved(run: &WebRun, what: SavedKind) -> Vec<SavedFile> {
    let files = run
        .export(&ts(&what), "arena")
        .map_err(words)
        .expect("files");
    files
        .iter()
        .map(|file| file.to_rust().expect("a file"))
        .collect()
}

#[wasm_bindgen_test]
fn the_filter_can_be_looked_into() {
    let mut run = experiment("arena", None).expect("a built-in world");
    for _ in 0..200 {
        step(&mut run);
    }
    let inside = run.inspect(true).map_err(words).expect("an answer");
    let inside: Inspection = inside
        .expect("a line filter")
        .to_rust()
        .expect("of its type");
    let n = inside.robot_rows as usize + 2 * inside.landmarks.len();
    assert_eq!(inside.coefficients.len(), n * n);
    for (row, cells) in inside.coefficients.chunks(n).enumerate() {
        for (column, &cell) in cells.iter().enumerate() {
            assert!(cell.abs() <= 1.0 + 1e-6);
            assert!((cell - inside.coefficients[column * n + row]).abs() < 1e-6);
        }
    }
    let matched = inside.sightings.iter();
    let matched: Vec<_> = matched
        .filter(|s| s.decision == Decision::Matched)
        .collect();
    assert!(!matched.is_empty(), "walls are recognised");
    for sighting in matched {
        let mut candidates = sighting.candidates.iter();
        let winner = candidates.find(|c| Some(c.wall) == sighting.wall);
        let winner = winner.expect("the winner is among the candidates");
        assert!(
            winner.d2 <= inside.gate && winner.gate == Gate::Match,
            "it lies inside the gate"
        );
    }
    assert!(inside.odometry.curvature_sigma > 0.0 && inside.odometry.turn_scale_sigma > 0.0);
    let status: RunStatus = rust(run.status());
    assert!(status.nees > 0.0 && status.nees_low < 3.0 && status.nees_high > 3.0);
    assert!(status.nis > 0.0 && status.nis_low < 1.0 && status.nis_high > 1.0);
    let matching = begin(&Setup {
        method: MethodName(Method::ScanMatching),
        ..setup("arena", None)
    });
    let inside = matching.expect("a built-in world").inspect(true);
    assert!(inside.map_err(words).expect("an answer").is_none());
}

#[wasm_bindgen_test]
fn the_grid_is_told_in_blocks_that_changed() {
    let mut run = experiment("arena", None).expect("a built-in world");
    for _ in 0..60 {
        step(&mut run);
    }
    let view =
        |run: &WebRun, generation, revision| -> SlamView { rust(run.view(generation, revision)) };
    let all = view(&run, 0, 0.0);
    let grid = all.grid.clone().expect("blocks");
    assert_eq!(grid.cells.len(), grid.index.len() / 2 * BLOCK);
    let again = view(&run, all.generation, all.revision);
    assert!(again.grid.is_none(), "nothing is new");
    let other = view(&run, all.generation + 1, all.revision);
    assert_eq!(other.grid, all.grid, "another generation knows nothing");
    for _ in 0..20 {
        step(&mut run);
    }
    let more = view(&run, all.generation, all.revision);
    assert!(more.grid.is_some() && more.revision > all.revision);
}

#[wasm_bindgen_test]
fn fields_are_told_in_blocks_that_may_have_changed() {
    let mut run = experiment("arena", None).expect("a built-in world");
    for _ in 0..60 {
        step(&mut run);
    }
    for name in [Field::Distance, Field::Likelihood, Field::Room] {
        let of = |generation, revision| -> FieldChange {
            rust(run.field(&ts(&name), generation, revision))
        };
        let all = of(0, 0.0);
        let grid = all.grid.expect("blocks");
        assert!(grid.cells.contains(&0) && grid.cells.iter().any(|&byte| byte > 0));
        assert_eq!(grid.cells.len(), grid.index.len() / 2 * BLOCK);
        assert!(all.step > 0.0);
        assert!(of(all.generation, all.revision).grid.is_none());
    }
}

#[wasm_bindgen_test]
fn a_run_through_the_bindings_has_the_bits_of_the_core() {
    let mut run = experiment("doors", None).expect("a built-in world");
    let config = ExperimentConfig {
        mode: Mode::Explore,
        ..ExperimentConfig::new(
            worlds::builtin("doors").expect("a built-in world"),
            RobotModel::rp6(),
            SensorModel::lidar(),
            7,
        )
    };
    let mut core = Experiment::new(config).expect("a good setup");
    for _ in 0..300 {
        step(&mut run);
        core.step().expect("a step");
    }
    assert_eq!(run.state_hash(), format!("{:016x}", core.state_hash()));
}

#[wasm_bindgen_test]
fn the_hand_takes_over_and_stop_stops() {
    let mut run = experiment("arena", None).expect("a built-in world");
    run.drive(1.0, 0.0);
    for _ in 0..40 {
        step(&mut run);
    }
    let status: RunStatus = rust(run.status());
    assert_eq!(status.mode, ModeName::Manual);
    let driven = status.distance;
    assert!(driven > 0.2);
    run.stop(0.0);
    for _ in 0..40 {
        step(&mut run);
    }
    let distance = |run: &WebRun| rust::<RunStatus>(run.status()).distance;
    let stopped = distance(&run);
    for _ in 0..40 {
        step(&mut run);
    }
    assert!((distance(&run) - stopped).abs() < 1e-3);
}

#[wasm_bindgen_test]
fn what_cannot_be_is_refused_in_a_sentence() {
    let refuse =
        |world: &str, json: Option<&str>| experiment(world, json).expect_err("no such world");
    assert!(refuse("atlantis", None).contains("there is no world `atlantis`"));
    assert!(refuse("", Some("")).contains("empty"));
    assert!(refuse("", Some("{ \"slamlab_world\": 1,")).contains("line 1"));
    let error = WebRun::simulate(&ts(&setup("atlantis", None))).expect_err("no such world");
    assert_eq!(error.kind, ErrorKind::Setup);
    let kind = js_sys::Reflect::get(&JsValue::from(error), &"kind".into());
    assert_eq!(
        kind,
        Ok(JsValue::from("setup")),
        "whoever catches it reads the kind"
    );
    let in_wall = r#"{ "slamlab_world": 1, "name": "w", "start": { "x": 0.05, "y": 1 },
        "obstacles": [{ "shape": "polyline", "closed": true, "points": [[0, 0], [4, 0], [4, 3], [0, 3]] }] }"#;
    let text = refuse("w", Some(in_wall));
    assert!(text.contains("line 1") && text.contains("start"), "{text}");
}

/// A robot that drives along a room of 6 x 4 m, without any error.
fn log(scans: usize) -> String {
    let scan = |i: usize| {
        let x = 1.0 + 0.05 * i as f64;
        let ranges = (0..180).map(|k| {
            let bearing = f64::from(k - 90).to_radians();
            let along = |d: f64, gap_ahead: f64, gap_behind: f64| match d {
                d if d > 1e-9 => gap_ahead / d,
                d if d < -1e-9 => gap_behind / -d,
                _ => f64::INFINITY,
            };
            let (sin, cos) = (bearing.sin(), bearing.cos());
            format!("{:.2} ", along(cos, 6.0 - x, x).min(along(sin, 2.0, 2.0)))
        });
        let ranges: String = ranges.collect();
        format!(
            "FLASER 180 {ranges}{x} 2 0 {x} 2 0 {}.0 robot {}.0\n",
            1000 + i,
            i
        )
    };
    (0..scans).map(scan).collect()
}

fn read(bytes: &[u8], chunk: usize) -> Result<WebRun, String> {
    let mut reader = WebLogReader::new(&ts(&ReplaySetup {
        method: MethodName(Method::ScanMatching),
        settings: SettingValues::default(),
        twin: false,
        prior_map: None,
        poses: None,
    }))
    .map_err(words)?;
    for part in bytes.chunks(chunk) {
        reader.push(part).map_err(words)?;
    }
    reader.finish().map_err(words)
}

#[wasm_bindgen_test]
fn a_log_read_in_pieces_is_mapped_to_its_end() {
    let text = log(40);
    let mut hashes = vec![];
    for chunk in [97, text.len()] {
        let mut replay = read(text.as_bytes(), chunk).expect("a good log");
        let mut steps = 0;
        while replay.advance().map_err(words).expect("a good scan") {
            steps += 1;
        }
        assert_eq!(steps, 40);
        let status: RunStatus = rust(replay.status());
        assert_eq!((status.scans, status.progress), (40, 1.0));
        assert!(
            (status.x - 1.95).abs() < 0.02 && status.y.abs() < 0.02,
            "{status:?}"
        );
        assert_eq!(replay.trail().len(), 40 * 8);
        let submaps = replay.submaps(-1.0, 0).map_err(words).expect("of a log");
        let submaps: Submaps = rust(Ok(submaps.expect("scan matching has submaps")));
        let known = submaps.lengths.len();
        assert_eq!(
            submaps.poses.len(),
            SUBMAP * (known + 1),
            "the last one is being made"
        );
        assert_eq!(
            submaps.lengths.iter().sum::<u32>() as usize,
            submaps.surfaces.len()
        );
        let again = replay.submaps(submaps.version, submaps.lengths.len() as u32);
        assert!(
            again.map_err(words).expect("of a log").is_none(),
            "nothing is new"
        );
        let view: SlamView = rust(replay.view(0, 0.0));
        assert!(!view.scan.is_empty() && view.grid.is_some());
        assert!(
            status.truth_x.is_nan() && status.nees.is_nan(),
            "a log knows no truth"
        );
        hashes.push(replay.state_hash());
    }
    assert_eq!(hashes.first(), hashes.last());
}

#[wasm_bindgen_test]
fn every_method_that_the_lab_offers_registers_and_can_be_looked_at() {
    let offer: RegistrationOffer = rust(slamlab_web::registration_offer());
    assert_eq!(offer.measured.len(), 4 * offer.methods.len());
    for info in &offer.pairs {
        let pair: CloudPair = rust(slamlab_web::builtin_pair(&info.name));
        let clouds = WebClouds::new(&pair.moving, &pair.fixed, true);
        let mut clouds = clouds.map_err(words).expect("two scans");
        for method in &offer.methods {
            let found: Registered = rust(clouds.register(method, &pair.truth));
            // The search of a correlation is seen as well.
            let seen = found.iterations as usize + usize::from(method == "correlation");
            assert_eq!(found.steps.len(), 6 * seen, "{method}");
            let pairs = clouds.correspondences(method, seen);
            assert_eq!(pairs.len() % 5, 0, "{method}");
            let matched = found.steps.last().copied().unwrap_or_default();
            assert_eq!(pairs.len() / 5, matched as usize, "{method}: the last ones");
            let first = clouds.correspondences(method, 0);
            assert!(method == "correlation" || !first.is_empty(), "{method}");
        }
        let advice = clouds.advise(&pair.truth, &[0.0; 3]).map_err(words);
        let advice = advice.expect("an answer").expect("there is a table");
        let advice: RegistrationAdvice = rust(Ok(advice));
        assert!(offer.methods.contains(&advice.method.name));
    }
}

#[wasm_bindgen_test]
fn a_map_of_starts_comes_cell_by_cell_and_bad_questions_are_refused() {
    let pair: CloudPair = rust(slamlab_web::builtin_pair("office"));
    let clouds = WebClouds::new(&pair.moving, &pair.fixed, true);
    let clouds = clouds.map_err(words).expect("two scans");
    let mut ask = BasinAsk {
        method: "point-to-line".to_owned(),
        right: pair.truth,
        axes: BasinAxesName::Place,
        shift: 0.5,
        turn: 0.5,
        cells: 5,
    };
    let mut basin = clouds.basin(&ts(&ask)).map_err(words).expect("a map");
    let mut rows = vec![];
    loop {
        let row = basin.step();
        if row.is_empty() {
            break;
        }
        rows.push(row);
    }
    assert_eq!((rows.len(), basin.progress()), (25, 1.0));
    // From the correct pose, in the middle, the registration succeeds.
    let middle = rows.iter().find(|row| row[0] == 12.0).expect("all cells");
    assert_eq!(BasinOutcomeName::NAMES[middle[1] as usize], "found");
    ask.method = "magic".to_owned();
    let refused = clouds
        .basin(&ts(&ask))
        .map_err(words)
        .expect_err("no such method");
    assert!(refused.contains("`magic`"), "{refused}");
    let refused = slamlab_web::read_point_list(b"1,2\n3,x\n").map_err(words);
    assert!(refused.expect_err("no number").contains("line 2: y is `x`"));
    let points = slamlab_web::read_point_list(b"1,2\n3,4\n").map_err(words);
    assert_eq!(points.expect("two points"), [1.0, 2.0, 3.0, 4.0]);
    let nan = WebClouds::new(&[f64::NAN, 0.0], &pair.fixed, true).map_err(words);
    assert!(nan.expect_err("no point").contains("point 0 is not finite"));
}

#[wasm_bindgen_test]
fn a_bad_log_is_refused_with_its_line() {
    let refuse = |bytes: &[u8]| read(bytes, 50).expect_err("no log");
    assert!(refuse(b"").contains("empty"));
    assert!(refuse(&[0xff, 0xd8, 0xff, 0xe0]).contains("a JPEG picture"));
    assert!(refuse(&[0xc3, 0x28, 0x80, 0xfe]).contains("no text"));
    let text = log(3);
    assert!(refuse(&text.as_bytes()[..text.len() - 700]).contains("line 3"));
    // NaN costs one beam; a word that is not a number ends the reading.
    let word = text.replacen(" 2.00 ", " two ", 1);
    assert!(refuse(word.as_bytes()).contains("`two`"));
    let nan = text.replacen(" 2.00 ", " nan ", 1);
    assert!(read(nan.as_bytes(), 50).is_ok());
}

#[wasm_bindgen_test]
fn on_the_bench_the_controller_keeps_straight_what_motors_bend() {
    let run = experiment("arena", None).expect("a built-in world");
    let trial = BenchTrial {
        forward: 0.8,
        mismatch: 0.2,
        pull: 0.5,
        pull_at: 2.0,
        seconds: 4.0,
    };
    let answer: BenchResponse = rust(run.bench(&ts(&trial)));
    let n = answer.seconds.len();
    assert_eq!(
        (n, answer.speeds.len(), answer.headings.len()),
        (400, 4 * n, 2 * n)
    );
    let (closed, open) = (answer.headings[n - 1], answer.headings[2 * n - 1]);
    assert!(
        closed.abs() < 0.02 && open.abs() > 10.0 * closed.abs(),
        "{closed} {open}"
    );
    for side in 0..2 {
        let speed = answer.speeds[side * n + n - 1];
        assert!((speed - answer.wished[n - 1]).abs() < 0.02, "{speed}");
    }
}
