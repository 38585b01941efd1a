// The address of the page that a bridge serves, from what somebody typed or scanned.

/** Where a bridge listens that was told nothing else. */
const PORT = "8080";

/** The whole address, with the token if there is one behind its `#`; null where it is none. */
export function pageOf(typed: string): string | null {
  const text = typed.trim();
  const hasScheme = /^[a-z][a-z0-9+.-]*:\/\//i.test(text);
  // The browser takes almost anything for an address.
  if (text === "" || /\s/.test(text)) return null;
  let url: URL;
  try {
    url = new URL((hasScheme ? text : `http://${text}`).replace(/^ws(?=s?:)/i, "http"));
  } catch {
    return null;
  }
  if (!/^https?:$/.test(url.protocol) || url.username !== "" || url.password !== "") return null;
  const isPortSaid = hasScheme || /^(\[[^\]]*\]|[^/?#:]*):\d+/.test(text);
  if (!isPortSaid) url.port = PORT;
  // A bridge's WebSocket stands beside its page.
  if (/^wss?:/i.test(text)) url.pathname = "/";
  return url.href;
}
