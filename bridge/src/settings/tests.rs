//! Reading files, precedence of layers, and errors that name the line.

use super::*;

fn read(text: &str) -> Result<Settings, SettingsError> {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("bridge.toml");
    std::fs::write(&path, text).unwrap();
    Settings::read(&path)
}

/// The file that the package installs.
const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/deploy/bridge.toml");

#[test]
fn the_installed_file_can_be_read_and_opens_the_page_to_the_network() {
    let settings = Settings::read(Path::new(EXAMPLE)).unwrap();
    let complete = settings.complete().unwrap();
    assert_eq!(complete.address(), "0.0.0.0:8080".parse().unwrap());
    assert_eq!(
        complete.token_file.unwrap(),
        Path::new("/var/lib/slamlab/token")
    );
    assert_eq!(complete.mdns, Some(true));
}

#[test]
fn every_key_stands_in_the_installed_file_and_its_comments_can_be_switched_on() {
    // A key that is off follows `#` without a space; prose has a space.
    let text = std::fs::read_to_string(EXAMPLE).unwrap();
    let switched_on: String = text
        .lines()
        .map(|line| match line.strip_prefix('#') {
            Some(rest) if !rest.starts_with(' ') && !rest.is_empty() => format!("{rest}\n"),
            _ => format!("{line}\n"),
        })
        .collect();
    let all: Settings = toml::from_str(&switched_on).unwrap();
    let said = toml::Table::try_from(&all).unwrap();
    let whole = toml::Table::try_from(whole()).unwrap();
    let keys = |table: &toml::Table| table.keys().cloned().collect::<Vec<_>>();
    assert_eq!(keys(&said), keys(&whole));
    assert!(
        all.source
            .unwrap()
            .iter()
            .any(|source| source.mount.is_some())
    );
}

/// Settings with every key. A struct with a new key does not compile until the key is added here.
fn whole() -> Settings {
    let path = || Some(PathBuf::from("/x"));
    Settings {
        listen: Some(LOCAL),
        port: Some(1),
        page: path(),
        open: Some(true),
        audit: path(),
        audit_budget_mib: Some(20),
        private: Some(true),
        allow_host: Some(vec!["robot.example.com".into()]),
        foxglove: Some(false),
        rosbridge: Some(true),
        allow_origin: Some(vec!["https://lab.example".into()]),
        token_file: path(),
        record: Some(PathBuf::from("/x/")),
        record_piece_mib: Some(10),
        record_piece_minutes: Some(2),
        record_budget_mib: Some(100),
        tls: Some(true),
        tls_cert: path(),
        tls_key: path(),
        mdns: Some(true),
        map: Some(MapSettings {
            file: path(),
            method: Some("scan-matching".into()),
            save_seconds: Some(5),
            on_link_loss: Some(Failsafe::Home),
            on_low_battery: Some(Failsafe::Hold),
            low_volts: Some(6.5),
            failsafe_right: Some("home".parse().unwrap()),
            set: [("matcher.cell".to_owned(), 0.1)].into(),
        }),
        storage: Some(StorageSettings {
            url: "s3://bucket/rp6".into(),
            part_mib: Some(8),
            verify: Some(true),
            options: [("aws_region".to_owned(), "eu-central-1".to_owned())].into(),
        }),
        zenoh: Some(ZenohSettings {
            router: Some("tls/router.example:7447".parse().unwrap()),
            name: Some("rp6".parse().unwrap()),
            ca: path(),
            cert: path(),
            key: path(),
            ros_domain: Some(7),
            ros_namespace: Some("rp6".into()),
            ros_right: Some("ros".parse().unwrap()),
        }),
        source: Some(vec![SourceSettings {
            name: "ld06:/dev/serial0".parse().unwrap(),
            mount: Some(Mount {
                x: 0.04,
                y: -0.01,
                yaw_degrees: 90.0,
            }),
        }]),
    }
}

#[test]
fn what_is_unknown_or_cannot_be_is_named_with_its_line() {
    for (text, line, words) in [
        (
            "private = true\nlisten-on = 3\n",
            2,
            "unknown field `listen-on`",
        ),
        ("\n\nlisten = \"everywhere\"\n", 3, "invalid socket address"),
        ("open = \"yes\"", 1, "expected a boolean"),
        (
            "[[source]]\nname = \"rp7:/dev/rp6\"\n",
            2,
            "there is no source `rp7:/dev/rp6`",
        ),
        (
            "[[source]]\nname = \"ld06:/dev/x\"\nmount = { x = 0.1, z = 1 }\n",
            3,
            "unknown field `z`",
        ),
        (
            "[[source]]\nmount = { x = 0.1 }\n",
            1,
            "missing field `name`",
        ),
        (
            "open = false\nsource = [\"sim:office\"]\n",
            2,
            "expected [[source]] on a line of its own for each, and below it name = \"KIND:WHICH\"",
        ),
        ("open = true\nopen = false\n", 2, "duplicate key"),
        ("port = 99999", 1, "expected u16"),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(
            error.contains(&format!("line {line}")) && error.contains(words),
            "{text:?} gave: {error}"
        );
    }
    let error = Settings::read(Path::new("/nowhere/bridge.toml"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("/nowhere/bridge.toml"), "{error}");
}

#[test]
fn the_upper_layer_wins_key_by_key() {
    let all = whole();
    assert_eq!(Settings::default().over(all.clone()), all);
    assert_eq!(all.clone().over(Settings::default()), all);
    let flags = Settings {
        private: Some(false),
        source: Some(vec![]),
        ..Settings::default()
    };
    let both = flags.over(all.clone());
    assert_eq!(both.private, Some(false));
    assert_eq!(both.source, Some(vec![]));
    assert_eq!(both.listen, all.listen);
    // A port in the file belongs to the address in the file.
    let other = "0.0.0.0:99".parse().unwrap();
    let flags = Settings {
        listen: Some(other),
        ..Settings::default()
    };
    assert_eq!(flags.over(all).complete().unwrap().address(), other);
}

#[test]
fn what_is_printed_says_the_same_when_it_is_read() {
    for settings in [Settings::default(), whole()] {
        let complete = settings.complete().unwrap();
        let text = toml::to_string(&complete).unwrap();
        assert_eq!(read(&text).unwrap(), complete, "{text}");
        assert_eq!(complete.clone().complete().unwrap(), complete, "{text}");
    }
}

#[test]
fn only_a_bridge_that_listens_to_the_network_is_announced() {
    let mdns = |text| read(text).unwrap().complete().unwrap().mdns == Some(true);
    assert!(!mdns(""));
    assert!(mdns("listen = \"0.0.0.0:8080\""));
    assert!(!mdns("listen = \"0.0.0.0:8080\"\nmdns = false"));
    assert!(mdns("mdns = true"));
}

#[test]
fn half_a_certificate_and_a_mount_outside_of_the_robot_are_refused() {
    let refused = |text: &str| read(text).unwrap().complete().unwrap_err().to_string();
    assert!(refused("tls-cert = \"a\"").contains("tls-key is missing"));
    assert!(refused("tls = true\ntls-key = \"a\"").contains("tls-cert is missing"));
    let mount = |figures: &str| {
        refused(&format!(
            "[[source]]\nname = \"ld06:/dev/x\"\nmount = {{ {figures} }}"
        ))
    };
    assert!(mount("x = 40.0").contains("x is 40; expected a number of at most 2"));
    assert!(mount("yaw-degrees = nan").contains("yaw-degrees is NaN"));
    assert!(mount("y = -inf").contains("mount of ld06:/dev/x: y is -inf"));
}

#[test]
fn recordings_that_cannot_be_kept_and_origins_that_no_browser_writes_are_refused() {
    let refused = |text: &str| read(text).unwrap().complete().unwrap_err().to_string();
    assert!(refused("record-piece-mib = 0").contains("record-piece-mib is 0; expected 1 to"));
    assert!(refused("record-piece-minutes = 9999999").contains("record-piece-minutes is 9999999"));
    let budget = refused("record = \"/x/\"\nrecord-budget-mib = 100\nrecord-piece-mib = 60");
    assert!(budget.contains("room for two pieces"), "{budget}");
    let settings =
        read("record = \"/x/\"\nrecord-budget-mib = 100\nrecord-piece-mib = 50").unwrap();
    let keep = settings.complete().unwrap().keep();
    assert_eq!((keep.piece_bytes, keep.all_bytes), (50 << 20, 100 << 20));
    for (origin, why) in [
        ("*", "every page"),
        ("null", "any page"),
        ("https://lab.example/", "slash"),
    ] {
        let error = refused(&format!(
            "allow-origin = [\"https://good.example\", {origin:?}]"
        ));
        assert!(error.contains(origin) && error.contains(why), "{error}");
    }
}

#[test]
fn hosts_that_no_browser_asks_for_and_audits_without_room_are_refused() {
    let refused = |text: &str| read(text).unwrap().complete().unwrap_err().to_string();
    for (host, why) in [
        ("*", "left open"),
        ("https://robot.example", "scheme"),
        ("robot.example:443", "port"),
        ("Robot.example", "lower-case"),
    ] {
        let error = refused(&format!("allow-host = [\"good.example\", {host:?}]"));
        assert!(error.contains(host) && error.contains(why), "{error}");
    }
    assert!(refused("audit-budget-mib = 0").contains("audit-budget-mib is 0; expected 1 to"));
    let settings = read("audit = \"/x\"\naudit-budget-mib = 8").unwrap();
    let (folder, keep) = settings.complete().unwrap().audit().unwrap();
    assert_eq!(folder, Path::new("/x"));
    assert_eq!((keep.piece_bytes, keep.all_bytes), (1 << 20, 8 << 20));
    let none = Settings::default().complete().unwrap().audit();
    assert!(
        none.is_none(),
        "nothing is written down unless somebody asks"
    );
}

#[test]
fn a_lidar_sits_where_the_file_says_and_nothing_else_can_be_mounted() {
    let open = |name: &str| {
        SourceSettings {
            name: name.parse().unwrap(),
            ..whole().source.unwrap().remove(0)
        }
        .open()
    };
    for lidar in ["ld06:/dev/x", "rplidar:/dev/x", "rplidar-express:/dev/x"] {
        assert!(open(lidar).is_ok(), "{lidar}");
    }
    for other in ["sim:arena", "rp6:/dev/x"] {
        let error = open(other).err().unwrap().to_string();
        assert!(error.contains(other) && error.contains("mount"), "{error}");
    }
}

#[test]
fn a_robot_goes_home_only_by_a_right_and_a_map_is_made_by_a_method_that_there_is() {
    let refused = |text: &str| read(text).unwrap().complete().unwrap_err().to_string();
    let home = "[map]\non-link-loss = \"home\"";
    assert!(refused(home).contains("failsafe-right"));
    assert!(refused("[map]\nlow-volts = nan").contains("low-volts is NaN; expected 1 to 100"));
    assert!(
        refused("[map]\nfile = \"a\"\nsave-seconds = 0")
            .contains("save-seconds is 0; expected 1 to")
    );
    let method = refused("[map]\nmethod = \"magic\"");
    assert!(
        method.contains("magic") && method.contains("scan-matching"),
        "{method}"
    );
    let settings = read(&format!("{home}\nfailsafe-right = \"home\"")).unwrap();
    let map = settings.complete().unwrap().map().unwrap().unwrap();
    let home = map.home.unwrap();
    assert!(home.when.on_link_loss && !home.when.on_low_battery);
    let held = read("[map]").unwrap().complete().unwrap().map().unwrap();
    assert_eq!(held, Some(crate::MapConfig::default()));
    let off = Settings::default().complete().unwrap().map().unwrap();
    assert!(off.is_none());
}

#[test]
fn a_router_that_cannot_be_reached_as_asked_is_said_in_words() {
    let check = |text: &str, words: &str| {
        let said = match read(text).and_then(Settings::complete) {
            Ok(_) => "nothing".to_owned(),
            Err(error) => error.to_string(),
        };
        assert!(said.contains(words), "{text}: {said}");
    };
    let tls = "[zenoh]\nrouter = \"tls/r:1\"\n";
    check("[zenoh]\nname = \"a\"", "zenoh router is missing");
    check("[zenoh]\nrouter = \"udp/r:1\"", "neither tcp nor tls");
    check("[zenoh]\nrouter = \"tcp/r:1\"\nname = \"a/b\"", "a/b");
    check(
        "[zenoh]\nrouter = \"tcp/r:1\"\nca = \"x\"",
        "zenoh router is tcp/",
    );
    check(tls, "zenoh ca is missing");
    check(
        &format!("{tls}ca = \"x\"\ncert = \"x\""),
        "zenoh key is missing",
    );
    check(
        &format!("{tls}ca = \"x\"\nkey = \"x\""),
        "zenoh cert is missing",
    );
    check(&format!("private = true\n{tls}ca = \"x\""), "private");
    let tcp = "[zenoh]\nrouter = \"tcp/r:1\"\nname = \"a\"\n";
    check(&format!("private = true\n{tcp}"), "private");
    check(
        &format!("{tcp}ros-domain = 233"),
        "zenoh ros-domain is too high",
    );
    check(
        &format!("{tcp}ros-right = \"a\""),
        "zenoh ros-domain is missing",
    );
    let namespace = |name| format!("{tcp}ros-domain = 0\nros-namespace = {name:?}");
    check(&namespace("1st"), "zenoh ros-namespace");
    check(&namespace("a//b"), "zenoh ros-namespace");
    check(&namespace("/a"), "zenoh ros-namespace");
    check(&namespace("a-b"), "zenoh ros-namespace");
    check(&namespace("floor_1/rp6"), "nothing");
}

#[test]
fn paths_without_a_name_and_settings_that_do_nothing_are_refused() {
    let refused = |text: &str| read(text).unwrap().complete().unwrap_err().to_string();
    for (text, words) in [
        ("audit = \"\"", "audit is empty"),
        ("record = \"\"", "record is empty"),
        ("token-file = \"\"", "token-file is empty"),
        ("tls-cert = \"\"\ntls-key = \"\"", "tls-cert is empty"),
        ("[map]\nfile = \"\"", "map file is empty"),
        ("private = true\nfoxglove = true", "foxglove does nothing"),
        (
            "[map]\nfailsafe-right = \"a\"",
            "failsafe-right does nothing",
        ),
        ("[map]\nlow-volts = 6", "low-volts does nothing"),
        ("[map]\nsave-seconds = 9", "save-seconds does nothing"),
        (
            "record = \"/x/a.mcap\"\nrecord-budget-mib = 4000",
            "record-budget-mib does nothing",
        ),
        (
            "record-piece-mib = 9",
            "record-piece-mib does nothing: nothing is recorded",
        ),
        (
            "audit = \"/x\"\nrecord-piece-minutes = 9",
            "record-piece-minutes does nothing",
        ),
        ("record-budget-mib = 4000", "record-budget-mib does nothing"),
        (
            "record = \"/x/\"\naudit-budget-mib = 9",
            "audit-budget-mib does nothing: no audit",
        ),
    ] {
        let error = refused(text);
        assert!(error.contains(words), "{text}: {error}");
    }
    assert!(read("record = \"/x/a.mcap\"").unwrap().complete().is_ok());
}

#[test]
fn a_store_that_shows_or_is_what_it_should_not_is_refused() {
    let refused = |text: &str| read(text).unwrap().complete().unwrap_err().to_string();
    for (url, words) in [
        ("", "storage url \"\": it is empty"),
        ("s3://me:hidden@drives/robot", "a user or a password"),
        ("s3://hidden@drives/robot", "a user or a password"),
        ("ftp:me:hidden@drives", "a user or a password"),
        (
            "abfss://drives:hidden@a.dfs.core.windows.net/r",
            "a user or a password",
        ),
        ("az://drives/robot?sig=hidden", "storage url holds a query"),
    ] {
        let error = refused(&format!("record = \"/x/\"\n[storage]\nurl = {url:?}"));
        assert!(
            error.contains(words) && !error.contains("hidden"),
            "{error}"
        );
    }
    for good in [
        "s3://drives/@",
        "abfss://drives@a.dfs.core.windows.net/r",
        "file:///a@b/c",
    ] {
        let text = format!("record = \"/x/\"\n[storage]\nurl = {good:?}");
        let complete = read(&text).unwrap().complete();
        // Azure's store also wants a key, if support for it is built in.
        let said = complete.map_or_else(|error| error.to_string(), |_| String::new());
        assert!(!said.contains("whoever watches"), "{said}");
    }
}

#[cfg(feature = "storage")]
#[test]
fn the_folder_of_the_recording_is_no_store() {
    let said = |record: &str, url: &str| {
        let text = format!("record = {record:?}\n[storage]\nurl = {url:?}");
        let complete = read(&text).unwrap().complete();
        complete.map_or_else(|error| error.to_string(), |_| "nothing".to_owned())
    };
    for url in ["file:///x/drives", "file:///x/drives/stored/", "file:///x"] {
        let said = said("/x/drives/", url);
        assert!(said.contains("recordings are made in /x/drives/"), "{said}");
        assert!(said.starts_with("storage url "), "{said}");
    }
    assert_eq!(said("/x/drives/", "file:///x/stored"), "nothing");
}

#[test]
fn what_opens_the_store_is_not_shown() {
    let options = [
        ("aws_access_key_id", "hidden"),
        ("aws_secret_access_key", "hidden"),
        ("AWS_SESSION_TOKEN", "hidden"),
        ("azure_storage_sas_key", "hidden"),
        ("proxy_url", "http://me:hidden@proxy"),
        ("aws_endpoint", "https://s3.example"),
        ("aws_region", "eu-central-1"),
    ];
    let options = options.map(|(key, value)| (key.to_owned(), value.to_owned()));
    let settings = Settings {
        storage: Some(StorageSettings {
            url: "s3://drives".into(),
            options: options.into(),
            ..StorageSettings::default()
        }),
        ..Settings::default()
    };
    let shown = toml::to_string(&settings.without_secrets()).unwrap();
    assert!(!shown.contains("hidden"), "{shown}");
    assert_eq!(shown.matches("(not shown)").count(), 5, "{shown}");
    assert!(shown.contains("https://s3.example") && shown.contains("eu-central-1"));
}
