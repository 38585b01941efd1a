//! Bindings of the core for the page: they convert, call, and convert. Nothing is decided here.
//!
//! `border` holds the schema: objects of which the page knows the types, bulk data as typed arrays
//! in the map frame (m, rad), errors with a kind and the core's own sentence. A panic becomes a
//! thrown string.

mod again;
mod bench;
mod border;
mod building;
mod calibration;
mod contest;
mod dead_reckoned;
mod drive_fit;
mod driving;
mod edits;
mod export;
mod field;
mod inspection;
mod link;
mod live;
mod loaded_map;
mod local_bridge;
mod offer;
mod pose_graph;
mod quality;
mod recording;
mod registration;
mod rooms;
mod run;
mod saved_map;
mod settings;
mod setup;
mod sigma;
mod simulation;
mod status;
mod submaps;
mod view;

pub use bench::{BenchResponse, BenchTrial};
pub use border::*;
pub use building::{
    Building, GivenFile, PriorMapFile, PriorMapSetup, read_building, read_prior_map,
};
pub use calibration::{Calibration, Pairs, calibrate};
pub use contest::{AskError, ContestAsk, ContestState, Entrant, NoPathReason, WebContest};
pub use dead_reckoned::DeadReckonedChange;
pub use drive_fit::{DriveFit, FittedParameter, PresetFile, read_preset, write_preset};
pub use driving::{Cycle, StageWords};
pub use export::{ExportError, SavedFile};
pub use field::FieldChange;
pub use inspection::{Candidate, Inspection, LearnedOdometry, Sighting};
pub use link::{LinkStart, NoLink, read_link};
pub use live::{BridgeStatus, DeviceStatus, LiveSetup};
pub use loaded_map::{LoadedMapPicture, MapAlignment, WebLoadedMap};
pub use local_bridge::{DeviceKindError, LineWant, WebLocalBridge};
pub use offer::{DeviceKind, MethodInfo, Offer, SensorInfo, UsbAdapter, offer};
pub use pose_graph::{SolvedGraph, solve_graph};
pub use quality::{ClosedLoop, Quality, Stretch, Tear, WebJudgement};
pub use recording::{ReplaySetup, WebLogReader};
pub use registration::{
    AdvisedMethod, BasinAsk, CloudPair, LabError, MeasuredRow, PairInfo, Registered,
    RegistrationAdvice, RegistrationOffer, WebBasin, WebClouds, builtin_pair, read_point_list,
    registration_offer,
};
pub use rooms::{Doorway, Region, Rooms};
pub use run::{Notice, RunError, SourceKind, WebRun};
pub use saved_map::{MapStart, SavedMapPicture, TakenOut, WebSavedMap};
pub use settings::{PresetInfo, SettingInfo};
pub use setup::{Setup, SetupError};
pub use sigma::{SigmaBin, SigmaCurve};
pub use status::{RunStatus, Task};
pub use submaps::Submaps;
pub use view::{GridChange, SlamView};

/// A panic is thrown with its text, so that the page can say what happened instead of "unreachable
/// executed".
#[cfg(target_arch = "wasm32")]
#[wasm_bindgen::prelude::wasm_bindgen(start)]
fn start() {
    std::panic::set_hook(Box::new(|info| wasm_bindgen::throw_str(&info.to_string())));
}
