//! Errors that cross to the page: a kind, for the code that handles it, and a sentence, for people.

use js_sys::{Error, Reflect};
use wasm_bindgen::JsValue;

use super::names::names;

names! {
    /// What an error is about.
    ErrorKind {
        /* A run cannot begin so. */ Setup = "setup",
        /* A setting cannot be so. */ Setting = "setting",
        /* A file that was given cannot be read. */ File = "file",
        /* It may be a recording of ROS, which another module reads. */ Ros = "ros",
        /* Something asked of the run cannot be answered. */ Question = "question",
        /* There is nothing to save. */ Save = "save",
        /* The connection is of no use any more. */ Connection = "connection",
        /* A fault of the program. */ Internal = "internal",
    }
}

/// Why something was not done. It is thrown as an `Error` with the sentence as its message and the
/// kind's name as its `kind`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WebError {
    /// What it is about.
    pub kind: ErrorKind,
    /// The sentence.
    pub text: String,
}

impl From<WebError> for JsValue {
    fn from(error: WebError) -> Self {
        let thrown = Error::new(&error.text);
        let kind = error.kind.name();
        // A new object takes any property; if it ever did not, the sentence would still arrive.
        let _ = Reflect::set(&thrown, &"kind".into(), &kind.into());
        thrown.into()
    }
}

/// The kind of each error: the core's errors are listed here, those of these bindings where they
/// are defined.
macro_rules! kinds {
    ($($kind:ident: $($error:path),+;)+) => { $($(
        impl From<$error> for $crate::border::WebError {
            fn from(error: $error) -> Self {
                Self { kind: $crate::border::ErrorKind::$kind, text: error.to_string() }
            }
        }
    )+)+ };
}
pub(crate) use kinds;

kinds! {
    Setup: slamlab_core::experiment::ExperimentError, slamlab_core::experiment::LinkError, slamlab_core::live::LiveError,
        slamlab_core::replay::ReplayError, slamlab_core::sim::UnknownSensor;
    Setting: slamlab_core::settings::SettingError;
    File: slamlab_core::replay::ImportError, slamlab_core::format::ros::RosError, slamlab_core::format::building::BuildingError, slamlab_core::format::building::BuildingFileError, slamlab_core::format::calibration::CalibrationFileError,
        slamlab_core::format::g2o::G2oError, slamlab_core::format::poses::PosesError, slamlab_core::replay::PosesMisfit, slamlab_core::format::map_points::LoadedMapError, slamlab_core::format::point_list::PointListError, slamlab_core::format::preset::PresetFileError, slamlab_core::format::world::WorldFileError,
        slamlab_core::estimation::MapMergeError, slamlab_core::estimation::RestoreError, slamlab_core::format::slamlab::SlamlabError;
    Question: slamlab_core::robot::controller::DesignError, slamlab_core::plan::ContestError, slamlab_core::registration::CloudError, slamlab_core::points::SigmaError, slamlab_core::sim::Blocked, slamlab_core::sim::NoDoor,
        slamlab_core::estimation::MapAlignmentError, slamlab_core::experiment::AgainError, slamlab_core::geom::geofence::GeofenceError;
    Save: slamlab_core::format::floor_plan::FloorPlanError,
        slamlab_core::format::map_server::MapServerError, slamlab_core::format::rooms::NoRooms,
        slamlab_core::format::smap::SmapError;
    Connection: slamlab_core::wire::client::ClientError;
    Internal: slamlab_core::slam::SlamError, tsify::Error;
}

impl From<slamlab_core::replay::LogError> for WebError {
    fn from(error: slamlab_core::replay::LogError) -> Self {
        let kind = match error.is_of_ros() {
            true => ErrorKind::Ros,
            false => ErrorKind::File,
        };
        let text = error.to_string();
        Self { kind, text }
    }
}
