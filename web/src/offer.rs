//! What a person can choose from: worlds, sensors, methods, devices and presets, from the tables of
//! the core.

use serde::{Deserialize, Serialize};
use slamlab_core::device::Kind;
use slamlab_core::robot::Sharp;
use slamlab_core::settings::PRESETS;
use slamlab_core::sim::{SensorKind, worlds};
use slamlab_core::slam::Method;
use tsify::Tsify;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{MethodName, Typed, typed};
use crate::lesson::{LessonInfo, lessons};
use crate::settings::PresetInfo;

/// All that can be chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
#[tsify(hashmap_as_object, missing_as_null)]
pub struct Offer {
    /// Names of the built-in worlds.
    pub worlds: Vec<String>,
    /// Sensors of a simulated robot.
    pub sensors: Vec<SensorInfo>,
    /// The SLAM methods.
    pub methods: Vec<MethodInfo>,
    /// Devices that the page can use at a serial port of its own.
    pub devices: Vec<DeviceKind>,
    /// Named sets of settings.
    pub presets: Vec<PresetInfo>,
    /// Runs with a fault, to be mended.
    pub lessons: Vec<LessonInfo>,
    /// The pairs of the data sheet of the simulated rangers, as text.
    pub data_sheet: String,
}

/// A sensor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Tsify)]
pub struct SensorInfo {
    /// Its name in setups and commands.
    pub name: String,
    /// Its title for people.
    pub title: String,
}

/// A method.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct MethodInfo {
    /// Its name in setups and commands.
    pub name: MethodName,
    /// Its title for people.
    pub title: String,
    /// What it does, in a sentence.
    pub meaning: String,
}

/// A kind of device that the page can have at a serial port.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Tsify)]
pub struct DeviceKind {
    /// Its name in the core.
    pub name: String,
    /// Its title for people.
    pub title: String,
    /// Its purpose.
    pub about: String,
    /// USB adapters that usually come with it. Any other adapter works as well.
    pub adapters: Vec<UsbAdapter>,
}

/// A USB adapter, as Web Serial asks for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct UsbAdapter {
    /// Vendor.
    pub usb_vendor_id: u16,
    /// Product.
    pub usb_product_id: u16,
}

/// What a person can choose from.
///
/// # Errors    None that a page can cause.
#[wasm_bindgen]
pub fn offer() -> Typed<Offer> {
    let sensor = |(name, _, title): (&str, SensorKind, &str)| SensorInfo {
        name: name.to_owned(),
        title: title.to_owned(),
    };
    let method = |method: Method| MethodInfo {
        name: method.into(),
        title: method.title().to_owned(),
        meaning: method.meaning().to_owned(),
    };
    let pairs = Sharp::default().data_sheet();
    let pairs = pairs
        .iter()
        .map(|pair| format!("{:.0};{:.2}\n", 100.0 * pair.range, pair.volts));
    typed(&Offer {
        worlds: worlds::NAMES.map(str::to_owned).into(),
        sensors: SensorKind::ALL.map(sensor).into(),
        methods: Method::ALL.map(method).into(),
        devices: Kind::distinct().map(device).collect(),
        presets: PRESETS.iter().map(Into::into).collect(),
        lessons: lessons()?,
        data_sheet: format!("range_cm;volts\n{}", pairs.collect::<String>()),
    })
}

fn device(kind: &Kind) -> DeviceKind {
    let adapters = kind.adapters.iter().map(|adapter| UsbAdapter {
        usb_vendor_id: adapter.vendor,
        usb_product_id: adapter.product,
    });
    DeviceKind {
        name: kind.name.to_owned(),
        title: kind.title.to_owned(),
        about: kind.about.to_owned(),
        adapters: adapters.collect(),
    }
}
