// Things whose position is known with an uncertainty ellipse: the robot, a corner or a post, a
// walker, and places where the robot may be.

import { HYPOTHESIS, HYPOTHESIS_STRIDE, LANDMARK, LANDMARK_STRIDE, TRACK, TRACK_STRIDE } from "../protocol/module.js";
import { equals, formula, id, op, row, sub } from "../registration/formula.js";
import { fixed, percent } from "../ui/format.js";
import { landmarksOf } from "../view/layers/landmarks.js";
import { CHI2_95, ellipseOf } from "../view/layers/robot.js";
import { tracksOf } from "../view/layers/tracks.js";
import { t } from "../words.js";
import { ellipse, ring } from "./outlines.js";
import { type Figure, type Formula, GONE, type Known, type Told } from "./told.js";
import { angle, metres, number, place } from "./words.js";

/** Half axes of the 95 % ellipse, and their derivation from the covariance. */
function doubt(xx: number, xy: number, yy: number): { figures: Figure[]; formula: Formula; axes: ReturnType<typeof ellipseOf> } {
  const axes = ellipseOf(xx, xy, yy);
  const root = (...inside: Element[]): Element => {
    const made = document.createElementNS("http://www.w3.org/1998/Math/MathML", "msqrt");
    made.append(...inside);
    return made;
  };
  const longest = axes.major ** 2 / CHI2_95;
  const first = (name: string): Element => sub(id(name), number(1));
  return {
    axes,
    figures: [
      ["95 % ellipse", `${metres(axes.major)} × ${metres(axes.minor)}`, "ellipse", "Half axes: it lies within with 95 % probability, if the covariance is honest"],
      ["Longest towards", angle(axes.angle, 0), "ellipse-angle", "Direction of the longer axis, map frame"],
      ["σx, σy", `${metres(Math.sqrt(xx))}, ${metres(Math.sqrt(yy))}`, "sigmas", "Standard deviations"],
    ],
    formula: {
      general: formula(row(first("a"), equals(), root(number(CHI2_95, 4), first("λ")))),
      numbers: formula(row(root(number(CHI2_95, 4), op("·"), number(longest)), equals(), number(axes.major))),
      source: "TDK 2016 § 3.7, with the erratum of the specification; λ₁: the larger eigenvalue of the covariance of x and y, m²; the shorter axis likewise",
    },
  };
}

export function robot({ store, scene }: Known): Told {
  const { status } = scene;
  if (!status) return { title: "The robot", words: GONE, figures: [], outline: [] };
  const { x, y, heading, covXx, covXy, covYy, covHeading, time, truthX, truthY, positionError } = status;
  const about = doubt(covXx, covXy, covYy);
  const title = store.offer.methods.find(({ name }) => name === store.method)?.title ?? store.method;
  // Only a simulator knows the truth, and it is shown only on request.
  const isTruthShown = store.source === "sim" && store.layers.truth && Number.isFinite(truthX);
  const truth: Figure[] = isTruthShown ? [
    ["Truly at", place(truthX, truthY), "robot-truth", "Known to the simulator only"],
    ["Off by", metres(positionError), "robot-error", "Distance between estimate and truth"],
  ] : [];
  return {
    title: "The robot",
    fate: "Estimate",
    words: t`Where ${title} believes it to be at ${fixed(time, 1)} s.`,
    figures: [
      ["x, y", place(x, y), "robot-pose", "Map frame: it begins where the robot did"],
      ["Heading θ", angle(heading), "robot-heading", "From the x axis of the map, to the left"],
      ...about.figures,
      ["σθ", angle(Math.sqrt(covHeading), 2), "robot-heading-sigma", "Standard deviation of the heading"],
      ["By wheels alone", place(status.odometryX, status.odometryY), "robot-odometry", "Dead reckoning"],
      ...truth,
    ],
    formulas: [about.formula],
    outline: [...ring(x, y, Math.hypot(status.halfLength, status.halfWidth)), ...ellipse(x, y, about.axes)],
  };
}

export function point(number_: number, { scene: { landmarks } }: Known): Told {
  const found = landmarksOf(landmarks).findIndex(({ id, kind }) => id === number_ && kind !== "wall");
  const at = (name: keyof typeof LANDMARK): number => landmarks[found * LANDMARK_STRIDE + LANDMARK[name]] ?? NaN;
  if (found < 0) return { title: t`Point ${number_}`, words: GONE, figures: [], outline: [] };
  const [x, y] = [at("x"), at("y")];
  const about = doubt(at("varX"), at("covXy"), at("varY"));
  const isPost = landmarksOf(landmarks)[found]?.kind === "post";
  return {
    title: isPost ? t`Post ${number_}` : t`Corner ${number_}`,
    fate: at("confirmed") ? "Confirmed" : "Not confirmed",
    figures: [
      ["x, y", place(x, y), "point-place", "Map frame"],
      ["Seen", times(at("confidence") + 1), "point-seen", "Its confidence grows by 1 each time it is found again (Pilch 2016 § 3.5.2)"],
      ...about.figures,
      ...(isPost ? [["Radius", metres(at("radius")), "point-radius"] as const] : []),
    ],
    formulas: [about.formula],
    outline: ellipse(x, y, about.axes),
  };
}

export function track(number_: number, { scene: { tracks } }: Known): Told {
  const all = tracksOf(tracks);
  const found = all.findIndex(({ id }) => id === number_);
  const at = (name: keyof typeof TRACK): number => tracks[found * TRACK_STRIDE + TRACK[name]] ?? NaN;
  const motion = all[found]?.motion;
  if (!motion) return { title: t`Track ${number_}`, words: GONE, figures: [], outline: [] };
  const [x, y, vx, vy] = [at("x"), at("y"), at("velocityX"), at("velocityY")];
  const about = doubt(at("varX"), at("covXy"), at("varY"));
  const v = sub(id("v"), id("x"));
  return {
    title: t`Track ${number_}`,
    fate: { new: "New", moving: "Moves", paused: "Pauses", standing: "Stands" }[motion],
    words: at("seen") ? "The last scan saw it. Pose and map do without what it hides." : "The last scan did not see it: this is where it should be by now.",
    figures: [
      ["x, y", place(x, y), "track-place", "Map frame"],
      ["Speed", `${fixed(Math.hypot(vx, vy), 2)} m/s`, "track-speed"],
      ["Towards", angle(Math.atan2(vy, vx), 0), "track-course", "Map frame"],
      ...about.figures,
    ],
    formulas: [about.formula, {
      general: formula(row(id("x"), op("←"), id("x"), op("+"), v, id("Δt"))),
      numbers: formula(row(number(x), op("+"), number(vx), op("·"), id("1"), equals(), number(x + vx))),
      source: "constant velocity, here for 1 s ahead; each track is a Kalman filter",
    }],
    outline: ellipse(x, y, about.axes),
  };
}

export function hypothesis(x: number, y: number, { scene: { hypotheses } }: Known): Told {
  const rows = Array.from({ length: hypotheses.length / HYPOTHESIS_STRIDE }, (_, i) => i);
  const at = (row: number, name: keyof typeof HYPOTHESIS): number => hypotheses[row * HYPOTHESIS_STRIDE + HYPOTHESIS[name]] ?? NaN;
  const away = (row: number): number => Math.hypot(at(row, "x") - x, at(row, "y") - y);
  const nearest = rows.sort((a, b) => away(a) - away(b))[0];
  // They move with the robot; one far from the chosen place is another one.
  if (nearest === undefined || away(nearest) > 1) return { title: "A place where the robot may be", words: GONE, figures: [], outline: [] };
  return {
    title: "A place where the robot may be",
    words: "Particles that hang together: one hypothesis of several.",
    figures: [
      ["x, y", place(at(nearest, "x"), at(nearest, "y")), "hypothesis-place", "Map frame"],
      ["Heading θ", angle(at(nearest, "heading")), "hypothesis-heading"],
      ["Part of the weight", percent(at(nearest, "weight")), "hypothesis-weight", "Of all particles"],
      ["Hypotheses", `${rows.length}`, "hypothesis-count", "Likeliest ones that are shown"],
    ],
    outline: ring(at(nearest, "x"), at(nearest, "y"), 0.4),
  };
}

export function particles({ scene: { particles: all, status } }: Known): Told {
  if (all.length === 0 || !status) return { title: "Particles", words: GONE, figures: [], outline: [] };
  const about = doubt(status.covXx, status.covXy, status.covYy);
  const effective = status.effectiveParticles;
  return {
    title: "Particles",
    words: "Each is a pose that the robot may have; mean and spread of all, by their weights, are the estimate.",
    figures: [
      ["Drawn", `${all.length / 2}`, "particles-count", "At most some hundreds of them"],
      ["Mean", place(status.x, status.y), "particles-place", "Map frame"],
      ...about.figures,
      ...(Number.isFinite(effective) ? [["Effective", fixed(effective, 1), "particles-effective", "So many of equal weight would estimate as well"] as const] : []),
    ],
    formulas: [about.formula],
    outline: ellipse(status.x, status.y, about.axes),
  };
}

export function times(count: number): string {
  return count === 1 ? "once" : t`${count} times`;
}
