//! Prints `gains.h` of the RP6's firmware: `cargo run -p slamlab-core --example firmware_gains >
//! bridge/firmware/gains.h`.

use slamlab_core::format::firmware_header;
use slamlab_core::robot::RobotModel;
use slamlab_core::robot::controller::ControllerConfig;

fn main() -> Result<(), firmware_header::HeaderError> {
    let model = RobotModel::rp6();
    let header = firmware_header::write(&model, &ControllerConfig::default())?;
    print!("{header}");
    Ok(())
}
