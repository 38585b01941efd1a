//! Files written by hand, as map_server of ROS 2 takes them; files written and read back; damaged
//! ones.

use nalgebra::Point2;
use proptest::prelude::*;

use super::*;
use crate::map::GridConfig;
use crate::points::fixture::{beam, scan_of};

const YAML: &str = "image: map.pgm\nresolution: 0.5\norigin: [-1.5, 2, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";

fn small_grid() -> Grid {
    let mut grid = Grid::new(GridConfig {
        resolution: 0.5,
        ..GridConfig::default()
    })
    .unwrap();
    let (from, to) = (Point2::new(0.25, 0.25), Point2::new(0.25, 1.25));
    let points = scan_of([beam(0, from, to, true)]);
    for _ in 0..4 {
        grid.insert(&points, &Pose2::identity());
    }
    grid
}

fn cells(yaml: &str, image: &[u8]) -> Vec<i8> {
    read(yaml.as_bytes(), image).unwrap().cells
}

fn message(yaml: &str, image: &[u8]) -> String {
    read(yaml.as_bytes(), image).unwrap_err().to_string()
}

#[test]
fn top_row_of_the_image_is_the_top_of_the_map() {
    let map = OccupancyMap::of_grid(&small_grid(), MapMode::Trinary).unwrap();
    assert_eq!(
        (map.width, map.height, map.cells.as_slice()),
        (1, 3, &[0, 0, 100][..])
    );
    let files = write(&map, MapMode::Trinary, MapImage::Pgm, "map.pgm").unwrap();
    assert!(files.image.ends_with(&[OCCUPIED, FREE, FREE]));
    assert!(files.image.starts_with(b"P5\n"));
    assert!(files.yaml.contains("image: map.pgm\n") && files.yaml.contains("resolution: 0.5\n"));
    assert!(files.yaml.contains("origin: [0.000000, 0.000000, 0]"));
    assert_eq!(read(files.yaml.as_bytes(), &files.image), Ok(map));
}

#[test]
fn probabilities_of_a_grid_are_percentages() {
    let map = OccupancyMap::of_grid(&small_grid(), MapMode::Raw).unwrap();
    // Four hits of 0.7 and four misses of 0.4: odds (7/3)⁴ and (2/3)⁴.
    assert_eq!(map.cells, [16, 16, 97]);
}

#[test]
fn an_empty_map_is_refused() {
    let grid = Grid::new(GridConfig::default()).unwrap();
    for (_, mode) in MapMode::ALL {
        assert_eq!(
            OccupancyMap::of_grid(&grid, mode),
            Err(MapServerError::Empty)
        );
    }
}

/// What nav2's `loadMapFromFile` makes of each grey, worked out by hand from its source.
#[test]
fn greys_mean_what_they_mean_to_map_server() {
    let image = b"P5 6 1 255\n\x00\x59\x7f\xcd\xfe\xff";
    let lower_free = YAML.replace("0.196", "0.25");
    for (yaml, meant) in [
        // 0x59 = 89: p = 0.651; 0x7f: p = 0.502; 205: p = 0.19608.
        (YAML.to_owned(), [100, 100, -1, -1, 0, 0]),
        (lower_free, [100, 100, -1, 0, 0, 0]),
        (format!("{YAML}mode: trinary"), [100, 100, -1, -1, 0, 0]),
        (
            YAML.replace("negate: 0", "negate: 1"),
            [0, -1, -1, 100, 100, 100],
        ),
        // (0.50196 - 0.196) / 0.454 = 0.674 and (0.19608 - 0.196) / 0.454 = 0.0002.
        (format!("{YAML}mode: scale"), [100, 100, 67, 0, 0, 0]),
        (format!("{YAML}mode: raw"), [0, 89, -1, -1, -1, -1]),
    ] {
        assert_eq!(cells(&yaml, image), meant, "{yaml}");
    }
}

#[test]
fn colours_are_averaged_and_opacity_counts_as_map_server_has_it() {
    let png = |color, samples: &[u8]| {
        let mut bytes = vec![];
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(color);
        encoder
            .write_header()
            .unwrap()
            .write_image_data(samples)
            .unwrap();
        bytes
    };
    // Mean of 0, 0, 255: p = 2/3.
    let rgb = png(png::ColorType::Rgb, &[0, 0, 255, 255, 255, 255]);
    assert_eq!(cells(YAML, &rgb), [100, 0]);
    // Invisible black: trinary counts (0 + 0 + 0 + 1)/4 for opaque black, 0 for transparent black.
    let rgba = png(png::ColorType::Rgba, &[0, 0, 0, 255, 255, 255, 255, 254]);
    assert_eq!(cells(YAML, &rgba), [100, 0]);
    assert_eq!(cells(&format!("{YAML}mode: scale"), &rgba), [100, -1]);
    let mut half = vec![];
    let mut encoder = png::Encoder::new(&mut half, 9, 1);
    encoder.set_depth(png::BitDepth::One);
    encoder
        .write_header()
        .unwrap()
        .write_image_data(&[0b0101_0101, 0b1000_0000])
        .unwrap();
    assert_eq!(cells(YAML, &half), [100, 0, 100, 0, 100, 0, 100, 0, 0]);
}

#[test]
fn plain_and_deep_images_are_read() {
    let map = read(
        YAML.as_bytes(),
        b"P2 # a map\n# of two rows\n2\t2\r\n254\n0 127\n\n254 # end\n 0",
    )
    .unwrap();
    assert_eq!(map.cells, [0, 100, 100, -1]);
    assert_eq!(
        (map.origin.x(), map.origin.y(), map.resolution),
        (-1.5, 2.0, 0.5)
    );
    assert_eq!(cells(YAML, b"P5 2 1 65535 \xff\xff\x00\x00\n"), [0, 100]);
}

#[test]
fn the_image_lies_beside_the_yaml_and_may_be_turned() {
    let yaml = YAML
        .replace(", 0]", ", 1.5]")
        .replace("map.pgm", "\"rooms/my map.png\"");
    let info = MapInfo::parse(yaml.as_bytes()).unwrap();
    assert!((info.origin.heading() - 1.5).abs() < 1e-12);
    assert_eq!(
        info.image_beside(Path::new("a/b/map.yaml")),
        Path::new("a/b/rooms/my map.png")
    );
    assert_eq!(
        info.image_beside(Path::new("map.yaml")),
        Path::new("rooms/my map.png")
    );
    let whole = MapInfo {
        image: "/maps/x.pgm".to_owned(),
        ..info
    };
    assert_eq!(
        whole.image_beside(Path::new("a/map.yaml")),
        Path::new("/maps/x.pgm")
    );
    let blocks = "origin:\n  - 1.0\n  - -2.0\n  - 0.0\nimage: x.png # comment\nresolution: 5e-2\nnegate: false\noccupied_thresh: 1\nfree_thresh: 0\nextra: {a: [1, {b: 2}]}\n---\nimage: other";
    let info = MapInfo::parse(blocks.as_bytes()).unwrap();
    assert_eq!(
        (info.image.as_str(), info.origin.y(), info.resolution),
        ("x.png", -2.0, 0.05)
    );
}

#[test]
fn bad_yaml_is_told_what_where_and_what_was_expected() {
    let image = b"P5 1 1 255 \x00";
    for key in [
        "image",
        "resolution",
        "origin",
        "negate",
        "occupied_thresh",
        "free_thresh",
    ] {
        let without: String = YAML
            .lines()
            .filter(|line| !line.starts_with(key))
            .map(|line| format!("{line}\n"))
            .collect();
        assert_eq!(
            message(&without, image),
            format!("the map's YAML: the key `{key}` is missing")
        );
    }
    for (from, to, expect) in [
        (
            "0.5",
            "0",
            "line 2: resolution is `0`, expected more than 0 and at most 1000 m",
        ),
        ("0.5", "-0.05", "line 2: resolution is `-0.05`"),
        ("0.5", ".nan", "line 2: resolution is `.nan`"),
        ("0.5", "NaN", "line 2: resolution is `NaN`"),
        ("0.5", "[0.5]", "line 2: resolution is `[0.5]`"),
        (
            "[-1.5, 2, 0]",
            "[-1.5, 2]",
            "line 3: origin is `[-1.5, 2]`, expected a list [x, y, yaw]",
        ),
        ("[-1.5, 2, 0]", "[-1.5, inf, 0]", "line 3: origin is"),
        ("[-1.5, 2, 0]", "1", "line 3: origin is `1`"),
        (
            "negate: 0",
            "negate: 2",
            "line 4: negate is `2`, expected 0 or 1",
        ),
        (
            "0.196",
            "1.5",
            "line 6: free_thresh is `1.5`, expected from 0 to 1",
        ),
        ("map.pgm", "''", "line 1: image is ``"),
        (
            "negate: 0",
            "negate: 0\nmode: colour",
            "line 5: mode is `colour`, expected trinary, scale or raw",
        ),
        (
            "negate: 0",
            "image: b",
            "line 4: the key is `image`, expected each key once",
        ),
        ("negate: 0", "negate: *x", "line 4:"),
        ("negate: 0", "negate: &a 0\nb: *a", "line 5: an alias"),
        ("negate: 0", "negate: [", "line"),
    ] {
        let found = message(&YAML.replacen(from, to, 1), image);
        assert!(
            found.starts_with(&format!("the map's YAML: {expect}")),
            "{found}"
        );
    }
    assert!(message("just words", image).contains("line 1: expected keys with values"));
    assert!(message("", image).starts_with("the map's YAML: "));
    assert!(message(&"- ".repeat(30_000), image).contains("line 1: expected keys"));
    assert!(message(&"a: ".repeat(40_000), image).contains("120000 bytes, expected at most 65536"));
    assert!(!message(&format!("a: {}", "[".repeat(60_000)), image).is_empty());
}

#[test]
fn bad_images_are_told_what_is_wrong() {
    let error = |image: &[u8]| message(YAML, image);
    assert!(error(b"").contains("neither PGM (P2, P5) nor PNG"));
    assert!(error(b"P6 1 1 255 abc").contains("it begins with \"P6 1 1 2\""));
    assert!(error(b"P5 x 1 255 a").contains("the PGM's width is `x`, expected a whole number"));
    assert!(
        error(b"P5 1 1 0 a")
            .contains("largest grey is `0`, expected a whole number from 1 to 65535")
    );
    assert!(error(b"P5 0 4 255 ").contains("0 x 4 pixels, expected at least one"));
    assert!(
        error(b"P5 4000000000 4000000000 255 ")
            .contains("expected at least one and at most 100000000")
    );
    assert!(error(b"P5 18446744073709551615 3 255 ").contains("at most 100000000"));
    // The header promises 100 million pixels and none follows: no memory is allocated for them.
    assert!(
        error(b"P5 10000 10000 255\nab")
            .contains("promises 10000 x 10000 pixels, the file holds 2")
    );
    assert!(error(b"P2 10000 10000 255\n1 2").contains("the file holds 2"));
    assert!(error(b"P5 1 1 255\nabc").contains("the file holds 2 bytes more"));
    assert!(error(b"P2 1 1 255\n1 2").contains("the file holds more"));
    assert!(
        error(b"P2 1 1 15\n16").contains("pixel 0 is `16`, expected a whole number from 0 to 15")
    );
    let map = OccupancyMap::of_grid(&small_grid(), MapMode::Trinary).unwrap();
    let png = write(&map, MapMode::Trinary, MapImage::Png, "map.png")
        .unwrap()
        .image;
    assert!(error(&png[..png.len() - 20]).contains("the PNG cannot be read"));
    // A header of 10 000 x 10 000 pixels with a correct checksum, followed by next to nothing.
    let mut bomb = vec![];
    png::Encoder::new(&mut bomb, 10_000, 10_000)
        .write_header()
        .unwrap();
    assert!(
        error(&bomb).contains("the header promises 10000 x 10000 pixels"),
        "{}",
        error(&bomb)
    );
}

/// 5 x 3 greys in seven passes (PNG specification, §8.2), written by Python's zlib.
const INTERLACED: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\0\x05\0\0\0\x03\x08\0\0\0\x01\x09\x5a\xaa\xb2\
    \0\0\0\x1eIDAT\x78\xda\x63\x60\x60\x60\x61\x60\x62\x10\x11\x93\x60\x60\x64\x66\x10\x15\x67\xe0\xe2\xe6\xe1\xe5\x03\0\x06\x38\0\xb5\xb6\x72\x48\x21\
    \0\0\0\0IEND\xae\x42\x60\x82";

#[test]
fn interlaced_images_are_put_together() {
    let raw = format!("{YAML}mode: raw");
    let expect = [20, 21, 22, 23, 24, 10, 11, 12, 13, 14, 0, 1, 2, 3, 4];
    assert_eq!(cells(&raw, INTERLACED), expect);
}

#[test]
fn an_interlaced_image_that_would_fill_the_memory_is_refused() {
    // A header alone: 9000 x 9000 greys, and enough bytes that they could be there.
    let mut image = INTERLACED[..12].to_vec();
    let mut header = b"IHDR".to_vec();
    header.extend(9000_u32.to_be_bytes().repeat(2));
    header.extend([8, 0, 0, 0, 1]);
    let sum = |bytes: &[u8]| {
        crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC)
            .checksum(bytes)
            .to_be_bytes()
    };
    image.extend_from_slice(&header);
    image.extend(sum(&header));
    let mut data = b"IDAT".to_vec();
    data.resize(100_000, 0);
    image.extend((data.len() as u32 - 4).to_be_bytes());
    image.extend_from_slice(&data);
    image.extend(sum(&data));
    assert!(message(YAML, &image).contains("interlaced and larger than 67108864 bytes"));
}

#[test]
fn what_cannot_be_written_is_refused() {
    let mut map = OccupancyMap::of_grid(&small_grid(), MapMode::Raw).unwrap();
    assert_eq!(
        write(&map, MapMode::Scale, MapImage::Pgm, "a"),
        Err(MapServerError::NeedsPng)
    );
    map.width = 2;
    let error = write(&map, MapMode::Raw, MapImage::Pgm, "a").unwrap_err();
    assert_eq!(error.to_string(), "the map has 3 cells, expected 2 x 3");
}

fn maps() -> impl Strategy<Value = OccupancyMap> {
    (1_usize..40, 1_usize..12, -3.0..3.0_f64).prop_flat_map(|(width, height, yaw)| {
        proptest::collection::vec(-1..=100_i8, width * height).prop_map(move |cells| OccupancyMap {
            width,
            height,
            resolution: 0.05,
            origin: Pose2::new(-12.25, 3.5, yaw),
            cells,
        })
    })
}

proptest! {
    #[test]
    fn what_is_written_is_read_back(map in maps()) {
        let files = [MapImage::Pgm, MapImage::PlainPgm, MapImage::Png];
        let pairs = MapMode::ALL.into_iter().flat_map(|(_, mode)| files.map(|file| (mode, file)));
        for (mode, file) in pairs.filter(|pair| !matches!(pair, (MapMode::Scale, MapImage::Pgm | MapImage::PlainPgm))) {
            let mut map = map.clone();
            if mode == MapMode::Trinary {
                for cell in &mut map.cells {
                    *cell = match *cell { 66..=100 => 100, 0..=19 => 0, _ => -1 };
                }
            }
            let files = write(&map, mode, file, "a.map").unwrap();
            let back = read(files.yaml.as_bytes(), &files.image).unwrap();
            prop_assert_eq!(&back.cells, &map.cells, "{:?} {:?}", mode, file);
            prop_assert_eq!((back.width, back.height, back.resolution), (map.width, map.height, map.resolution));
            prop_assert!((back.origin.heading() - map.origin.heading()).abs() < 1e-12);
            prop_assert_eq!(back.origin.position(), map.origin.position());
        }
    }

    #[test]
    fn damaged_files_never_panic(
        map in maps(), file in 0_usize..3,
        edits in proptest::collection::vec((0.0..1.0_f64, 0_u8..4, any::<u8>()), 1..6),
    ) {
        let kind = [MapImage::Pgm, MapImage::PlainPgm, MapImage::Png][file];
        let files = write(&map, MapMode::Raw, kind, "a.map").unwrap();
        let mut both = [files.yaml.clone().into_bytes(), files.image.clone()];
        for (index, (place, kind, byte)) in edits.into_iter().enumerate() {
            let bytes = &mut both[index % 2];
            let at = (bytes.len() as f64 * place) as usize;
            match kind {
                0 => bytes.truncate(at),
                1 => bytes.insert(at, byte),
                2 if at < bytes.len() => bytes[at] = byte,
                _ if at < bytes.len() => { bytes.remove(at); }
                _ => {}
            }
        }
        for (yaml, image) in [(files.yaml.as_bytes(), &both[1]), (&both[0], &files.image)] {
            match read(yaml, image) {
                Ok(map) => prop_assert_eq!(map.cells.len(), map.width * map.height),
                Err(error) => prop_assert!(!error.to_string().is_empty()),
            }
        }
    }
}
