//! `slamlab-bridge token`: the owner's address, and the rights of others.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use anyhow::Context;
use slamlab_bridge::rights::{Name, RightsFile};
use slamlab_bridge::settings::{Settings, Tls};
use slamlab_bridge::tls::{Identity, UNNAMED};
use slamlab_bridge::token::{self, Token, TokenError};
use slamlab_bridge::{address, trust};
use slamlab_core::wire::message::Role;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::answer::answer;
use crate::flags::{AddFlags, TokenCommand, TokenFlags};

/// The file of the rights, beside the owner's token file.
const RIGHTS: &str = "rights.toml";

pub(crate) fn run(flags: TokenFlags) -> anyhow::Result<()> {
    match flags.command {
        None => show_owner(flags),
        Some(TokenCommand::Add(flags)) => add(flags),
        Some(TokenCommand::List { serve }) => list(&serve.complete()?),
        Some(TokenCommand::Revoke { name, serve }) => revoke(&name, &serve.complete()?),
    }
}

fn show_owner(flags: TokenFlags) -> anyhow::Result<()> {
    let settings = flags.serve.complete()?;
    let token = match flags.new {
        true => Token::renew(&path(&settings)?)?,
        false => owner(&settings)?,
    };
    show(&token, "to drive", flags.qr, &settings)
}

fn add(flags: AddFlags) -> anyhow::Result<()> {
    let settings = flags.serve.complete()?;
    // No bridge would look for rights beside a file that holds no token.
    owner_if_any(&path(&settings)?)?;
    let now = OffsetDateTime::from(SystemTime::now());
    let now = now.replace_nanosecond(0).unwrap_or(now).format(&Rfc3339)?;
    let token = rights(&settings)?.add(flags.name.clone(), flags.role, now.parse()?)?;
    let may = match flags.role {
        Role::Watcher => "to look, and to stop the robot",
        Role::Driver => "to drive",
        Role::Owner => "to drive, and to take the robot from anybody",
    };
    let article = if flags.role == Role::Owner { "an" } else { "a" };
    answer!(
        "{} is {article} {} from now on. The address is shown this once:\n",
        flags.name,
        flags.role
    )?;
    show(&token, may, flags.qr, &settings)
}

fn list(settings: &Settings) -> anyhow::Result<()> {
    let rights = rights(settings)?;
    let all = rights.list()?;
    let path = path(settings)?;
    match owner_if_any(&path)? {
        Some(_) => answer!("(the token of {})  owner", path.display())?,
        None => answer!("(no owner: there is no {} yet)", path.display())?,
    }
    for listed in all {
        answer!("{}  {}  made {}", listed.name, listed.role, listed.made)?;
    }
    Ok(())
}

fn revoke(name: &Name, settings: &Settings) -> anyhow::Result<()> {
    let role = rights(settings)?.revoke(name)?;
    answer!(
        "{name} is no {role} any more; a running bridge ends what is done by that right within a second"
    )?;
    Ok(())
}

/// Prints the addresses with the token, and on request one of them as a picture.
fn show(token: &Token, may: &str, with_picture: bool, settings: &Settings) -> anyhow::Result<()> {
    let tls = settings.tls()?;
    let own = match &tls {
        Tls::Own => Some(Identity::load_or_make(&folder(settings)?)?),
        Tls::Off | Tls::Files { .. } => None,
    };
    let all = address::urls(settings.address(), tls != Tls::Off);
    let plain = own.as_ref().map_or(all.clone(), |own| own.named(all));
    let with_token = |url: &str| format!("{url}#token={}", token.reveal());
    for url in &plain {
        answer!("{}", with_token(url))?;
    }
    let Some(of_phone) = address::for_a_phone(&plain) else {
        answer!("the token is {}; {UNNAMED}", token.reveal())?;
        return Ok(());
    };
    if let Some(identity) = own {
        let first = trust::address(of_phone, identity.fingerprint());
        answer!("\nonce on each phone, so that it trusts the robot:\n{first}")?;
        if with_picture {
            answer!("{}\nthen, {may}:", picture(&first)?)?;
        }
    }
    if with_picture {
        answer!("{}", picture(&with_token(of_phone))?)?;
    }
    Ok(())
}

/// A QR code for a terminal.
fn picture(url: &str) -> anyhow::Result<String> {
    let code = qrcode::QrCode::new(url).context("the address does not fit into a picture")?;
    Ok(code.render::<qrcode::render::unicode::Dense1x2>().build())
}

/// The owner's token; made if there is none.
pub(crate) fn owner(settings: &Settings) -> anyhow::Result<Token> {
    Ok(Token::load_or_create(&path(settings)?)?)
}

/// The owner's token; none if there is no file yet.
fn owner_if_any(path: &Path) -> Result<Option<Token>, TokenError> {
    match Token::load(path) {
        Err(error) if error.is_not_found() => Ok(None),
        found => found.map(Some),
    }
}

/// The path of the owner's token.
pub(crate) fn path(settings: &Settings) -> anyhow::Result<PathBuf> {
    match &settings.token_file {
        Some(path) => Ok(path.clone()),
        None => token::default_path().context("where is the token?"),
    }
}

/// The file of all other rights.
pub(crate) fn rights(settings: &Settings) -> anyhow::Result<RightsFile> {
    Ok(RightsFile::at(folder(settings)?.join(RIGHTS)))
}

/// The folder in which the bridge keeps its own files.
pub(crate) fn folder(settings: &Settings) -> anyhow::Result<PathBuf> {
    let token = path(settings)?;
    let folder = token
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    Ok(folder.map_or_else(|| ".".into(), PathBuf::from))
}
