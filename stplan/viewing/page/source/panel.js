// The side panel: the whole run, or the agents that are selected; every row about a moment goes there.

import { element, metres, seconds, speed } from "./words.js";

const FIRST = 14;

export class Panel {
  constructor(root, state) {
    this.root = root;
    this.state = state;
    this.run = state.run;
    this.moments = state.run.moments;
    state.listen((what) => {
      if (what === "selection") this.fill();
      if (what === "time") this.stale = true;
      if (what === "other" && this.box) this.box.checked = state.other;
    });
    this.fill();
  }

  fill() {
    const { selected } = this.state;
    this.live = null;
    const [first] = selected;
    const content =
      selected.size === 0 ? this.whole() : selected.size === 1 ? this.agent(first) : this.pair();
    this.root.replaceChildren(...content.filter(Boolean));
    this.root.scrollTop = 0;
    this.stale = true;
  }

  /** Fill in what changes with time. */
  draw() {
    if (!this.stale) return;
    this.stale = false;
    if (this.live) this.live();
  }

  name(a) {
    return this.run.agents[a].id;
  }

  dot(a) {
    return element("i", { class: "dot", style: `background:${this.run.agents[a].colour}` });
  }

  link(a) {
    return element(
      "button",
      { type: "button", class: "agent", "data-agent": this.name(a), onclick: () => this.state.select([a]) },
      this.dot(a), this.name(a),
    );
  }

  whole() {
    const waiting = this.run.agents.flatMap((agent, a) => agent.waits.map((wait) => ({ a, ...wait })));
    return [
      ...this.run.notes.map((note) => element("p", { class: "note" }, note)),
      ...(this.run.other ? this.comparison() : []),
      ...(this.run.events.length > 0 ? this.events() : []),
      element("h2", {}, `Agents (${this.run.agents.length})`),
      element("div", { class: "agents all" }, ...this.run.agents.map((_, a) => this.link(a))),
      element("h2", {}, "Tightest moments"),
      this.list(this.moments),
      waiting.length > 0 && element("h2", {}, "Who waits"),
      waiting.length > 0 && this.waits(waiting),
    ];
  }

  /** What nobody knew of before, each with who waits for whom from then on until the next. */
  events() {
    const { events, agents } = this.run;
    const rows = events.map((event, k) => {
      const until = events[k + 1]?.time ?? this.run.end;
      // Whom the event stopped does not wait for anybody meanwhile.
      const stands = (a, begin) => event.still.some((one) => one.a === a && begin < one.until);
      const stopped = agents.flatMap((agent, a) =>
        agent.waits
          .filter(({ begin }) => begin >= event.time && begin < until && !stands(a, begin))
          .map(({ b }) => (b === null ? `${this.name(a)} waits` : `${this.name(b)} stops ${this.name(a)}`)),
      );
      const who = [...new Set(stopped)].join(", ");
      return element(
        "li", {},
        element(
          "button", { type: "button", "data-time": event.time, onclick: () => this.state.goToEvent(event) },
          element("span", { class: "who" }, event.what),
          element("span", { class: "when" }, seconds(event.time)),
        ),
        who && element("p", { class: "muted stops" }, who),
      );
    });
    return [
      element("h2", { title: "Next and previous (E and Shift+E)" }, "What happened"),
      element("ol", { class: "moments", id: "events" }, ...rows),
    ];
  }

  /** What differs between the two runs, and a switch for the second one. */
  comparison() {
    const { other } = this.run;
    const box = element("input", { type: "checkbox", id: "other", onchange: () => this.state.showOther(box.checked) });
    box.checked = this.state.other;
    this.box = box;
    const rows = other.differences.map((one) => this.difference(one));
    const strangers = [
      ...other.missing.map((name) => `${name} is only in the first run`),
      ...other.agents.filter(({ row }) => row === null).map(({ id }) => `${id} is only in the second run`),
    ];
    return [
      element("label", { class: "other", title: "Show or hide the second run (O)" }, box, ` ${other.title}, as rings`),
      element("h2", {}, "Greatest differences"),
      element("ol", { class: "moments", id: "differences" }, ...rows),
      ...strangers.map((line) => element("p", { class: "muted" }, line)),
    ];
  }

  difference(one) {
    const later = one.later === 0 ? "" : `, ${seconds(Math.abs(one.later))} ${one.later > 0 ? "later" : "sooner"}`;
    return element(
      "li", {},
      element(
        "button",
        { type: "button", "data-time": one.time, onclick: () => this.state.goTo(one) },
        element("span", { class: "who" }, this.dot(one.a), `${this.name(one.a)}${later}`),
        element("span", { class: "gap" }, metres(one.distance)),
        element("span", { class: "when" }, seconds(one.time)),
      ),
    );
  }

  agent(a) {
    const agent = this.run.agents[a];
    const now = element("dd", { id: "now" });
    const near = element("dd", { id: "near" });
    this.live = () => {
      now.textContent = speed(this.run.speed(a, this.state.time));
      const nearest = this.run.nearest(a, this.state.time);
      near.textContent = nearest
        ? `${this.name(nearest.b)}, ${nearest.gap >= 0 ? metres(nearest.gap) : "overlapping"}`
        : "nobody";
    };
    const wanted = agent.preferred === null ? "" : `, wanted ${seconds(agent.preferred)}`;
    return [
      this.head(this.dot(a), agent.id),
      element(
        "dl", {},
        element("dt", {}, "speed now"), now,
        element("dt", {}, "nearest now"), near,
        element("dt", {}, "starts"), element("dd", {}, seconds(agent.knots[0][2])),
        element("dt", {}, "arrives"), element("dd", {}, seconds(agent.knots.at(-1)[2]) + wanted),
        element("dt", {}, "path"), element("dd", {}, `${agent.length.toFixed(2)} m`),
        element("dt", {}, "mean, top speed"),
        element("dd", {}, `${agent.mean.toFixed(2)}, ${speed(agent.top)}`),
        element("dt", {}, "radius"), element("dd", {}, metres(agent.radius)),
      ),
      agent.waits.length > 0 && element("h2", {}, "Waits"),
      agent.waits.length > 0 && this.waits(agent.waits.map((wait) => ({ a, ...wait }))),
      element("h2", {}, "Its tightest moments"),
      this.list(this.moments.filter((moment) => moment.a === a || moment.b === a), a),
    ];
  }

  pair() {
    const chosen = [...this.state.selected];
    const between = this.moments.filter(({ a, b }) => chosen.includes(a) && chosen.includes(b));
    return [
      this.head("Tight moment"),
      element("div", { class: "agents" }, ...chosen.map((a) => this.link(a))),
      this.list(between),
      element("p", { class: "muted" }, "Choose one of them, or Esc to show all."),
    ];
  }

  head(...title) {
    return element(
      "div", { class: "head" },
      element("h2", { id: "selected" }, ...title),
      element("button", { type: "button", id: "all", onclick: () => this.state.select([]) }, "show all"),
    );
  }

  /** Rows of moments, tightest first; more of them on demand. All are of agent `of`, if it is given. */
  list(moments, of = null) {
    const rows = element("ol", { class: "moments" });
    const more = element("button", { type: "button", class: "more" });
    const show = (count) => {
      const from = rows.children.length;
      rows.append(...moments.slice(from, from + count).map((moment) => this.row(moment, of)));
      const left = moments.length - rows.children.length;
      more.textContent = `${left} more`;
      more.hidden = left === 0;
    };
    more.addEventListener("click", () => show(15 * FIRST));
    show(FIRST);
    if (moments.length === 0) return element("p", { class: "muted" }, "Nothing comes near.");
    return element("div", {}, rows, more);
  }

  row(moment, of) {
    const { a, b, clearance, time } = moment;
    const other = b === null ? null : a === of ? b : a;
    const who = b === null
      ? [this.dot(a), of === null ? `${this.name(a)} · wall` : "wall"]
      : of === null
        ? [this.dot(a), this.dot(b), `${this.name(a)} · ${this.name(b)}`]
        : [this.dot(other), this.name(other)];
    return element(
      "li", {},
      element(
        "button",
        { type: "button", "data-time": time, onclick: () => this.state.goTo(moment) },
        element("span", { class: "who" }, ...who),
        element("span", { class: clearance > 0 ? "gap" : "gap broken" }, metres(clearance)),
        element("span", { class: "when" }, seconds(time)),
      ),
    );
  }

  waits(rows) {
    const shown = rows.map((wait) => {
      const why = wait.b === null ? "" : ` for ${this.name(wait.b)}`;
      const go = () => {
        this.state.play(false);
        this.state.select([wait.a]);
        this.state.seek(wait.begin);
      };
      return element(
        "li", {},
        element(
          "button", { type: "button", "data-time": wait.begin, onclick: go },
          element("span", { class: "who" }, this.dot(wait.a), this.name(wait.a), why),
          element("span", { class: "when" }, `${wait.begin.toFixed(1)} to ${wait.end.toFixed(1)} s`),
        ),
      );
    });
    return element("ol", { class: "moments" }, ...shown);
  }
}
