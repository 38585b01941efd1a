// The bridge that serves this page, and the right to drive its robot.

import { ifAllowed } from "./storage.js";

const TOKEN_KEY = "slamlab-token";

/** Address of the WebSocket of the bridge that serves this page; null where none does, or nothing
    is behind it. */
export async function bridgeAddress(where: Location): Promise<string | null> {
  try {
    const answer = await fetch("bridge.json", { cache: "no-store" });
    // A bridge that shows nothing without the token says no more than that it is one.
    const isPrivate = answer.status === 403;
    const about = answer.ok || isPrivate ? ((await answer.json()) as { websocket?: string; sources?: string[] }) : null;
    if (!about?.websocket || (!isPrivate && !about.sources?.length)) return null;
    const url = new URL(about.websocket, where.href);
    url.protocol = url.protocol.replace("http", "ws");
    return url.href;
  } catch {
    // A server that knows nothing of bridges: the page is a laboratory of its own.
    return null;
  }
}

/** The token stands behind the `#` of the address, which no server ever sees; it is removed from
    there. */
export function tokenOf(where: Location): string {
  const given = new URLSearchParams(where.hash.slice(1)).get("token");
  if (given === null) return ifAllowed(() => sessionStorage.getItem(TOKEN_KEY)) ?? "";
  // Without storage a reload needs the whole address again.
  ifAllowed(() => sessionStorage.setItem(TOKEN_KEY, given));
  history.replaceState(null, "", where.pathname + where.search);
  return given;
}
