// Mounts a view in each element of class "viewer"; its scene is the JSON in the script element that data-scene names.
import { View } from "./view.js";
import { Panel } from "./panel.js";
import { make } from "./words.js";

async function mount(host, scene) {
  const stage = host.querySelector(".stage");
  const canvas = make("canvas", { tabIndex: 0 });
  let view;
  try {
    const given = scene ?? JSON.parse(document.getElementById(host.dataset.scene).textContent);
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${given.title}, in three dimensions`);
    if (!window.WebGL2RenderingContext) throw new Error("no WebGL 2");
    stage.append(canvas);
    host.classList.add("live"); // has the size that it will have
    view = await View.of(canvas, given);
  } catch (reason) { // the picture stays
    canvas.remove();
    host.classList.remove("live");
    host.classList.add("still");
    host.dataset.reason = String(reason);
    return;
  }
  view.untouched = true;
  host.view = view; // for those who test, and for the operator's page
  new Panel(host, stage, view);
  host.dataset.ready = "yes";
}

window.cablewright = { mount }; // of a scene that comes later
for (const host of document.querySelectorAll(".viewer[data-scene]")) mount(host);
