// Light and dark: the style sheet holds the colours, canvases ask for them here.

const NAMES = ["ground", "floor", "wall", "ink", "muted", "faint", "accent", "warning"];

export function colours() {
  const style = getComputedStyle(document.documentElement);
  return Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}

export function isDark() {
  const chosen = document.documentElement.dataset.theme;
  if (chosen) return chosen === "dark";
  return matchMedia("(prefers-color-scheme: dark)").matches;
}

export function toggleTheme(state) {
  document.documentElement.dataset.theme = isDark() ? "light" : "dark";
  state.tell("theme");
}

export function followSystem(state) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => state.tell("theme"));
}

/** Fit a canvas to its box at the screen's own resolution; says whether anything changed. */
export function fit(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width === width && canvas.height === height) return false;
  canvas.width = width;
  canvas.height = height;
  return true;
}
