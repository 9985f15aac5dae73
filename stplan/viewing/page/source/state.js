// What the page shows just now: the time, who is selected or pointed at. Views listen.

export class State {
  constructor(run) {
    this.run = run;
    this.time = run.begin;
    this.playing = false;
    this.speed = 1;
    this.selected = new Set();
    this.hovered = null;
    this.moment = null;
    this.other = true;
    this.listeners = [];
  }

  /** Call `listener(what)` after a change of "time", "playing", "selection", "hover", "other" or "theme". */
  listen(listener) {
    this.listeners.push(listener);
  }

  tell(what) {
    for (const listener of this.listeners) listener(what);
  }

  seek(time) {
    this.time = Math.min(Math.max(time, this.run.begin), this.run.end);
    this.tell("time");
  }

  play(playing) {
    if (playing && this.time >= this.run.end) this.seek(this.run.begin);
    this.playing = playing;
    this.tell("playing");
  }

  /** Isolate these agents; none shows all. */
  select(agents, moment = null) {
    this.selected = new Set(agents);
    this.moment = moment;
    this.tell("selection");
  }

  /** Show the second run, where there is one, or hide it. */
  showOther(shown) {
    this.other = shown;
    this.tell("other");
  }

  hover(agent) {
    if (agent === this.hovered) return;
    this.hovered = agent;
    this.tell("hover");
  }

  /** Stop at a tight moment and isolate who is in it. */
  goTo(moment) {
    this.play(false);
    this.seek(moment.time);
    this.select(moment.b === null ? [moment.a] : [moment.a, moment.b], moment);
  }

  /** Stop where something happened; all are shown, for it may concern everybody. */
  goToEvent(event) {
    this.play(false);
    this.seek(event.time);
    this.select([]);
  }

  /** The nearest event before (-1) or after (1) the time that is shown, if there is one. */
  eventFrom(direction) {
    const ahead = this.run.events.filter(({ time }) => direction * (time - this.time) > 1e-6);
    return direction > 0 ? ahead[0] : ahead.at(-1);
  }

  shows(agent) {
    return this.selected.size === 0 || this.selected.has(agent);
  }
}
