// The reasons why a robot is disarmed, in words, for the pages of one robot and of many.

import type { DisarmReasonName } from "../protocol/module.js";

/** Why the robot does not move. */
export const REASONS: Readonly<Record<DisarmReasonName, string>> = {
  start: "nobody has armed it yet",
  stop: "Stop was pressed",
  "emergency-stop": "the emergency stop was pressed",
  released: "the right to drive was given back",
  "lease-expired": "the driver sent nothing any more",
  "taken-over": "the right to drive was taken over",
  "driver-gone": "the driver disconnected",
  link: "the link to the robot was lost or restarted",
  silence: "the robot has said nothing for half a second",
  bumper: "a bumper was pressed",
  battery: "the battery is nearly empty",
  stall: "the motors ran and the robot did not move",
  runaway: "it moved without a command",
  shutdown: "the bridge ends",
  revoked: "the driver's right was taken away",
  geofence: "it has left its geofence; armed again it goes back in, and no other way",
};
