//! Bindings of the core for the page: they convert, call, and convert back. They decide nothing.
//!
//! `border` holds the schema: objects whose types the page knows, bulk data as typed arrays in the
//! map frame (m, rad), errors with a kind and the core's own sentence. A panic becomes a thrown
//! string.
//!
//! Each feature makes one WebAssembly module: what the page needs at once, and what is loaded on
//! demand. All contain the border.
//!
//! | feature | module | what it has |
//! |---|---|---|
//! | `run` | `slamlab_web` | runs of any source, and all that is asked of them |
//! | `files` | `slamlab_files` | buildings, pose graphs, recordings of ROS; worlds that are drawn |
//! | `lab` | `slamlab_lab` | the registration lab |
//! | `cable` | `slamlab_cable` | the local bridge |
#![cfg_attr(
    not(all(feature = "cable", feature = "files", feature = "lab", feature = "run")),
    allow(
        dead_code,
        unused_imports,
        unused_macros,
        reason = "the border is that of all modules together"
    )
)]

#[cfg(feature = "run")]
mod again;
#[cfg(feature = "run")]
mod bench;
mod border;
mod building;
#[cfg(feature = "run")]
mod calibration;
#[cfg(feature = "run")]
mod contest;
#[cfg(feature = "run")]
mod dead_reckoned;
#[cfg(feature = "run")]
mod drive_fit;
#[cfg(feature = "run")]
mod driving;
#[cfg(feature = "run")]
mod edits;
#[cfg(feature = "run")]
mod examine;
#[cfg(feature = "run")]
mod export;
#[cfg(feature = "run")]
mod field;
#[cfg(feature = "files")]
mod files;
#[cfg(feature = "run")]
mod inspection;
#[cfg(feature = "run")]
mod landmarks;
#[cfg(feature = "run")]
mod lesson;
#[cfg(feature = "run")]
mod link;
#[cfg(feature = "run")]
mod live;
#[cfg(feature = "run")]
mod loaded_map;
#[cfg(feature = "cable")]
mod local_bridge;
#[cfg(feature = "run")]
mod offer;
#[cfg(feature = "files")]
mod pose_graph;
#[cfg(feature = "run")]
mod prior_map;
#[cfg(feature = "run")]
mod quality;
#[cfg(feature = "run")]
mod recording;
#[cfg(feature = "lab")]
mod registration;
#[cfg(feature = "run")]
mod rest;
#[cfg(feature = "run")]
mod rooms;
#[cfg(feature = "files")]
mod ros;
#[cfg(feature = "run")]
mod run;
#[cfg(feature = "run")]
mod saved_map;
#[cfg(feature = "run")]
mod settings;
#[cfg(feature = "run")]
mod setup;
#[cfg(feature = "run")]
mod sigma;
#[cfg(feature = "run")]
mod simulation;
#[cfg(feature = "run")]
mod status;
#[cfg(feature = "run")]
mod submaps;
#[cfg(feature = "run")]
mod view;
#[cfg(feature = "files")]
mod world_editor;

#[cfg(feature = "run")]
pub use bench::{BenchResponse, BenchTrial};
pub use border::*;
pub use building::{PriorMapFile, PriorMapSetup};
#[cfg(feature = "run")]
pub use calibration::{Calibration, Pairs, calibrate};
#[cfg(feature = "run")]
pub use contest::{AskError, ContestAsk, ContestState, Entrant, NoPathReason, WebContest};
#[cfg(feature = "run")]
pub use dead_reckoned::DeadReckonedChange;
#[cfg(feature = "run")]
pub use drive_fit::{DriveFit, FittedParameter, PresetFile, read_preset, write_preset};
#[cfg(feature = "run")]
pub use driving::{Cycle, StageWords};
#[cfg(feature = "run")]
pub use export::{ExportError, SavedFile};
#[cfg(feature = "run")]
pub use field::FieldChange;
#[cfg(feature = "files")]
pub use files::{Building, GivenFile, read_building, read_prior_map};
#[cfg(feature = "run")]
pub use inspection::{Candidate, Inspection, LearnedOdometry, Sighting};
#[cfg(feature = "run")]
pub use link::{LinkStart, NoLink, read_link};
#[cfg(feature = "run")]
pub use live::{BridgeMapStatus, BridgeStatus, DeviceStatus, LiveSetup};
#[cfg(feature = "run")]
pub use loaded_map::{LoadedMapPicture, MapAlignment, WebLoadedMap};
#[cfg(feature = "cable")]
pub use local_bridge::{DeviceKindError, LineWant, WebLocalBridge};
#[cfg(feature = "run")]
pub use offer::{DeviceKind, MethodInfo, Offer, SensorInfo, UsbAdapter, offer};
#[cfg(feature = "files")]
pub use pose_graph::{SolvedGraph, solve_graph};
#[cfg(feature = "run")]
pub use quality::{ClosedLoop, Quality, Stretch, Tear, WebJudgement};
#[cfg(feature = "run")]
pub use recording::{ReplaySetup, WebLogReader};
#[cfg(feature = "lab")]
pub use registration::{
    AdvisedMethod, BasinAsk, CloudPair, LabError, MeasuredRow, PairInfo, Registered,
    RegistrationAdvice, RegistrationOffer, WebBasin, WebClouds, builtin_pair, read_point_list,
    registration_offer,
};
#[cfg(feature = "run")]
pub use rest::load_rest;
#[cfg(feature = "run")]
pub use rooms::{Doorway, Region, Rooms};
#[cfg(feature = "files")]
pub use ros::{ImportedLog, OfferedTopic, RosTopics, WebRosReader};
#[cfg(feature = "run")]
pub use run::{Notice, RunError, SourceKind, WebRun};
#[cfg(feature = "run")]
pub use saved_map::{MapStart, SavedMapPicture, TakenOut, WebSavedMap};
#[cfg(feature = "run")]
pub use settings::{PresetInfo, SettingInfo};
#[cfg(feature = "run")]
pub use setup::{Setup, SetupError};
#[cfg(feature = "run")]
pub use sigma::{SigmaBin, SigmaCurve};
#[cfg(feature = "run")]
pub use status::{RunStatus, Task};
#[cfg(feature = "run")]
pub use submaps::Submaps;
#[cfg(feature = "run")]
pub use view::{GridChange, SlamView};

/// A panic is thrown with its message, so the page can say what happened instead of "unreachable
/// executed".
#[cfg(target_arch = "wasm32")]
#[wasm_bindgen::prelude::wasm_bindgen(start)]
fn start() {
    std::panic::set_hook(Box::new(|info| wasm_bindgen::throw_str(&info.to_string())));
}
#[cfg(feature = "files")]
pub use world_editor::{NoSuchWorld, WorldCheck, WorldFault, check_world, world_file};
