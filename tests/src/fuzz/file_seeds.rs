//! Files as written by our writers and by other programs.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions};
use slamlab_core::estimation::{SavedMap, ScanMatcher, ScanMatcherConfig};
use slamlab_core::format::map_server::{MapImage, MapMode, OccupancyMap, write};
use slamlab_core::format::slamlab::{self, Experiment};
use slamlab_core::format::{preset, world};
use slamlab_core::geom::Pose2;
use slamlab_core::points::{PointConfig, Points};
use slamlab_core::robot::{Odometry, Scan, Stamp};
use slamlab_core::sim::worlds;
use slamlab_core::wire::message::Format;
use slamlab_core::wire::recording::{CHANNEL, ENCODING};

use super::seeds;

pub(super) fn calibration() -> Vec<Vec<u8>> {
    vec![
        b"range,volts\n0.2,2.5\n0.4,1.6\n0.6,1.1\n0.8,0.85\n1.0,0.7\n1.2,0.6\n1.5,0.45\n".to_vec(),
        b"0.2;2,5\n0.3;2,0\n".to_vec(),
    ]
}

pub(super) fn poses() -> Vec<Vec<u8>> {
    vec![
        b"1.5 0.1 0.2 0 0 0 0.149 0.988\n2.5 0.1 0.2 0 0 0 0 1\n".to_vec(),
        b"time,x,y,theta\n1.0,0,0,0\n1.1,0.5,0,0.1\n".to_vec(),
        "yaw [°];y (mm);x (mm);t_ms\n90;1500,5;2000;100\n91;1500;2000;200\n"
            .as_bytes()
            .to_vec(),
        b"# stamp\tx\ty\tqx\tqy\tqz\tqw\n1\t0\t0\t0\t0\t0\t1\n".to_vec(),
    ]
}

pub(super) fn point_lists() -> Vec<Vec<u8>> {
    vec![
        b"x,y\n1.0,2.0\n1.1,2.0\n# a wall\n1.2;2.0\n".to_vec(),
        b"0 0\n-1e2\t3\n".to_vec(),
    ]
}

pub(super) fn worlds() -> Vec<Vec<u8>> {
    let named = ["arena", "doors"].into_iter().filter_map(worlds::builtin);
    named
        .map(|built| world::write(&built).into_bytes())
        .collect()
}

pub(super) fn carmen() -> Vec<Vec<u8>> {
    vec![
        b"# a log\nODOM 0.1 0.2 0.3 0.0 0.0 0.0 1.5 host 1.5\nFLASER 4 1.0 1.1 1.2 1.3 0.1 0.2 0.3 0.1 0.2 0.3 1.6 host 1.6\n".to_vec(),
        b"FLASER 2 81.83 0.5 0 0 0 0 0 0 2.0 host 2.0\r\nPARAM robot_width 0.5\n".to_vec(),
    ]
}

/// Three revolutions of an RPLIDAR, across the wrap-around of 16 bits.
pub(super) fn rover_logs() -> Vec<Vec<u8>> {
    let line = |[left, right, millis]: [i32; 3], range: u32| {
        let ranges: String = (0..360)
            .map(|degree| format!(" {}", range + degree % 7))
            .collect();
        format!("{left} {right} {millis}{ranges}\n")
    };
    let text = line([32_760, -32_760, 65_500], 500)
        + "# a comment\n\n"
        + &line([-32_766, 32_766, 146], 510)
        + &line([-32_760, 32_770, 328], 0);
    vec![text.into_bytes()]
}

pub(super) fn ranger_logs() -> Vec<Vec<u8>> {
    vec![
        b"t_s,x_m,y_m,yaw_rad,range0,range1,range2,range3,range4\n10.5,0.014,-0.119,-0.001,0.762,0.627,1.458,2.843,2.407\n10.6,0.02,-0.119,-0.001,0.759,nan,,0,2.4\n".to_vec(),
        b"range3, t_s,x_m,y_m,yaw_rad,range0,range1,range2\r\n1,1e9,2,3,-3.14,1,2,3\r\n".to_vec(),
    ]
}

/// With a sample as the paper prints it, and with other blanks and digits.
pub(super) fn revolution_logs() -> Vec<Vec<u8>> {
    let line = |from: u32| {
        let samples: String = (from..from + 60)
            .map(|k| format!("__t:{}.50_d:0{}.75_q:{}|", 6 * k % 360, 1400 + k, k % 64))
            .collect();
        samples.replacen('_', "S", 1) + "-END-\n"
    };
    vec![
        (line(0) + "# a comment\n\n" + &line(2)).into_bytes(),
        b"S_t:1.34_d:01495.75_q:29|__t: 2 _d:0 _q:0 | -END- \r\n__t:359.98_d:99999.99_q:63|-END-"
            .to_vec(),
    ]
}

pub(super) fn smaps() -> Vec<Vec<u8>> {
    vec![
        b"#points\n3\n-2110.33,-2760.47\n563.693,3974.48\n0,0\n#robot\n2\n0,0\n100,-5.5\n#landmarks\n3\n-2110.33, -2760.47, 5, 0\n563.693, 3974.48, 0, 0\n-5546.09, -3470.07, 2, 1\n".to_vec(),
        b"\r\n#landmarks\r\n0\r\n#points\r\n1\r\n 1e3 , -2e3\r\n#robot\r\n0\r\n".to_vec(),
    ]
}

/// Logs of every kind.
pub(super) fn logs() -> Vec<Vec<u8>> {
    let kinds = [
        carmen(),
        rover_logs(),
        ranger_logs(),
        revolution_logs(),
        recordings(),
    ];
    kinds.into_iter().flatten().collect()
}

pub(super) fn map_yaml() -> Vec<Vec<u8>> {
    vec![
        b"image: map.pgm\nmode: trinary\nresolution: 0.5\norigin: [-1.5, 2, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n".to_vec(),
        b"---\nimage: \"a b.png\" # comment\nresolution: 5e-2\norigin:\n  - 1.0\n  - -2.0\n  - 0.0\nnegate: false\noccupied_thresh: 1\nfree_thresh: 0\nextra: {a: [1, &b 2], c: *b}\n...\n".to_vec(),
    ]
}

fn map() -> OccupancyMap {
    let (width, height) = (24, 16);
    // Walls around a floor, with an unknown corner.
    let cell = |index: usize| {
        let (col, row) = (index % width, index / width);
        match (col, row) {
            (0 | 23, _) | (_, 0 | 15) => 100,
            (19.., 12..) => -1,
            _ => 0,
        }
    };
    OccupancyMap {
        width,
        height,
        resolution: 0.1,
        origin: Pose2::new(-1.0, -0.8, 0.1),
        cells: (0..width * height).map(cell).collect(),
    }
}

fn images(modes: &[MapMode], image: MapImage) -> Vec<Vec<u8>> {
    let written = modes
        .iter()
        .map(|&mode| write(&map(), mode, image, "map").map(|files| files.image));
    written.flatten().collect()
}

pub(super) fn pgm() -> Vec<Vec<u8>> {
    let modes = [MapMode::Trinary, MapMode::Raw];
    let mut seeds = images(&modes, MapImage::Pgm);
    seeds.extend(images(&modes, MapImage::PlainPgm));
    seeds.push(b"P2 # a map\n# of two rows\n2\t2\r\n254\n0 127\n\n254 # end\n 0".to_vec());
    seeds.push(b"P5 2 1 65535 \xff\xff\x00\x00\n".to_vec());
    seeds
}

pub(super) fn png() -> Vec<Vec<u8>> {
    let mut seeds = images(&[MapMode::Trinary, MapMode::Scale], MapImage::Png);
    seeds.push(INTERLACED_PNG.to_vec());
    seeds
}

/// 5 x 3 greys, row k from 10 k on, in seven passes; written by zlib and the passes of the PNG
/// specification, §8.2.
const INTERLACED_PNG: &[u8] = b"\x89PNG\r\n\x1a\n\x00\x00\x00\x0dIHDR\x00\x00\x00\x05\x00\x00\x00\x03\x08\x00\x00\x00\x01\x09\x5a\xaa\xb2\
    \x00\x00\x00\x1eIDAT\x78\xda\x63\x60\x60\x60\x61\x60\x62\x10\x11\x93\x60\x60\x64\x66\x10\x15\x67\xe0\xe2\xe6\xe1\xe5\x03\x00\x06\x38\x00\xb5\xb6\x72\x48\x21\
    \x00\x00\x00\x00IEND\xae\x42\x60\x82";

pub(super) fn drawings() -> Vec<Vec<u8>> {
    vec![
        br##"<?xml version="1.0"?>
<svg xmlns="http://www.w3.org/2000/svg" width="400mm" height="300mm" viewBox="0 0 800 600" data-metres-per-unit="0.01">
 <style>.a{}</style><defs><rect id="d" width="9" height="9"/></defs>
 <g transform="translate(10 20) rotate(5) scale(1.1,.9)" stroke="black" fill="none" style="stroke-width:2">
  <rect x="5" y="5" width="700" height="500" rx="8"/><line x1="300" y1="5" x2="300" y2="300"/>
  <polyline points="10,10 90,80 120 30"/><polygon points="400,100 450,100 450,150"/><use href="#d"/>
  <circle cx="500" cy="300" r="30"/><ellipse cx="600" cy="400" rx="20" ry="10" transform="skewX(3)"/>
  <path d="M100 400h80v-40q20 10 40 0t9,9c1 2 3 4 5 6s7 8 9 1A10 20 30 1 0 250 450l-20-5z" stroke="#123"/>
 </g>
 <circle id="start" cx="200" cy="200" r="5"/><circle id="goal" cx="620" cy="160" r="5"/><text>room &amp; hall</text>
</svg>
"##
        .to_vec(),
        b"<svg><path stroke='white' d='M0 0L9 9'/><rect width='500' height='400'/></svg>".to_vec(),
    ]
}

pub(super) fn og_maps() -> Vec<Vec<u8>> {
    vec![
        b"3 2 0.05 -1.5 2\n0.5 0.1 0.9\n0.5000 1 0\n".to_vec(),
        b"1 1 1e-2 0 0\r\n\r\n0.25\r\n".to_vec(),
    ]
}

pub(super) fn pose_graphs() -> Vec<Vec<u8>> {
    vec![
        b"VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0.1\nVERTEX_SE2 2 1 1 1.6\nFIX 0\n\
          EDGE_SE2 0 1 1 0 0 100 0 0 100 0 400\nEDGE_SE2 1 2 0 1 1.5 100 1 2 100 3 400\n\
          EDGE_SE2 2 0 -1 1 -1.6 50 0 0 50 0 50\n"
            .to_vec(),
        b"# landmarks are left out\r\nVERTEX_XY 7 1 2\r\nVERTEX_SE2 3 1e-3 -2 4 # far\r\n".to_vec(),
    ]
}

pub(super) fn presets() -> Vec<Vec<u8>> {
    let file = preset::PresetFile {
        name: "kitchen".to_owned(),
        settings: [("odometry.left", 0.0123), ("grid.resolution", 0.05)]
            .map(|(key, value)| (key.to_owned(), value))
            .into(),
    };
    let line = preset::FittedLine {
        name: "Left".to_owned(),
        unit: "m".to_owned(),
        value: 0.01,
        sigma: Some(0.001),
        unknown: String::new(),
    };
    vec![
        preset::write(&file, &[]).into_bytes(),
        preset::write(&file, &[line]).into_bytes(),
    ]
}

/// Files of other programs; written by `tests/interop/ros_files.py`.
pub(super) fn ros_files() -> Vec<Vec<u8>> {
    macro_rules! files {
        ($($name:literal),+) => {
            vec![$(include_bytes!(concat!("../../../core/src/format/ros/files/", $name)).to_vec()),+]
        };
    }
    files!("bz2.bag", "lz4.bag", "zstd.mcap", "lz4.mcap", "two.mcap")
}

/// Recordings as the bridge writes them, without chunks, and as other tools rewrite them.
pub(super) fn recordings() -> Vec<Vec<u8>> {
    let whole = WriteOptions::new().use_chunks(false);
    let chunked = WriteOptions::new().use_chunks(true).chunk_size(Some(900));
    [whole, chunked].into_iter().flat_map(recording).collect()
}

fn recording(options: WriteOptions) -> Result<Vec<u8>, McapError> {
    let mut bytes = Cursor::new(vec![]);
    let mut writer = options.compression(None).create(&mut bytes)?;
    let foreign = writer.add_channel(0, "/odom", "cdr", &BTreeMap::new())?;
    let ours = writer.add_channel(0, CHANNEL, ENCODING, &BTreeMap::new())?;
    for (sequence, message) in (1..).zip(seeds::messages(Format::Binary)) {
        for (channel_id, data) in [(ours, message.as_slice()), (foreign, b"\0\x01\0\0")] {
            let time = 1_700_000_000_000_000_000 + 10_000_000 * u64::from(sequence);
            let header = MessageHeader {
                channel_id,
                sequence,
                log_time: time,
                publish_time: time,
            };
            writer.write_to_known_channel(&header, data)?;
        }
    }
    writer.finish()?;
    drop(writer);
    Ok(bytes.into_inner())
}

/// The states of scan matchers in a square room: with a few scans, and with some submaps.
pub(super) fn matcher_states() -> Vec<Vec<u8>> {
    [4, 60].map(matcher_state).into()
}

fn matcher_state(scans: u64) -> Vec<u8> {
    let config = ScanMatcherConfig {
        submap_keyframes: 4,
        overlap_keyframes: 2,
        ..ScanMatcherConfig::default()
    };
    let Ok(mut matcher) = ScanMatcher::new(config) else {
        return vec![];
    };
    for at in 0..scans {
        let stamp = Stamp(200_000 * (at + 1));
        let heading = 0.1 * at as f64;
        matcher.odometry(&Odometry {
            motion: Pose2::new(0.0, 0.0, 0.1),
            from: Stamp(200_000 * at),
            to: stamp,
            ..Odometry::standing(stamp)
        });
        let bearings: Vec<f64> = (0..90).map(|beam| 0.05 * f64::from(beam) - 2.2).collect();
        let range = |bearing: &f64| {
            let (sin, cos) = (heading + bearing).sin_cos();
            (2.0 / cos.abs().max(sin.abs())) as f32
        };
        let scan = Scan {
            stamp,
            robot_from_sensor: Pose2::identity(),
            sigmas: vec![0.01; bearings.len()],
            ranges: bearings.iter().map(range).collect(),
            bearings,
            bearing_sigma: 0.0,
            max_range: 20.0,
            sweep: 0.0,
            qualities: vec![],
        };
        let points = Points::from_scan(&scan, &Pose2::identity(), &PointConfig::default());
        matcher.update(&points, &vec![0.0; points.beams.len()]);
    }
    let mut state = vec![];
    matcher.save(&mut state);
    state
}

pub(super) fn slamlab() -> Vec<Vec<u8>> {
    let of = |state: Vec<u8>| {
        slamlab::write(&Experiment {
            title: "a room".to_owned(),
            map: SavedMap {
                state,
                times: vec![(Stamp(1), 0.5)],
            },
            ..Experiment::default()
        })
    };
    let files = matcher_states().into_iter().map(of);
    files.filter_map(Result::ok).collect()
}
