// The map: walls, paths and goals on a layer that is kept, discs drawn anew at every time.

import { colours, fit } from "./theme.js";
import { niceStep } from "./words.js";

const MARGIN = 0.05;
// Names of so many agents are shown even where they do not fit into their discs.
const FEW = 12;

export class Plane {
  constructor(section, state) {
    this.section = section;
    this.canvas = section.querySelector("canvas");
    this.state = state;
    this.run = state.run;
    this.layer = document.createElement("canvas");
    this.zoom = 1;
    this.shift = [0, 0];
    this.stale = true;
    this.dirty = true;
    state.listen((what) => {
      this.dirty = true;
      if (["selection", "theme", "other"].includes(what)) this.stale = true;
    });
    this.listenToPointer();
  }

  /** Pixels a metre, and the pixel of the world's origin. */
  measure() {
    const [xmin, ymin, xmax, ymax] = this.run.bounds;
    const { width, height } = this.canvas;
    const whole = Math.min(width / (xmax - xmin), height / (ymax - ymin)) * (1 - MARGIN);
    this.scale = whole * this.zoom;
    this.origin = [
      width / 2 - (this.scale * (xmin + xmax)) / 2 + this.shift[0],
      height / 2 + (this.scale * (ymin + ymax)) / 2 + this.shift[1],
    ];
  }

  toWorld(event) {
    const box = this.canvas.getBoundingClientRect();
    const ratio = this.canvas.width / box.width;
    const [x, y] = [(event.clientX - box.left) * ratio, (event.clientY - box.top) * ratio];
    return [(x - this.origin[0]) / this.scale, (this.origin[1] - y) / this.scale, x, y, ratio];
  }

  listenToPointer() {
    const { canvas, state } = this;
    let drag = null;
    canvas.addEventListener("pointerdown", (event) => {
      drag = { x: event.clientX, y: event.clientY, shift: [...this.shift], moved: false };
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      const [x, y, , , ratio] = this.toWorld(event);
      if (drag) {
        const offset = [event.clientX - drag.x, event.clientY - drag.y];
        drag.moved ||= Math.hypot(...offset) > 4;
        if (drag.moved) {
          this.shift = [drag.shift[0] + offset[0] * ratio, drag.shift[1] + offset[1] * ratio];
          this.stale = this.dirty = true;
        }
        return;
      }
      const agent = this.run.agentAt(x, y, state.time, (6 * ratio) / this.scale);
      canvas.style.cursor = agent === null ? "grab" : "pointer";
      state.pointer = { x: event.clientX, y: event.clientY, time: null };
      state.hover(agent);
    });
    canvas.addEventListener("pointerup", (event) => {
      const [x, y, , , ratio] = this.toWorld(event);
      if (drag && !drag.moved) {
        const agent = this.run.agentAt(x, y, state.time, (6 * ratio) / this.scale);
        state.select(agent === null ? [] : [agent]);
      }
      drag = null;
    });
    canvas.addEventListener("pointerleave", () => state.hover(null));
    canvas.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        const [, , x, y] = this.toWorld(event);
        const factor = Math.exp(-event.deltaY * 0.0015);
        const zoom = Math.min(Math.max(this.zoom * factor, 0.5), 60);
        const used = zoom / this.zoom;
        this.zoom = zoom;
        const middle = [this.canvas.width / 2, this.canvas.height / 2];
        this.shift = [
          (this.shift[0] - (x - middle[0])) * used + (x - middle[0]),
          (this.shift[1] - (y - middle[1])) * used + (y - middle[1]),
        ];
        this.stale = this.dirty = true;
      },
      { passive: false },
    );
    canvas.addEventListener("dblclick", () => {
      this.zoom = 1;
      this.shift = [0, 0];
      this.stale = this.dirty = true;
    });
  }

  draw() {
    if (fit(this.canvas)) this.stale = this.dirty = true;
    if (!this.dirty) return;
    this.measure();
    if (this.stale) this.drawLayer();
    this.dirty = this.stale = false;
    const pen = this.canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.drawImage(this.layer, 0, 0);
    this.drawDiscs(pen);
  }

  drawLayer() {
    const { layer, run, state } = this;
    const palette = colours();
    layer.width = this.canvas.width;
    layer.height = this.canvas.height;
    const pen = layer.getContext("2d");
    const ratio = window.devicePixelRatio || 1;
    pen.fillStyle = run.map ? palette.ground : palette.floor;
    pen.fillRect(0, 0, layer.width, layer.height);
    if (run.map) {
      pen.beginPath();
      for (const part of run.map) for (const ring of part) this.trace(pen, ring, true);
      pen.fillStyle = palette.floor;
      pen.fill("evenodd");
      pen.strokeStyle = palette.wall;
      pen.lineWidth = 1.2 * ratio;
      pen.stroke();
    }
    pen.lineJoin = pen.lineCap = "round";
    run.agents.forEach((agent, a) => {
      const shown = state.shows(a);
      const isolated = state.selected.has(a);
      pen.strokeStyle = agent.colour;
      pen.globalAlpha = isolated ? 0.2 : shown ? 0.07 : 0;
      pen.lineWidth = 2 * agent.radius * this.scale;
      pen.beginPath();
      this.trace(pen, agent.knots, false);
      pen.stroke();
      pen.globalAlpha = isolated ? 1 : shown ? 0.55 : 0.12;
      pen.lineWidth = (isolated ? 2 : 1.2) * ratio;
      pen.stroke();
      if (isolated && run.seed) {
        pen.setLineDash([2 * ratio, 4 * ratio]);
        pen.beginPath();
        this.trace(pen, run.seed[a], false);
        pen.stroke();
        pen.setLineDash([]);
      }
      this.cross(pen, agent.knots.at(-1), 4 * ratio);
    });
    if (run.other && state.other) this.drawOtherPaths(pen, ratio);
    pen.globalAlpha = 1;
    this.drawScale(pen, palette, ratio);
  }

  /** Whether an agent of the second run is shown: with its namesake, or with all. */
  showsOther(agent) {
    return agent.row === null ? this.state.selected.size === 0 : this.state.shows(agent.row);
  }

  drawOtherPaths(pen, ratio) {
    pen.lineWidth = 1.2 * ratio;
    pen.setLineDash([5 * ratio, 4 * ratio]);
    for (const agent of this.run.other.agents) {
      pen.strokeStyle = agent.colour;
      pen.globalAlpha = this.showsOther(agent) ? 0.6 : 0.06;
      pen.beginPath();
      this.trace(pen, agent.knots, false);
      pen.stroke();
    }
    pen.setLineDash([]);
  }

  /** Rings of the second run, each tied to its namesake's disc. */
  drawRings(pen, ratio) {
    const { run, state } = this;
    const place = [0, 0];
    pen.lineWidth = 2 * ratio;
    run.other.agents.forEach((agent, a) => {
      if (!run.other.place(a, state.time, place)) return;
      const [u, v] = [this.origin[0] + this.scale * place[0], this.origin[1] - this.scale * place[1]];
      pen.globalAlpha = this.showsOther(agent) ? 0.9 : 0.1;
      pen.strokeStyle = agent.colour;
      pen.beginPath();
      pen.arc(u, v, Math.max(agent.radius * this.scale, 2.5 * ratio), 0, 2 * Math.PI);
      if (agent.row !== null && run.place(agent.row, state.time, place)) {
        pen.moveTo(u, v);
        pen.lineTo(this.origin[0] + this.scale * place[0], this.origin[1] - this.scale * place[1]);
      }
      pen.stroke();
    });
    pen.globalAlpha = 1;
  }

  trace(pen, points, closed) {
    points.forEach(([x, y], k) => {
      const [u, v] = [this.origin[0] + this.scale * x, this.origin[1] - this.scale * y];
      if (k === 0) pen.moveTo(u, v);
      else pen.lineTo(u, v);
    });
    if (closed) pen.closePath();
  }

  cross(pen, [x, y], size) {
    const [u, v] = [this.origin[0] + this.scale * x, this.origin[1] - this.scale * y];
    pen.beginPath();
    pen.moveTo(u - size, v - size);
    pen.lineTo(u + size, v + size);
    pen.moveTo(u - size, v + size);
    pen.lineTo(u + size, v - size);
    pen.stroke();
  }

  drawScale(pen, palette, ratio) {
    const length = niceStep((70 * ratio) / this.scale);
    const [x, y] = [14 * ratio, this.canvas.height - 16 * ratio];
    pen.fillStyle = palette.muted;
    pen.fillRect(x, y, length * this.scale, 2 * ratio);
    pen.font = `${11 * ratio}px ${getComputedStyle(document.body).fontFamily}`;
    pen.fillText(`${length} m`, x + length * this.scale + 6 * ratio, y + 5 * ratio);
  }

  drawDiscs(pen) {
    const { run, state } = this;
    const palette = colours();
    const ratio = window.devicePixelRatio || 1;
    const place = [0, 0];
    const names = [];
    if (run.other && state.other) this.drawRings(pen, ratio);
    pen.lineWidth = 1.5 * ratio;
    run.agents.forEach((agent, a) => {
      if (!run.place(a, state.time, place)) return;
      const shown = state.shows(a);
      const [u, v] = [this.origin[0] + this.scale * place[0], this.origin[1] - this.scale * place[1]];
      const radius = Math.max(agent.radius * this.scale, 2.5 * ratio);
      pen.globalAlpha = shown ? 0.85 : 0.16;
      pen.fillStyle = agent.colour;
      pen.beginPath();
      pen.arc(u, v, radius, 0, 2 * Math.PI);
      pen.fill();
      if (a === state.hovered || state.selected.has(a)) {
        pen.globalAlpha = 1;
        pen.strokeStyle = palette.ink;
        pen.stroke();
      }
      if (shown) names.push([agent.id, u, v, radius]);
    });
    pen.globalAlpha = 1;
    pen.font = `600 ${11 * ratio}px ${getComputedStyle(document.body).fontFamily}`;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    for (const [name, u, v, radius] of names) {
      const inside = pen.measureText(name).width <= 1.8 * radius;
      pen.fillStyle = inside ? "#ffffff" : palette.ink;
      if (inside) pen.fillText(name, u, v);
      else if (state.selected.size || names.length <= FEW) pen.fillText(name, u, v - radius - 9 * ratio);
    }
    pen.textAlign = "start";
    pen.textBaseline = "alphabetic";
    if (state.moment) this.drawMoment(pen, palette, ratio);
  }

  /** A ring around the place of the tight moment that was asked for. */
  drawMoment(pen, palette, ratio) {
    const { x, y, time } = this.state.moment;
    if (Math.abs(time - this.state.time) > 1e-6) return;
    const [u, v] = [this.origin[0] + this.scale * x, this.origin[1] - this.scale * y];
    pen.strokeStyle = palette.warning;
    pen.lineWidth = 2 * ratio;
    pen.beginPath();
    pen.arc(u, v, 9 * ratio, 0, 2 * Math.PI);
    pen.stroke();
  }
}

