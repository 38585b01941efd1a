// The bridge that serves this page, and the right to drive its robot.

import { ifAllowed } from "./storage.js";

const TOKEN_KEY = "slamlab-token";

/** What serves this page: a bridge, with or without a robot; a file server (`cargo xtask dist`);
    something else; or nothing that can be reached. */
export type Host = "bridge" | "files" | "other" | "silent";

/** What serves this page, and the address of the WebSocket if that is a bridge with something
    behind it. */
export async function hostOf(where: Location): Promise<{ host: Host; url: string | null }> {
  const nothing = (host: Host) => ({ host, url: null });
  let answer: Response;
  try {
    answer = await fetch("bridge.json", { cache: "no-store" });
  } catch {
    return nothing("silent");
  }
  try {
    // Without the token, a private bridge reveals only that it is a bridge.
    const isPrivate = answer.status === 403;
    const about = answer.ok || isPrivate ? ((await answer.json()) as { websocket?: string; sources?: string[]; static?: boolean }) : null;
    if (about?.static) return nothing("files");
    if (!about?.websocket) return nothing("other");
    if (!isPrivate && !about.sources?.length) return nothing("bridge");
    const url = new URL(about.websocket, where.href);
    url.protocol = url.protocol.replace("http", "ws");
    return { host: "bridge", url: url.href };
  } catch {
    // The server knows nothing of bridges: the page is a standalone laboratory.
    return nothing("other");
  }
}

/** The token stands behind the `#` of the address, a part that browsers never send to the server.
    It is then removed from the address. */
export function tokenOf(where: Location): string {
  const given = new URLSearchParams(where.hash.slice(1)).get("token");
  if (given === null) return ifAllowed(() => sessionStorage.getItem(TOKEN_KEY)) ?? "";
  // Without storage, a reload needs the whole address again.
  ifAllowed(() => sessionStorage.setItem(TOKEN_KEY, given));
  history.replaceState(null, "", where.pathname + where.search);
  return given;
}
