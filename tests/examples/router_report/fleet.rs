//! Three bridges see each other through the router, and each stops the robots it is asked to stop.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use slamlab_core::wire::message::{DisarmReason, SafetyBody};
use tokio::time::sleep;

use crate::process::{Bridge, Router};
use crate::remote::{self, Remote};
use crate::started::{NEVER, free_port};
use crate::trust::Authority;
use crate::{part, spread, web};

const NAMES: [&str; 3] = ["anna", "berta", "clara"];
const ROUNDS: usize = 20;
/// Maximum time from a stop at the fleet's page until the driver is told.
const STOP_MS: f64 = 200.0;

pub(crate) async fn report() -> (bool, Value) {
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let router = Router::start(&endpoint, &json!({})).await;
    let mut bridges = vec![];
    for name in NAMES {
        bridges.push(Bridge::start(&["--zenoh", &endpoint, "--zenoh-name", name]).await);
    }
    let session = remote::session(&endpoint, &json!({})).await;
    // Each sees all, including itself, with the address of its page.
    let mut seen_by = 0;
    for bridge in &bridges {
        seen_by += usize::from(sees_all(bridge, &bridges).await);
    }
    let [anna, berta, clara] = &bridges[..] else {
        unreachable!("there are three")
    };
    let (_listening, mut at_router) = remote::safety(&session, NAMES[0]).await;
    let mut driver = Remote::enter(&session, NAMES[0], 1, Some(&anna.token)).await;
    let (mut stops, mut shown) = (vec![], 0);
    for round in 0..ROUNDS {
        driver.take_and_arm().await;
        shown += usize::from(shows(berta, NAMES[0], true).await);
        // In turns, that robot alone and all, each through another's bridge.
        let (bridge, path) = match round % 2 {
            0 => (berta, "/fleet/stop/anna"),
            _ => (clara, "/fleet/stop"),
        };
        let begun = Instant::now();
        let (status, body) = web::ask(bridge.address, "POST", path, None).await;
        assert_eq!(status, 202, "{body}");
        while driver.safety.armed && begun.elapsed() < NEVER {
            driver.next().await;
        }
        if driver.safety.reason == DisarmReason::Stop {
            stops.push(begun.elapsed());
        }
        shown += usize::from(shows(berta, NAMES[0], false).await);
    }
    sleep(Duration::from_millis(500)).await;
    let mut told: Vec<SafetyBody> = vec![];
    while let Ok(state) = at_router.try_recv() {
        told.push(state);
    }
    let is_stop = |state: &&SafetyBody| !state.armed && state.reason == DisarmReason::Stop;
    let stops_told = told.iter().filter(is_stop).count();
    let refused = refused(berta).await;
    // A robot that is gone is still listed, and reported as gone.
    let [anna, berta, clara] = bridges.try_into().ok().expect("there are three");
    anna.kill().await;
    let is_away_said = becomes(&berta, |fleet| {
        web::here(fleet).len() == 2 && fleet["robots"].as_array().is_some_and(|all| all.len() == 3)
    })
    .await;
    let (unknown, _) = web::ask(berta.address, "POST", "/fleet/stop/anna", None).await;
    router.kill().await;
    let is_loss_said = becomes(&berta, |fleet| fleet["connected"] == false).await;
    let (cut_off, _) = web::ask(berta.address, "POST", "/fleet/stop", None).await;
    for bridge in [berta, clara] {
        bridge.kill().await;
    }
    let holds = seen_by == NAMES.len()
        && stops.len() == ROUNDS
        && stops_told >= ROUNDS
        && shown == 2 * ROUNDS
        && part(&stops, 1.0) <= STOP_MS
        && refused == [403, 403, 404, 404]
        && is_away_said
        && unknown == 404
        && is_loss_said
        && cut_off == 503;
    let figures = json!({
        "bridges_that_see_all_three": seen_by, "rounds": ROUNDS, "stopped_by_another_bridge": stops.len(),
        "from_request_to_driver_told": spread(&stops), "stops_told_at_router": stops_told,
        "armed_and_disarmed_seen_at_another_bridge": shown,
        "foreign_page_private_bridge_and_unknown_robots_are_refused_with": refused,
        "robot_that_went_is_said_to_be_away": is_away_said, "its_stop_is_refused_with": unknown,
        "loss_of_router_is_said": is_loss_said, "stop_without_router_is_refused_with": cut_off,
        "limits": { "stop_ms": STOP_MS },
    });
    (holds, figures)
}

async fn sees_all(bridge: &Bridge, all: &[Bridge]) -> bool {
    becomes(bridge, |fleet| {
        NAMES.iter().zip(all).all(|(name, one)| {
            let page = format!("http://{}/", one.address);
            web::here(fleet).iter().any(|robot| {
                robot["name"] == *name && robot["page"] == page && robot["safety"].is_object()
            })
        })
    })
    .await
}

async fn shows(bridge: &Bridge, name: &str, armed: bool) -> bool {
    becomes(bridge, |fleet| {
        let mut here = web::here(fleet).into_iter();
        here.any(|robot| robot["name"] == name && robot["safety"]["armed"] == armed)
    })
    .await
}

async fn becomes(bridge: &Bridge, is: impl Fn(&Value) -> bool) -> bool {
    let begun = Instant::now();
    while begun.elapsed() < NEVER {
        if is(&web::fleet(bridge.address).await) {
            return true;
        }
        sleep(Duration::from_millis(20)).await;
    }
    eprintln!("the fleet is {}", web::fleet(bridge.address).await);
    false
}

/// The status for a foreign page, a bridge that wants the token, and unknown names.
async fn refused(bridge: &Bridge) -> [u16; 4] {
    let at = bridge.address;
    let (foreign, _) = web::ask(at, "POST", "/fleet/stop", Some("https://evil.example")).await;
    // Private is accepted only with a router that requires certificates; that none is running does
    // not matter.
    let folder = tempfile::tempdir().unwrap();
    let ours = Authority::make(folder.path(), "our");
    let [cert, key] = ours.sign(folder.path(), "dora");
    let [ca, cert, key] = [&ours.cert, &cert, &key].map(|path| path.to_str().unwrap());
    let endpoint = format!("tls/localhost:{}", free_port());
    let mut flags = vec!["--private", "--zenoh", &endpoint, "--zenoh-name", "dora"];
    flags.extend(["--zenoh-ca", ca, "--zenoh-cert", cert, "--zenoh-key", key]);
    let private = Bridge::start(&flags).await;
    let (closed, _) = web::ask(private.address, "GET", "/fleet.json", None).await;
    private.kill().await;
    let (unknown, _) = web::ask(at, "POST", "/fleet/stop/nobody", None).await;
    let (no_map, _) = web::ask(at, "GET", "/fleet/map/anna", None).await;
    [foreign, closed, unknown, no_map]
}
