//! Prints `gains.h` of the RP6's firmware: `cargo run -p slamlab-core --example firmware_gains >
//! bridge/firmware/gains.h`.

use slamlab_core::format::firmware_header;
use slamlab_core::robot::RobotModel;

fn main() -> Result<(), firmware_header::HeaderError> {
    print!("{}", firmware_header::write(&RobotModel::rp6())?);
    Ok(())
}
