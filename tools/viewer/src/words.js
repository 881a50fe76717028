// Numbers with units as people write them, and elements. All text is set as text, never as markup.
const PREFIXES = { m: [[1, "m"], [1e-3, "mm"], [1e-6, "\u00b5m"]], N: [[1e3, "kN"], [1, "N"]] };

export function quantity(value, unit, like = value) { // 0 in the unit of another value
  if (value === null || value === undefined || !Number.isFinite(value)) return "not known";
  const sizes = PREFIXES[unit] ?? [[1, unit]];
  const [size, name] = sizes.find(([each]) => Math.abs(value || like) >= each) ?? sizes[value || like ? sizes.length - 1 : 0];
  return `${number(value / size)} ${name}`.trim();
}

export const number = (value, digits = 3) => String(Number(value.toPrecision(digits))).replace("-", "\u2212");

export const fixed = (value, digits) => value.toFixed(digits).replace("-", "\u2212");

export function clock(seconds) {
  const s = Math.max(0, Math.round(seconds)), [h, m] = [Math.floor(s / 3600), Math.floor(s / 60) % 60];
  const two = (v) => String(v).padStart(2, "0");
  return h ? `${h} h ${two(m)} min` : seconds < 60 ? `${fixed(seconds, 1)} s` : `${m} min ${two(s % 60)} s`;
}

export function make(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (key in made && key !== "list") made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}
