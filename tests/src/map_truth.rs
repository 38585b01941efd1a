//! How true a saved map is: the picture that the page hands out, against the walls of the world.
//!
//! In: a world, PGM and YAML as `format::map_server` writes them; the map's frame begins where the robot did. Out: [`MapTruth`].
//!
//! 1. Each occupied cell: how far its middle is from the nearest true wall.
//! 2. Each true wall that can be seen from where the robot can be, every 5 cm: whether an occupied cell is near.
//! 3. Of the floor that can be reached or seen: how much of it the map knows.

use nalgebra::{Point2, Vector2};
use slamlab_core::geom::Pose2;
use slamlab_core::sim::{Caster, ReachableArea, World, reachable_area};

/// Nearer than this is at the wall, m: two cells.
const NEAR: f64 = 0.1;
/// Between two places of a wall that are looked at, m.
const SPACING: f64 = 0.05;
/// Of the robot, and of the bitmap of what can be reached, m.
const RADIUS: f64 = 0.11;

/// What of a map is true.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapTruth {
    /// Part of the floor that the map knows, 0 to 1.
    pub explored: f64,
    /// Part of the occupied cells within 10 cm of a true wall.
    pub true_walls: f64,
    /// Mean distance of an occupied cell from the nearest true wall, m.
    pub wall_error: f64,
    /// Part of the walls that are in the map.
    pub found_walls: f64,
}

/// Why a file is no map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MapFileError {
    /// The picture.
    #[error("the picture is no binary PGM with 256 tones: {0}")]
    Pgm(&'static str),
    /// The text beside it.
    #[error("the YAML has no readable `{0}`")]
    Yaml(&'static str),
    /// Nothing is known.
    #[error("no cell is occupied")]
    Empty,
}

struct Picture {
    width: usize,
    height: usize,
    tones: Vec<u8>,
    resolution: f64,
    low: Point2<f64>,
}

/// Compares a map with its world.
///
/// # Errors    [`MapFileError`].
pub fn compare(world: &World, pgm: &[u8], yaml: &str) -> Result<MapTruth, MapFileError> {
    let picture = Picture::read(pgm, yaml)?;
    let caster = Caster::new(world.walls());
    let errors: Vec<f64> = picture
        .occupied()
        .map(|in_map| caster.clearance(world.start * in_map, 2.0))
        .collect();
    if errors.is_empty() {
        return Err(MapFileError::Empty);
    }
    let area = reachable_area(world, RADIUS, SPACING);
    let map_from_world = world.start.inverse();
    let near = errors.iter().filter(|error| **error < NEAR).count();
    Ok(MapTruth {
        explored: area.known_fraction(|at| picture.tone(map_from_world * at).is_some_and(is_known)),
        true_walls: near as f64 / errors.len() as f64,
        wall_error: errors.iter().sum::<f64>() / errors.len() as f64,
        found_walls: found(world, &area, &picture, &map_from_world),
    })
}

fn is_known(tone: u8) -> bool {
    tone != slamlab_core::format::map_server::UNKNOWN
}

fn found(world: &World, area: &ReachableArea, picture: &Picture, map_from_world: &Pose2) -> f64 {
    // What floor in sight ends at can be seen.
    let floor: Vec<Point2<f64>> = area.centres().collect();
    let (mut all, mut seen) = (0_u32, 0_u32);
    for wall in world.walls() {
        let segment = wall.segment;
        let (from, along) = (segment.a, segment.vector());
        let count = (along.norm() / SPACING).ceil().max(1.0);
        for k in 0..=count as u32 {
            let at = from + along * (f64::from(k) / count);
            if !floor.iter().any(|cell| (cell - at).norm() < 2.0 * NEAR) {
                continue;
            }
            all += 1;
            seen += u32::from(picture.is_occupied_near(*map_from_world * at));
        }
    }
    f64::from(seen) / f64::from(all.max(1))
}

impl Picture {
    fn read(pgm: &[u8], yaml: &str) -> Result<Self, MapFileError> {
        let value = |key: &'static str| {
            let line = yaml.lines().find_map(|line| line.strip_prefix(key));
            line.and_then(|rest| rest.strip_prefix(':'))
                .map(str::trim)
                .ok_or(MapFileError::Yaml(key))
        };
        let number = |text: &str, key| text.trim().parse().map_err(|_| MapFileError::Yaml(key));
        let resolution = number(value("resolution")?, "resolution")?;
        let origin = value("origin")?.trim_matches(['[', ']']);
        let mut origin = origin.split(',').map(|text| number(text, "origin"));
        let mut next = || origin.next().unwrap_or(Err(MapFileError::Yaml("origin")));
        let low = Point2::new(next()?, next()?);
        let (width, height, tones) = pgm_parts(pgm)?;
        Ok(Self {
            width,
            height,
            tones: tones.to_vec(),
            resolution,
            low,
        })
    }

    fn tone(&self, in_map: Point2<f64>) -> Option<u8> {
        let at = (in_map - self.low) / self.resolution;
        if at.x < 0.0 || at.y < 0.0 {
            return None;
        }
        let (col, row) = (at.x as usize, at.y as usize);
        (col < self.width && row < self.height)
            .then(|| self.tones[(self.height - 1 - row) * self.width + col])
    }

    fn occupied(&self) -> impl Iterator<Item = Point2<f64>> {
        let middle = |index: usize| {
            let (row, col) = (index / self.width, index % self.width);
            let up = self.height - 1 - row;
            self.low + Vector2::new(col as f64 + 0.5, up as f64 + 0.5) * self.resolution
        };
        self.tones
            .iter()
            .enumerate()
            .filter(|(_, tone)| **tone == slamlab_core::format::map_server::OCCUPIED)
            .map(move |(index, _)| middle(index))
    }

    fn is_occupied_near(&self, in_map: Point2<f64>) -> bool {
        let reach = (NEAR / self.resolution).round() as i32;
        (-reach..=reach).any(|row| {
            (-reach..=reach).any(|col| {
                let by = Vector2::new(f64::from(col), f64::from(row)) * self.resolution;
                self.tone(in_map + by) == Some(slamlab_core::format::map_server::OCCUPIED)
            })
        })
    }
}

/// Columns, rows and tones of a binary PGM.
fn pgm_parts(pgm: &[u8]) -> Result<(usize, usize, &[u8]), MapFileError> {
    let mut rest = pgm;
    let mut words = vec![];
    while words.len() < 4 {
        let end = rest.iter().position(u8::is_ascii_whitespace);
        let end = end.ok_or(MapFileError::Pgm("the head ends early"))?;
        let (word, behind) = rest.split_at(end);
        if word.first() == Some(&b'#') {
            let line = rest.iter().position(|byte| *byte == b'\n').unwrap_or(end);
            rest = &rest[line + 1..];
            continue;
        }
        words.push(String::from_utf8_lossy(word).into_owned());
        rest = &behind[1..];
    }
    let number = |word: &String| word.parse::<usize>().ok();
    match (
        words[0].as_str(),
        number(&words[1]),
        number(&words[2]),
        words[3].as_str(),
    ) {
        ("P5", Some(width), Some(height), "255") if rest.len() == width * height => {
            Ok((width, height, rest))
        }
        _ => Err(MapFileError::Pgm("head and size do not fit")),
    }
}

#[cfg(test)]
mod tests {
    use slamlab_core::sim::worlds;

    use super::*;

    /// The arena as it is, drawn with every wall `shift` metres off to the left.
    fn drawn(shift: f64) -> (World, Vec<u8>, String) {
        let world = worlds::builtin("arena").unwrap();
        let caster = Caster::new(world.walls());
        let (cols, rows) = (120, 100);
        let low = Point2::new(-1.0, -1.0);
        let mut pgm = format!("P5\n# test\n{cols} {rows}\n255\n").into_bytes();
        for row in (0..rows).rev() {
            for col in 0..cols {
                let middle = Vector2::new(f64::from(col) + 0.5, f64::from(row) + 0.5) * 0.05;
                let at = world.start * (low + middle + Vector2::new(shift, 0.0));
                let is_wall = caster.clearance(at, 1.0) < 0.03;
                pgm.push(if is_wall { 0 } else { 254 });
            }
        }
        (
            world,
            pgm,
            "image: a.pgm\nresolution: 0.05\norigin: [-1.0, -1.0, 0]\n".into(),
        )
    }

    #[test]
    fn a_true_map_is_found_true() {
        let (world, pgm, yaml) = drawn(0.0);
        let truth = compare(&world, &pgm, &yaml).unwrap();
        assert!(
            truth.explored > 0.999 && truth.found_walls > 0.999,
            "{truth:?}"
        );
        assert!(
            truth.true_walls > 0.999 && truth.wall_error < 0.03,
            "{truth:?}"
        );
    }

    #[test]
    fn a_map_off_by_a_third_of_a_metre_is_found_out() {
        let (world, pgm, yaml) = drawn(0.33);
        let truth = compare(&world, &pgm, &yaml).unwrap();
        assert!(
            truth.true_walls < 0.7 && truth.wall_error > 0.06,
            "{truth:?}"
        );
        assert!(truth.found_walls < 0.8, "{truth:?}");
    }

    #[test]
    fn what_is_no_map_is_named() {
        let (world, pgm, yaml) = drawn(0.0);
        assert_eq!(
            compare(&world, &pgm[..99], &yaml),
            Err(MapFileError::Pgm("head and size do not fit"))
        );
        assert_eq!(
            compare(&world, &pgm, "x: 1"),
            Err(MapFileError::Yaml("resolution"))
        );
    }
}
