// A real robot, behind a bridge or at serial ports of this computer: which one it is, who may drive
// it, and commands other than driving.

import type { Client } from "./client.js";
import { faultOf } from "./fault.js";
import type { LiveSetup } from "./protocol.js";
import { needsPriorMap } from "./protocol/methods.js";
import type { DeviceKind, FenceZone, MethodName, SourceKind } from "./protocol/module.js";
import { SerialPorts } from "./serial_ports.js";
import type { Store } from "./store.js";
import { t } from "./words.js";

/** Wall milliseconds within which Drive is answered. */
const LEASE_MILLIS = 5000;

export class Robot {
  #bridge: { url: string; token: string } | null = null;
  #askedLeaseAt = -Infinity;
  readonly #ports = new SerialPorts((text) => {
    // The mapper gets no more readings.
    this.client.send({ kind: "unplug" });
    this.client.warn(text);
  });

  constructor(private readonly client: Client, private readonly store: Store) {}

  /** Looks up which serial ports this page may already open. */
  prepare(): void {
    void this.#ports.prepare();
  }

  /** A run of this source begins; if it is of another kind, the serial ports are closed. */
  begins(source: SourceKind): void {
    if (source !== "bridge" && this.plugged.length > 0) void this.#ports.forget();
  }

  /** The devices at the serial ports that this page has open. */
  get plugged(): readonly string[] {
    return this.#ports.kinds;
  }

  /** Adds a device at a serial port. The browser asks the person for the port: among those of its
      usual adapters, or among all. */
  async plug(kind: DeviceKind, ofAll: boolean): Promise<void> {
    try {
      await this.#ports.choose(kind, ofAll);
      this.#cable(this.store.setup.method);
    } catch (error) {
      // The person closed the dialog: nothing to report.
      if (error instanceof DOMException && error.name === "NotFoundError") return;
      this.client.warn(t`The port cannot be used: ${faultOf(error).text}`);
    }
  }

  /** Drives the devices at the serial ports. */
  #cable(method: MethodName): void {
    this.client.send({ kind: "unplug" });
    const wire = this.#ports.begin();
    this.client.send({ kind: "cable", wire, ...this.#setup(method) }, [wire]);
  }

  connect(url: string, token: string, method: MethodName = this.store.setup.method): void {
    this.#bridge = { url, token };
    this.client.send({ kind: "connect", url, token, ...this.#setup(method) });
  }

  /** How it is mapped. A bridge has no map to hand out, so without a prior map its robot draws its
      own. */
  #setup(method: MethodName): LiveSetup {
    const { setup: { priorMap, cycle, settings }, tuning: { twin } } = this.store;
    return { method: needsPriorMap(method) && !priorMap ? "line-ekf" : method, priorMap, cycle, settings, twin };
  }

  /** Maps it from here on with this method. `false` if there is no robot. */
  again(method: MethodName): boolean {
    if (this.plugged.length > 0) void this.#ports.again().then(() => this.#cable(method));
    else if (this.#bridge) this.connect(this.#bridge.url, this.#bridge.token, method);
    else return false;
    return true;
  }

  /** Takes the right to drive, or returns it. */
  lease(take: boolean): void {
    this.#askedLeaseAt = take ? performance.now() : -Infinity;
    const driver = this.store.bridge?.driver ?? "";
    this.client.send({ kind: "lease", take, force: driver !== "" });
  }

  /** Whether this page drives it, or is about to: the answer to Drive may be on its way. */
  get mayBeDriven(): boolean {
    const { source, bridge } = this.store;
    const isAsked = performance.now() - this.#askedLeaseAt < LEASE_MILLIS;
    return source === "bridge" && (this.plugged.length > 0 || (bridge?.hasLease ?? false) || isAsked);
  }

  /** Stops the robot at the serial ports directly, bypassing the mapping worker, which may be busy.
      The effect is visible if this page drives the robot; otherwise it is reported. */
  stop(): void {
    this.#ports.stop(false);
    const { source, bridge } = this.store;
    if (source !== "bridge") return;
    if (bridge?.connection !== "open") {
      this.store.set("toast", { toast: { level: "warn", text: "There is no connection: this Stop does not reach the robot. Its bridge stops a robot whose driver is gone." } });
    } else if (!bridge.hasLease) {
      this.store.set("toast", { toast: { level: "good", text: "Stop was sent: the robot stops, whoever drives it." } });
    }
  }

  emergency(on: boolean): void {
    if (on) this.#ports.stop(true);
    this.client.send({ kind: "emergency", on });
  }

  /** Restarts the bridge's own map at the robot's present pose. */
  resetMap(): void {
    this.client.send({ kind: "reset-bridge-map" });
  }

  setGeofence(zones: readonly FenceZone[]): void {
    this.client.send({ kind: "set-geofence", zones: [...zones] });
  }
}
