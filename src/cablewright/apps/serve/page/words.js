// Numbers as people write them, and elements. All text is set as text, never as markup.
export const at = (id) => document.getElementById(id);

export function make(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (key in made) made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

export function put(element, text) { if (element.textContent !== text) element.textContent = text; }

const known = (value) => typeof value === "number" && Number.isFinite(value);

export const fixed = (value, digits) => known(value) ? value.toFixed(digits).replace("-", "\u2212") : "\u2013";

export function length(value) { // m
  if (!known(value)) return "not known";
  return Math.abs(value) < 0.1 ? `${fixed(1e3 * value, 1)} mm` : `${fixed(value, 3)} m`;
}

export const force = (value) => !known(value) ? "not known" : Math.abs(value) < 1e4 ? `${fixed(value, 0)} N` : `${fixed(value / 1e3, 1)} kN`;

export function span(seconds) {
  if (!known(seconds)) return "not known";
  const s = Math.max(0, Math.round(seconds)), h = Math.floor(s / 3600), m = Math.floor(s / 60) % 60;
  return h ? `${h} h ${String(m).padStart(2, "0")} min` : m ? `${m} min ${String(s % 60).padStart(2, "0")} s` : `${s} s`;
}

export const clock = (utc) => new Date(1e3 * utc).toLocaleTimeString();
