// The run that the page shows: what Python wrote into it, and where everyone is at any time.

export class Run {
  constructor(content) {
    Object.assign(this, content);
    this.duration = Math.max(this.end - this.begin, 1e-9);
    // Where the last look-up of an agent ended: time mostly goes on by a little.
    this.cursors = new Int32Array(this.agents.length);
  }

  /** The segment of agent `a` that `time` falls into, -1 before its start, its last knot after arrival. */
  segment(a, time) {
    const knots = this.agents[a].knots;
    const last = knots.length - 1;
    if (time < knots[0][2]) return -1;
    if (time >= knots[last][2]) return last;
    let k = Math.min(this.cursors[a], last - 1);
    while (knots[k][2] > time) k -= 1;
    while (knots[k + 1][2] <= time) k += 1;
    this.cursors[a] = k;
    return k;
  }

  /** Writes agent `a`'s place at `time` into `out` and says whether it is there. */
  place(a, time, out) {
    const { knots, leaves } = this.agents[a];
    const k = this.segment(a, time);
    if (k < 0 || time > leaves) return false;
    const from = knots[k];
    const to = knots[Math.min(k + 1, knots.length - 1)];
    const part = to[2] > from[2] ? (time - from[2]) / (to[2] - from[2]) : 0;
    out[0] = from[0] + part * (to[0] - from[0]);
    out[1] = from[1] + part * (to[1] - from[1]);
    return true;
  }

  /** Speed of agent `a` at `time` in m/s, 0 when it stands or is not there. */
  speed(a, time) {
    const { knots } = this.agents[a];
    const k = this.segment(a, time);
    if (k < 0 || k >= knots.length - 1) return 0;
    const [from, to] = [knots[k], knots[k + 1]];
    return Math.hypot(to[0] - from[0], to[1] - from[1]) / (to[2] - from[2]);
  }

  /** Who is nearest to agent `a` at `time`: { b, gap } with the gap of the rims in m, or null. */
  nearest(a, time) {
    const here = [0, 0];
    const there = [0, 0];
    if (!this.place(a, time, here)) return null;
    let best = null;
    for (let b = 0; b < this.agents.length; b += 1) {
      if (b === a || !this.place(b, time, there)) continue;
      const gap =
        Math.hypot(here[0] - there[0], here[1] - there[1]) -
        this.agents[a].radius - this.agents[b].radius;
      if (best === null || gap < best.gap) best = { b, gap };
    }
    return best;
  }

  /** The agent whose disc covers the point, the smallest of several; null for none. */
  agentAt(x, y, time, reach) {
    const place = [0, 0];
    let found = null;
    for (let a = 0; a < this.agents.length; a += 1) {
      if (!this.place(a, time, place)) continue;
      const radius = this.agents[a].radius;
      const inside = Math.hypot(place[0] - x, place[1] - y) <= Math.max(radius, reach);
      if (inside && (found === null || radius < this.agents[found].radius)) found = a;
    }
    return found;
  }
}
