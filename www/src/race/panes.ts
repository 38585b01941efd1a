// The layout of the maps of runs side by side: all of one size, so that the same view fits each.

/** The page's style while runs are shown side by side. */
const SHEET = `
  body[data-race] #maps { bottom: 142px; display: grid; gap: 3px; grid: minmax(0, 1fr) / repeat(2, minmax(0, 1fr)); --foot: 12px; --foot-top: 46px; background: var(--line-strong); }
  body[data-race="3"] #maps, body[data-race="4"] #maps { grid: repeat(2, minmax(0, 1fr)) / repeat(2, minmax(0, 1fr)); }
  body[data-race] #maps > * { position: relative; min-width: 0; min-height: 0; overflow: hidden; background: var(--page); }
  body[data-race][data-cycle] #maps { bottom: 256px; }
  body[data-race]:not([data-tab="layers"]) #legend { display: none; }
  body[data-race="3"] #maps::after { content: ""; background: var(--page); }
  body[data-race] #legend { top: 52px; z-index: 2; max-height: calc(100% - 220px); }
  @media (min-width: 1900px) {
    body[data-race="3"] #maps::after { display: none; }
    body[data-race="3"] #maps { grid: minmax(0, 1fr) / repeat(3, minmax(0, 1fr)); }
  }
  @media (max-width: 760px) {
    /* A narrow map has room for the name only; the figures stand under Plots. */
    body[data-race="3"] #maps, body[data-race="4"] #maps { --chip-now: none; }
    body[data-race] #legend { top: auto; max-height: 60%; z-index: 4; }
    body[data-race] #maps { bottom: var(--dock); }
    body[data-race="2"] #maps { grid: repeat(2, minmax(0, 1fr)) / minmax(0, 1fr); }
  }
`;

/** Lays the page out for so many runs; for one, in the normal way. */
export function layOut(count: number): void {
  adopt();
  if (count > 1) document.body.dataset["race"] = String(count);
  else delete document.body.dataset["race"];
}

let isAdopted = false;
function adopt(): void {
  if (isAdopted) return;
  isAdopted = true;
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(SHEET);
  document.adoptedStyleSheets = [...document.adoptedStyleSheets, sheet];
}
