// The style of all plots in the current theme.

import type uPlot from "uplot";

/** A custom property as a colour that a canvas accepts; `probe` is any element of the component. */
export function colourOf(probe: HTMLElement, name: string): string {
  probe.style.setProperty("color", `var(--${name})`);
  const colour = getComputedStyle(probe).color;
  probe.style.removeProperty("color");
  return colour;
}

/** The same colour, almost transparent. */
export function faint(colour: string): string {
  return colour.replace(/^rgb\((.*)\)$/, (_, parts: string) => `rgba(${parts}, 0.2)`);
}

/** Axes: numbers with their unit below, values on the left. */
export function numberAxes(probe: HTMLElement, unit: string): uPlot.Axis[] {
  const axis = { stroke: colourOf(probe, "muted"), font: "11px IBM Plex Mono, monospace", ticks: { show: false }, grid: { stroke: colourOf(probe, "line"), width: 1 } };
  return [
    { ...axis, size: 24, gap: 6, space: 60, values: (_u, ticks) => ticks.map((t) => `${t} ${unit}`) },
    { ...axis, size: 44, gap: 4, space: 28 },
  ];
}
