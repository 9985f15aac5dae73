// Numbers as a reader wants them.

/** A length in m as 3.2 mm or 1.25 m, as in all that the program says. */
export function metres(length) {
  const [factor, unit] = Math.abs(length) < 0.1 ? [1000, "mm"] : [1, "m"];
  return `${Number((factor * length).toPrecision(3))} ${unit}`;
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
