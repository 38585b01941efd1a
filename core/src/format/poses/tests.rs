use std::f64::consts::{FRAC_PI_2, PI};

use super::*;
use crate::geom::{Length, wrap};
use proptest::prelude::*;

fn check(text: &str, expected: &[(f64, [f64; 3])]) {
    let read = read_poses(text.as_bytes()).unwrap_or_else(|error| panic!("{text}: {error}"));
    assert_eq!(read.poses.len(), expected.len(), "{text}");
    for ((seconds, pose), (at, [x, y, heading])) in read.poses.iter().zip(expected) {
        assert!((seconds - at).abs() < 1e-6, "{text}: {seconds}");
        let off =
            (pose.x() - x).abs() + (pose.y() - y).abs() + wrap(pose.heading() - heading).abs();
        assert!(off < 1e-9, "{text}: {pose:?}");
    }
}

fn refuse(text: &str, words: &str) {
    let error = read_poses(text.as_bytes()).unwrap_err().to_string();
    assert!(error.contains(words), "{text}: {error}");
}

#[test]
fn lines_of_eight_numbers_are_tum_by_definition_of_the_quaternion() {
    // A rotation by θ about z is (0, 0, sin θ/2, cos θ/2).
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let [sin, cos] = [half; 2];
    let text = format!(
        "# timestamp tx ty tz qx qy qz qw\n1.5 2 3 9 0 0 {sin} {cos}\n\n2 0 0 0 0 0 0 1 # end\n"
    );
    check(&text, &[(1.5, [2.0, 3.0, FRAC_PI_2]), (2.0, [0.0; 3])]);
    check("1 2 3 0 0 0 1 0\n", &[(1.0, [2.0, 3.0, PI])]);
}

#[test]
fn columns_are_known_by_name_in_any_order_with_any_separator_and_unit() {
    let one = [(1.5, [2.0, -3.0, FRAC_PI_2])];
    check("time,x,y,theta\n1.5,2,-3,1.5707963267948966\n", &one);
    check("theta_deg;y;x;time_ms\n90;-3;2;1500\n", &one);
    check(
        "Heading [°]\tY (mm)\tbattery\tX (mm)\tt_us\n90\t-3000\tfull\t2000\t1500000\n",
        &one,
    );
    check("# stamp, x, y, yaw (deg)\n1.5, 2, -3, 90\n", &one);
    check("t_ns x_cm y_cm yaw_deg\n1500000000 200 -300 90\n", &one);
    check(
        "\u{feff}\"time\",\"x\",\"y\",\"yaw_deg\"\r\n\"1.5\",2,-3,90\r\n",
        &one,
    );
    // A comma is a decimal point where it is not the separator.
    check("time;x;y;yaw_deg\n1,5;2,0;-3,0;90\n", &one);
    check(
        "time,x,y,z,qx,qy,qz,qw\n1.5,2,-3,0,0,0,0.70710678118654757,0.70710678118654757\n",
        &one,
    );
}

#[test]
fn what_is_wrong_is_named_with_line_and_field() {
    refuse("", "no pose in 0 lines");
    refuse("# nothing\n\n", "no pose in 2 lines");
    refuse("time,x,y,theta\n", "no pose in 1 lines");
    refuse("time,x,y\n1,2,3\n", "line 1: the line is `time,x,y`");
    refuse(
        "1,2,3,0\n",
        "line 1: the line is `1,2,3,0`, expected a header",
    );
    refuse("1 2 3\n", "line 1: the line");
    refuse(
        "time,x,y,theta\n1,2,3\n",
        "line 2: the number of fields is `3`, expected 4: time, x, y, theta",
    );
    refuse(
        "time,x,y,theta\n1,2,3,4,5\n",
        "line 2: the number of fields is `5`",
    );
    refuse(
        "time,x,y,theta\n1,2,NaN,4\n",
        "line 2: field 3 (y) is `NaN`",
    );
    refuse(
        "time,x,y,theta\n1,2,inf,4\n",
        "line 2: field 3 (y) is `inf`",
    );
    refuse("time,x,y,theta\n1,2,,4\n", "line 2: field 3 (y) is ``");
    refuse("time,x,y,theta\n1,1e300,0,4\n", "line 2: field 2 (x)");
    refuse(
        "time,x,y,theta\n2,0,0,0\n\n1,0,0,0\n",
        "line 4: the time is `1`, expected 2 or later",
    );
    refuse(
        "1 0 0 0 0 0 0 0\n",
        "line 1: the length of the quaternion is `0.000`",
    );
    refuse("1 2 3 4 5 6 7 inf\n", "line 1: field 8 (qw) is `inf`");
    refuse(
        "1 0 0 0 0 0 0 1\n1 2\n",
        "line 2: the number of fields is `2`",
    );
    // Nanoseconds in a column without a unit.
    refuse(
        "time,x,y,theta\n1403636579763555584,0,0,0\n",
        "line 2: field 1 (time)",
    );
    refuse("time_parsec,x,y,theta\n1,0,0,0\n", "line 1: the line");
}

#[test]
fn of_two_poses_at_one_time_the_first_counts_and_the_other_is_told() {
    let read = read_poses(b"time,x,y,theta\n1,0,0,0\n1,5,0,0\n2,6,0,0\n").unwrap();
    assert_eq!(read.repeated, 1);
    assert_eq!(read.poses[0].1.x(), 0.0);
    assert_eq!(read.poses.len(), 2);
}

proptest! {
    #[test]
    fn a_table_reads_back_whatever_the_order_separator_and_units(
        rows in prop::collection::vec((1e-3..10.0_f64, -1e3..1e3_f64, -1e3..1e3_f64, -4.0..4.0_f64), 1..20),
        order in Just([0_usize, 1, 2, 3]).prop_shuffle(),
        separator in prop::sample::select(vec![",", ";", "\t", " "]),
        in_degrees: bool,
        in_millis: bool,
    ) {
        let names = [
            if in_millis { "time_ms" } else { "time" }, "x", "y", if in_degrees { "yaw_deg" } else { "yaw" },
        ];
        let line = |cells: [String; 4]| order.map(|i| cells[i].clone()).join(separator) + "\n";
        let mut text = line(names.map(str::to_owned));
        let (mut seconds, mut written) = (0.0, vec![]);
        for (after, x, y, heading) in rows {
            seconds += after;
            written.push((seconds, Pose2::new(x, y, heading)));
            let time = if in_millis { 1e3 * seconds } else { seconds };
            let angle = if in_degrees { heading.to_degrees() } else { heading };
            text += &line([time, x, y, angle].map(|n| n.to_string()));
        }
        let back = read_poses(text.as_bytes()).unwrap();
        prop_assert_eq!(back.poses.len() + back.repeated, written.len());
        for ((at, pose), (seconds, wrote)) in back.poses.iter().zip(&written) {
            prop_assert!((at - seconds).abs() < 1e-9);
            prop_assert!((pose.position() - wrote.position()).length() < 1e-9);
            prop_assert!(wrap(pose.heading() - wrote.heading()).abs() < 1e-9);
        }
    }

    #[test]
    fn whatever_comes_times_rise_and_all_is_finite(text in "[-0-9.,; \tnaeitxymsq#\n]{0,120}") {
        if let Ok(read) = read_poses(text.as_bytes()) {
            prop_assert!(!read.poses.is_empty());
            prop_assert!(read.poses.windows(2).all(|pair| pair[0].0 < pair[1].0));
            prop_assert!(read.poses.iter().all(|(t, p)| t.is_finite() && p.x().is_finite() && p.y().is_finite() && p.heading().is_finite()));
        }
    }
}
