// Time: play, pause, speed, and a bar that shows how tight it is when, to be dragged along.

import { colours, fit } from "./theme.js";
import { element, niceStep, seconds } from "./words.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16, 32, 64];
// Unless told, a run is played within so many seconds.
const LONGEST = 20;

export class Timeline {
  constructor(state) {
    this.state = state;
    this.run = state.run;
    this.bar = document.getElementById("timeline");
    this.canvas = this.bar.querySelector("canvas");
    this.button = document.getElementById("play");
    this.readout = document.getElementById("time");
    this.choice = document.getElementById("speed");
    for (const speed of SPEEDS) this.choice.add(new Option(`${speed}×`, speed));
    this.setSpeed(SPEEDS.find((speed) => speed >= 1 && this.run.duration / speed <= LONGEST) ?? 64);
    this.choice.addEventListener("change", () => this.setSpeed(Number(this.choice.value)));
    this.button.addEventListener("click", () => state.play(!state.playing));
    this.bar.setAttribute("aria-valuemin", this.run.begin);
    this.bar.setAttribute("aria-valuemax", this.run.end);
    this.listenToPointer();
    this.markEvents();
    this.dirty = true;
    state.listen((what) => {
      this.dirty = true;
      if (what === "playing") this.showPlaying();
      if (what === "time") this.showTime();
    });
    this.showTime();
  }

  setSpeed(speed) {
    this.state.speed = speed;
    this.choice.value = String(speed);
  }

  /** The next slower (-1) or faster (1) speed. */
  changeSpeed(by) {
    const place = SPEEDS.indexOf(this.state.speed) + by;
    if (place >= 0 && place < SPEEDS.length) this.setSpeed(SPEEDS[place]);
  }

  showPlaying() {
    const { playing } = this.state;
    this.button.textContent = playing ? "❚❚" : "▶";
    this.button.setAttribute("aria-pressed", playing);
    this.button.setAttribute("aria-label", playing ? "Pause" : "Play");
  }

  showTime() {
    this.readout.textContent = seconds(this.state.time);
    this.bar.setAttribute("aria-valuenow", this.state.time.toFixed(3));
    this.bar.setAttribute("aria-valuetext", seconds(this.state.time));
  }

  /** A button over the bar where something happened that nobody knew of before. */
  markEvents() {
    for (const event of this.run.events) {
      const part = (event.time - this.run.begin) / this.run.duration;
      const says = `${seconds(event.time)}: ${event.what}`;
      const mark = element("button", {
        type: "button", class: "event", "data-time": event.time, title: says, "aria-label": says,
        style: `left: ${100 * Math.min(Math.max(part, 0), 1)}%`, onclick: () => this.state.goToEvent(event),
      });
      document.getElementById("marks").append(mark);
    }
  }

  listenToPointer() {
    const seek = (event) => {
      const box = this.bar.getBoundingClientRect();
      const part = (event.clientX - box.left) / box.width;
      this.state.seek(this.run.begin + part * this.run.duration);
    };
    this.bar.addEventListener("pointerdown", (event) => {
      this.bar.setPointerCapture(event.pointerId);
      this.state.play(false);
      seek(event);
    });
    this.bar.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) seek(event);
    });
  }

  draw() {
    if (fit(this.canvas)) this.dirty = true;
    if (!this.dirty) return;
    this.dirty = false;
    const pen = this.canvas.getContext("2d");
    const { width, height } = this.canvas;
    const palette = colours();
    const ratio = window.devicePixelRatio || 1;
    const x = (time) => ((time - this.run.begin) / this.run.duration) * width;
    const foot = height - 16 * ratio;
    pen.clearRect(0, 0, width, height);
    this.drawWaits(pen, palette, x, foot);
    this.drawClearance(pen, this.run.clearance.walls, palette.faint, x, foot);
    this.drawClearance(pen, this.run.clearance.pairs, palette.accent, x, foot);
    this.drawTicks(pen, palette, x, foot, ratio);
    pen.fillStyle = palette.ink;
    pen.fillRect(x(this.state.time) - ratio, 0, 2 * ratio, foot + 3 * ratio);
  }

  /** How tight it is: the fuller, the tighter; full is contact. */
  drawClearance(pen, values, colour, x, foot) {
    const { times, reach } = this.run.clearance;
    pen.fillStyle = colour;
    pen.globalAlpha = 0.5;
    pen.beginPath();
    pen.moveTo(0, foot);
    times.forEach((time, k) => {
      const value = values[k];
      const fullness = value === null ? 0 : 1 - Math.sqrt(Math.min(Math.max(value, 0), reach) / reach);
      pen.lineTo(x(time), foot * (1 - 0.94 * fullness));
    });
    pen.lineTo(x(times.at(-1)), foot);
    pen.fill();
    pen.globalAlpha = 1;
  }

  drawWaits(pen, palette, x, foot) {
    for (const a of this.state.selected) {
      pen.fillStyle = this.run.agents[a].colour;
      pen.globalAlpha = 0.3;
      for (const { begin, end } of this.run.agents[a].waits) {
        pen.fillRect(x(begin), 0, x(end) - x(begin), foot);
      }
    }
    pen.globalAlpha = 1;
  }

  drawTicks(pen, palette, x, foot, ratio) {
    const { begin, end, duration } = this.run;
    const step = niceStep(duration / 10);
    pen.fillStyle = palette.muted;
    pen.fillRect(0, foot, this.canvas.width, ratio);
    pen.font = `${10.5 * ratio}px ${getComputedStyle(document.body).fontFamily}`;
    pen.textAlign = "center";
    for (let k = Math.ceil(begin / step); k * step <= end; k += 1) {
      const at = Math.min(Math.max(x(k * step), 8 * ratio), this.canvas.width - 8 * ratio);
      pen.fillRect(x(k * step), foot, ratio, 4 * ratio);
      pen.fillText(String(Number((k * step).toFixed(6))), at, foot + 14 * ratio);
    }
    pen.textAlign = "start";
  }
}
