//! The file, valid and invalid: errors name their line, and an invalid file is never overwritten.

use std::fs;

use proptest::prelude::*;
use slamlab_core::wire::message::{CHALLENGE_BYTES, proof};
use tempfile::TempDir;

use super::*;
use crate::rights::Rights;

fn in_folder() -> (TempDir, RightsFile) {
    let folder = TempDir::new().unwrap();
    let file = RightsFile::at(folder.path().join("rights.toml"));
    (folder, file)
}

fn name(text: &str) -> Name {
    text.parse().unwrap()
}

fn noon() -> Datetime {
    "2026-11-27T12:00:00Z".parse().unwrap()
}

#[test]
fn a_right_is_made_listed_and_taken_away() {
    let (_folder, file) = in_folder();
    assert_eq!(file.list().unwrap(), []);
    let anna = file.add(name("anna"), Role::Driver, noon()).unwrap();
    let wall = file.add(name("wall"), Role::Watcher, noon()).unwrap();
    let shown = |token: &Token| {
        let challenge = [3; CHALLENGE_BYTES];
        let rights = Rights(file.granted().unwrap());
        let granted = rights.proved(&challenge, &proof(token.reveal(), &challenge));
        granted.map(|granted| (granted.right.name, granted.right.role))
    };
    assert_eq!(shown(&anna), Some(("anna".to_owned(), Role::Driver)));
    assert_eq!(shown(&wall), Some(("wall".to_owned(), Role::Watcher)));
    let text = fs::read_to_string(file.path()).unwrap();
    assert!(
        !text.contains(anna.reveal()),
        "the token stands in the file"
    );
    let listed = file.list().unwrap();
    assert_eq!(listed.len(), 2);
    assert_eq!(listed[0].made, "2026-11-27T12:00:00Z");
    let again = file.add(name("anna"), Role::Owner, noon()).unwrap_err();
    assert!(matches!(again, RightsError::Taken(_)), "{again}");
    assert_eq!(file.revoke(&name("anna")).unwrap(), Role::Driver);
    assert_eq!(shown(&anna), None);
    assert!(shown(&wall).is_some());
    let gone = file.revoke(&name("anna")).unwrap_err().to_string();
    assert_eq!(gone, "there is no right of the name anna; there are wall");
}

#[cfg(unix)]
#[test]
fn only_its_owner_may_read_it() {
    use std::os::unix::fs::PermissionsExt;
    let (_folder, file) = in_folder();
    file.add(name("anna"), Role::Driver, noon()).unwrap();
    let mode = |mode| fs::set_permissions(file.path(), fs::Permissions::from_mode(mode)).unwrap();
    assert_eq!(
        fs::metadata(file.path()).unwrap().permissions().mode() & 0o777,
        0o600
    );
    mode(0o640);
    let error = file.granted().unwrap_err().to_string();
    assert!(error.contains("mode 640"), "{error}");
}

fn block(name: &str) -> String {
    let verifier = "0f".repeat(32);
    format!(
        "[[right]]\nname = \"{name}\"\nrole = \"driver\"\nverifier = \"{verifier}\"\nmade = 2026-11-27T12:00:00Z\n"
    )
}

#[test]
fn what_is_wrong_is_said_with_its_line_and_left_as_it_is() {
    let (_folder, file) = in_folder();
    let good = block("anna");
    for (text, expected) in [
        ("buy batteries".to_owned(), "line 1"),
        ("[[right]]\nname = \"anna\"\n".to_owned(), "line 1"),
        (good.replace("driver", "king"), "line 3"),
        (good.replace("anna", "an na"), "line 2"),
        (good.replace("0f0f", "0g0f"), "line 4"),
        (good.replace("0f0f", ""), "line 4"),
        (good.replace("2026-11", "2026-13"), "line 5"),
        (format!("{good}extra = 1\n"), "line 6"),
        (format!("{good}\n{good}"), "line 8"),
        (format!("{good}\n[other]\n"), "line 7"),
    ] {
        secret_file::write(file.path(), &text).unwrap();
        let before = fs::read(file.path()).unwrap();
        let error = file.granted().unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
        assert!(error.contains("rights.toml"), "{error}");
        assert!(file.add(name("new"), Role::Owner, noon()).is_err());
        assert!(file.revoke(&name("anna")).is_err());
        assert_eq!(fs::read(file.path()).unwrap(), before);
    }
}

#[test]
fn two_commands_at_a_time_lose_nothing() {
    let (_folder, file) = in_folder();
    std::thread::scope(|scope| {
        for first in 0..4 {
            let file = &file;
            scope.spawn(move || {
                for second in 0..5 {
                    let name = name(&format!("n{first}{second}"));
                    file.add(name, Role::Watcher, noon()).unwrap();
                }
            });
        }
    });
    assert_eq!(file.list().unwrap().len(), 20);
}

proptest! {
    /// Any text gives rights or an error, never a panic; and a command that fails writes nothing.
    #[test]
    fn any_text_is_rights_or_an_error(
        text in prop_oneof![any::<String>(), "(\\[\\[right\\]\\]|name|role|verifier|made|=|\"|\n|[a-z0-9]){0,60}"],
        cut in 0_usize..400, at in 0_usize..400, byte in 0_u8..128,
    ) {
        let (_folder, file) = in_folder();
        let mut spoilt = format!("{}{}", block("anna"), block("bert")).into_bytes();
        if let Some(place) = spoilt.get_mut(at) {
            *place = byte;
        }
        spoilt.truncate(cut);
        for text in [text, String::from_utf8(spoilt).unwrap()] {
            secret_file::write(file.path(), &text).unwrap();
            let before = fs::read(file.path()).unwrap();
            let is_good = file.granted().is_ok();
            let added = file.add(name("zoe"), Role::Driver, noon());
            prop_assert!(is_good || added.is_err());
            prop_assert!(added.is_ok() || fs::read(file.path()).unwrap() == before);
        }
    }

    #[test]
    fn what_is_written_is_read(names in prop::collection::btree_set("[a-zäß][a-z0-9_.-]{0,8}[a-z0-9]", 0..12), pick in 0_usize..3) {
        let (_folder, file) = in_folder();
        let role = Role::ALL[pick];
        for text in &names {
            file.add(name(text), role, noon()).unwrap();
        }
        let read: std::collections::BTreeSet<String> =
            file.list().unwrap().into_iter().map(|listed| listed.name.into()).collect();
        prop_assert_eq!(&read, &names);
        for text in &names {
            prop_assert_eq!(file.revoke(&name(text)).unwrap(), role);
        }
        prop_assert_eq!(file.list().unwrap(), []);
    }
}
