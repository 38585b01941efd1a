//! Bindings of the core for the page: they convert, call, and convert. Nothing is decided here.
//!
//! Numbers cross as plain fields, bulk data as typed arrays in the map frame (m, rad); the page's side of it stands in
//! `www/src/source`. An error becomes a JavaScript `Error` with the core's own sentence, a panic a thrown string.

mod bench;
mod building;
mod calibration;
mod contest;
mod device_kinds;
mod drive_fit;
mod experiment;
mod export;
mod field;
mod inspection;
mod live;
mod local_bridge;
mod replay;
mod rooms;
mod settings;
mod setup;
mod shows_slam;
mod sigma;
mod status;
mod view;

pub use bench::BenchResponse;
pub use building::{Building, BuildingFiles, Known};
pub use calibration::{Calibration, CalibrationError, calibrate, data_sheet};
pub use contest::{AskError, WebContest};
pub use device_kinds::{DeviceKind, device_kinds};
pub use drive_fit::{FitTable, PresetText, read_preset, write_preset};
pub use experiment::WebExperiment;
pub use export::{ExportError, Files};
pub use field::{FieldView, UnknownField};
pub use inspection::Inspection;
pub use live::{BridgeStatus, WebLive};
pub use local_bridge::{DeviceKindError, LineWant, WebLocalBridge};
pub use replay::{WebLogReader, WebReplay};
pub use rooms::Rooms;
pub use settings::{PresetInfo, SettingInfo, preset_list, setting_list};
pub use setup::{SetupError, WebSetup};
pub use sigma::{GrowthError, SigmaCurve};
pub use status::RunStatus;
pub use view::SlamView;

use slamlab_core::sim::{SensorKind, worlds};
use wasm_bindgen::prelude::wasm_bindgen;

/// The version of the core inside the module.
#[wasm_bindgen]
#[must_use]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// Names of the built-in worlds.
#[wasm_bindgen]
#[must_use]
pub fn world_names() -> Vec<String> {
    worlds::NAMES.map(str::to_owned).into()
}

/// Names of the sensors, each followed by what a person calls it.
#[wasm_bindgen]
#[must_use]
pub fn sensor_names() -> Vec<String> {
    let names = SensorKind::ALL.map(|(name, _, title)| [name, title]);
    names.as_flattened().iter().map(|&n| n.to_owned()).collect()
}

/// A panic is thrown with its text, so that the page can say what happened instead of "unreachable executed".
#[cfg(target_arch = "wasm32")]
#[wasm_bindgen(start)]
fn start() {
    std::panic::set_hook(Box::new(|info| wasm_bindgen::throw_str(&info.to_string())));
}
