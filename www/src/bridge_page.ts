// Finds the address of the page that a bridge serves, from text that was typed or scanned.

/** A bridge's default port. */
const PORT = "8080";

/** The whole address, with the token behind its `#` if there is one; null if it is none. */
export function pageOf(typed: string): string | null {
  const text = typed.trim();
  const hasScheme = /^[a-z][a-z0-9+.-]*:\/\//i.test(text);
  // Browsers accept almost any text as an address.
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
  // A bridge's WebSocket has the same host as its page.
  if (/^wss?:/i.test(text)) url.pathname = "/";
  return url.href;
}
