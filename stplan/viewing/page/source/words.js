// Numbers as a reader wants them.

const RULES = [
  [0.01, 1000, "mm"],
  [0.995, 100, "cm"],
  [Infinity, 1, "m"],
];

/** A length in m as 3.2 mm, 41 cm or 1.25 m. */
export function metres(length) {
  const [, factor, unit] = RULES.find(([limit]) => Math.abs(length) < limit);
  const digits = unit === "m" ? 3 : 2;
  return `${Number((factor * length).toPrecision(digits))} ${unit}`;
}

export const seconds = (time) => `${time.toFixed(2)} s`;
export const speed = (value) => `${value.toFixed(2)} m/s`;

/** The smallest of 1, 2, 5 times a power of ten that is at least `rough`. */
export function niceStep(rough) {
  const power = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= rough * 0.999);
}

/** An element with attributes, listeners (`onclick`) and children. */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name === "style") made.style.cssText = value;
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}
