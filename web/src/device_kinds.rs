//! The devices that a page can have at a serial port of its own.

use slamlab_core::device::Kind;
use wasm_bindgen::prelude::wasm_bindgen;

/// A kind of device, as the page offers it.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceKind {
    /// What the rules know it by.
    pub name: String,
    /// As people call it.
    pub title: String,
    /// What it is good for.
    pub about: String,
    /// USB adapters that usually come with it: vendor, product, vendor, product …
    pub adapters: Vec<u16>,
}

/// The kinds that there are.
#[wasm_bindgen]
#[must_use]
pub fn device_kinds() -> Vec<DeviceKind> {
    let kind = |kind: &Kind| DeviceKind {
        name: kind.name.to_owned(),
        title: kind.title.to_owned(),
        about: kind.about.to_owned(),
        adapters: kind
            .adapters
            .iter()
            .flat_map(|adapter| [adapter.vendor, adapter.product])
            .collect(),
    };
    Kind::distinct().map(kind).collect()
}
