// Texts of the table, numbers as people write them, and elements. All text is set as text, never as markup.
import { TEXTS } from "./texts.js";

export function t(key, values = {}) { // of the table, filled in
  const text = TEXTS[key];
  if (text === undefined) throw new Error(`no text ${key}`);
  return text.replace(/\{(\w+)\}/g, (_, name) => values[name] ?? "");
}

export const has = (key) => key in TEXTS;

export const worded = (prefix, word) => has(`${prefix}.${word}`) ? t(`${prefix}.${word}`) : word; // a word of the machine

export function setTexts(root = document) { // of the elements that name their text; attributes as data-t-label
  for (const each of root.querySelectorAll("[data-t]")) each.textContent = t(each.dataset.t);
  for (const each of root.querySelectorAll("[data-t-label]")) each.setAttribute("aria-label", t(each.dataset.tLabel));
  for (const each of root.querySelectorAll("[data-t-hint]")) each.placeholder = t(each.dataset.tHint);
}

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
  if (!known(value)) return t("unknown");
  return Math.abs(value) < 0.1 ? `${fixed(1e3 * value, 1)} mm` : `${fixed(value, 3)} m`;
}

export const force = (value) => !known(value) ? t("unknown") : Math.abs(value) < 1e4 ? `${fixed(value, 0)} N` : `${fixed(value / 1e3, 1)} kN`;

export function span(seconds) {
  if (!known(seconds)) return t("unknown");
  const s = Math.max(0, Math.round(seconds)), h = Math.floor(s / 3600), m = Math.floor(s / 60) % 60;
  return h ? `${h} h ${String(m).padStart(2, "0")} min` : m ? `${m} min ${String(s % 60).padStart(2, "0")} s` : `${s} s`;
}

export const clock = (utc) => new Date(1e3 * utc).toLocaleTimeString();
