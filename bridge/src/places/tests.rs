use futures_util::FutureExt;

use super::*;

fn places() -> Arc<Places> {
    Places::new(Limits {
        sockets: 10,
        per_address: 6,
        watchers: 6,
        watchers_per_address: 4,
        ..Limits::default()
    })
}

fn address(last: u8) -> IpAddr {
    IpAddr::from([192, 168, 1, last])
}

fn was_pushed_out(place: &Place) -> bool {
    place.pushed_out().now_or_never().is_some()
}

#[test]
fn who_opens_many_pushes_out_its_own() {
    let places = places();
    let honest = places.enter(address(1)).unwrap();
    let many: Vec<_> = (0..100)
        .map(|_| places.enter(address(2)).unwrap())
        .collect();
    assert_eq!(places.taken(), 7);
    let gone = many
        .iter()
        .take_while(|place| was_pushed_out(place))
        .count();
    assert_eq!(gone, 94, "the oldest go");
    // From many addresses: the largest crowd goes first.
    let others: Vec<_> = (3..20)
        .map(|last| places.enter(address(last)).unwrap())
        .collect();
    assert_eq!(places.taken(), 10);
    assert!(!was_pushed_out(&honest) || others.iter().filter(|p| was_pushed_out(p)).count() > 0);
    drop((honest, many, others));
    assert_eq!(places.taken(), 0);
}

#[test]
fn watchers_leave_room_for_who_shows_the_token() {
    let places = places();
    let mut watching = vec![];
    for last in [1, 1, 1, 1, 1, 2, 2, 2, 2, 3] {
        let place = places.enter(address(last)).unwrap();
        if place.watch() {
            watching.push(place);
        }
    }
    assert_eq!(watching.len(), 6, "4 of one address, 2 of the next");
    let owners: Vec<_> = (0..4).map(|_| places.enter(address(9)).unwrap()).collect();
    assert!(owners.iter().all(Place::trust));
    assert!(places.enter(address(10)).is_none(), "all were let in");
    assert!(!watching.iter().chain(&owners).any(was_pushed_out));
    drop(watching);
    assert!(places.enter(address(10)).is_some());
}

#[test]
fn who_was_pushed_out_is_not_let_in() {
    let places = places();
    let first = places.enter(address(1)).unwrap();
    let _others: Vec<_> = (0..6).map(|_| places.enter(address(1)).unwrap()).collect();
    assert!(!first.watch() && !first.trust() && was_pushed_out(&first));
}

#[test]
fn a_network_of_ipv6_counts_as_one_address() {
    let of = |text: &str| network(text.parse().unwrap());
    assert_eq!(of("2001:db8::1"), of("2001:db8::ffff:1"));
    assert_ne!(of("2001:db8::1"), of("2001:db8:0:1::1"));
    assert_eq!(of("::ffff:192.168.1.1"), address(1));
}

#[test]
fn a_watcher_that_shows_its_token_later_keeps_its_place() {
    let places = places();
    let watching: Vec<_> = (0..4).map(|_| places.enter(address(1)).unwrap()).collect();
    assert!(watching.iter().all(Place::watch));
    assert!(
        watching.iter().all(Place::watch),
        "the house is full of them"
    );
    let fifth = places.enter(address(1)).unwrap();
    assert!(!fifth.watch());
    assert!(fifth.trust(), "who may drive gets in");
}
