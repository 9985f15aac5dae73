// The page of a run: reads it, builds the views, plays.

import { Panel } from "./panel.js";
import { Plane } from "./plane.js";
import { Rods } from "./rods.js";
import { Run } from "./run.js";
import { State } from "./state.js";
import { followSystem, toggleTheme } from "./theme.js";
import { Timeline } from "./timeline.js";
import { element, metres, seconds, speed } from "./words.js";

const run = new Run(JSON.parse(document.getElementById("run").textContent));
if (run.other) run.other = new Run(run.other);
const state = new State(run);

function showHead() {
  document.title = `${run.title} · stplan`;
  document.getElementById("title").textContent = run.title;
  document.getElementById("description").textContent = run.description;
  const [tightest] = run.moments;
  const facts = [`${run.agents.length} agents`, `all arrived after ${seconds(run.arrived)}`];
  if (tightest) facts.push(`smallest clearance ${metres(tightest.clearance)}`);
  if (run.other) facts.push(`rings: ${run.other.title}, after ${seconds(run.other.end)}`);
  document.getElementById("facts").textContent = facts.join(" · ");
}

function showTip() {
  const tip = document.getElementById("tip");
  tip.hidden = state.hovered === null;
  if (tip.hidden) return;
  // On the map that is now; on a rod it is the time of the place that is pointed at.
  const { x, y } = state.pointer;
  const time = state.pointer.time ?? state.time;
  tip.textContent = `${run.agents[state.hovered].id} · ${seconds(time)} · ${speed(run.speed(state.hovered, time))}`;
  tip.style.left = `${Math.min(x + 14, window.innerWidth - tip.offsetWidth - 8)}px`;
  tip.style.top = `${Math.max(y - 34, 4)}px`;
}

/** The 3D view; where the browser has no WebGL, a sentence in its place. */
function buildRods() {
  const section = document.getElementById("rods");
  try {
    return new Rods(section, state);
  } catch (error) {
    section.replaceChildren(element("p", { class: "missing" }, `No 3D view: ${error.message}`));
    return { draw() {} };
  }
}

function listenToKeys(timeline) {
  const nudge = (event, direction) =>
    state.seek(state.time + direction * run.duration * (event.shiftKey ? 0.1 : 0.01));
  const toEvent = (direction) => {
    const found = state.eventFrom(direction);
    if (found) state.goToEvent(found);
  };
  const keys = {
    " ": () => state.play(!state.playing),
    ArrowLeft: (event) => nudge(event, -1),
    ArrowRight: (event) => nudge(event, 1),
    Home: () => state.seek(run.begin),
    End: () => state.seek(run.end),
    "+": () => timeline.changeSpeed(1),
    "-": () => timeline.changeSpeed(-1),
    n: () => run.moments.length && state.goTo(run.moments[0]),
    e: () => toEvent(1),
    E: () => toEvent(-1),
    o: () => run.other && state.showOther(!state.other),
    t: () => toggleTheme(state),
    Escape: () => state.select([]),
  };
  document.addEventListener("keydown", (event) => {
    const act = keys[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey || ["SELECT", "INPUT"].includes(event.target.tagName)) return;
    event.preventDefault();
    act(event);
  });
}

showHead();
const timeline = new Timeline(state);
const views = [
  new Plane(document.getElementById("plane"), state),
  buildRods(),
  timeline,
  new Panel(document.getElementById("panel"), state),
];
state.listen((what) => {
  if (what === "hover" || (what === "time" && state.hovered !== null)) showTip();
});
document.getElementById("theme").addEventListener("click", () => toggleTheme(state));
followSystem(state);
listenToKeys(timeline);

let before = performance.now();
function frame(now) {
  const passed = Math.min(now - before, 100) / 1000;
  before = now;
  if (state.playing) {
    state.seek(state.time + passed * state.speed);
    if (state.time >= run.end) state.play(false);
  }
  for (const view of views) view.draw();
  requestAnimationFrame(frame);
}
requestAnimationFrame(frame);
