//! The devices that a page can have at a serial port of its own.

use serde::{Deserialize, Serialize};
use slamlab_core::device::Kind;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{WebError, typed};

/// A kind of device that the page can have at a serial port.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Tsify)]
pub struct DeviceKind {
    /// What the rules know it by.
    pub name: String,
    /// As people call it.
    pub title: String,
    /// What it is good for.
    pub about: String,
    /// USB adapters that usually come with it. It works behind any other as well.
    pub adapters: Vec<UsbAdapter>,
}

/// A USB adapter, as Web Serial asks for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct UsbAdapter {
    /// Who made it.
    pub usb_vendor_id: u16,
    /// Which one it is.
    pub usb_product_id: u16,
}

/// The kinds that there are.
///
/// # Errors    None that a page can cause.
#[wasm_bindgen]
pub fn device_kinds() -> Result<Vec<Ts<DeviceKind>>, WebError> {
    let kind = |kind: &Kind| {
        let adapters = kind.adapters.iter().map(|adapter| UsbAdapter {
            usb_vendor_id: adapter.vendor,
            usb_product_id: adapter.product,
        });
        typed(&DeviceKind {
            name: kind.name.to_owned(),
            title: kind.title.to_owned(),
            about: kind.about.to_owned(),
            adapters: adapters.collect(),
        })
    };
    Kind::distinct().map(kind).collect()
}
