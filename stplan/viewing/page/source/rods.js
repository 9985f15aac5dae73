// Space and time: every agent a rod, time upwards, in one geometry that the graphics card draws at once.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { colours, fit } from "./theme.js";

const SIDES = 12;
// Height of the picture over the map's longer side.
const HEIGHT = 0.8;

export class Rods {
  constructor(section, state) {
    this.canvas = section.querySelector("canvas");
    this.state = state;
    this.run = state.run;
    const [xmin, ymin, xmax, ymax] = this.run.bounds;
    this.size = Math.max(xmax - xmin, ymax - ymin);
    this.pace = (HEIGHT * this.size) / this.run.duration;
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true });
    this.renderer.localClippingEnabled = true;
    this.scene = new THREE.Scene();
    this.addLight();
    this.addMap();
    this.addRods();
    this.addTimePlane();
    this.addCamera();
    this.dirty = true;
    state.listen((what) => {
      if (what !== "hover" && what !== "playing") this.dirty = true;
      if (what === "selection") this.isolate();
      if (what === "theme") this.paint();
    });
    this.isolate();
    this.paint();
    this.listenToPointer();
  }

  height(time) {
    return (time - this.run.begin) * this.pace;
  }

  addLight() {
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0xb8bec8, 2.2));
    const sun = new THREE.DirectionalLight(0xffffff, 1.4);
    sun.position.set(-0.6, -1, 1.6);
    this.scene.add(sun);
  }

  addCamera() {
    const [xmin, ymin, xmax, ymax] = this.run.bounds;
    const middle = new THREE.Vector3((xmin + xmax) / 2, (ymin + ymax) / 2, 0.4 * HEIGHT * this.size);
    this.camera = new THREE.PerspectiveCamera(32, 1, this.size / 100, this.size * 20);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.target.copy(middle);
    this.controls.addEventListener("change", () => { this.dirty = true; });
    this.canvas.addEventListener("dblclick", () => this.showAll());
  }

  /** Look from the front left, from where everything fits into the picture. */
  showAll() {
    const [xmin, ymin, xmax, ymax] = this.run.bounds;
    const radius = Math.hypot(xmax - xmin, ymax - ymin, HEIGHT * this.size) / 2;
    const upright = Math.tan((this.camera.fov * Math.PI) / 360);
    const half = Math.atan(upright * Math.min(1, this.camera.aspect));
    const away = new THREE.Vector3(-0.42, -0.8, 0.4).normalize().multiplyScalar(radius / Math.sin(half));
    this.camera.position.copy(this.controls.target).add(away.multiplyScalar(0.88));
    this.controls.update();
    this.dirty = true;
  }

  addMap() {
    const { map, bounds } = this.run;
    const [xmin, ymin, xmax, ymax] = bounds;
    const parts = map ?? [[[[xmin, ymin], [xmax, ymin], [xmax, ymax], [xmin, ymax]]]];
    const points = (ring) => ring.map(([x, y]) => new THREE.Vector2(x, y));
    const shapes = parts.map(([outer, ...holes]) => {
      const shape = new THREE.Shape(points(outer));
      shape.holes = holes.map((hole) => new THREE.Path(points(hole)));
      return shape;
    });
    this.floor = new THREE.Mesh(
      new THREE.ShapeGeometry(shapes),
      new THREE.MeshBasicMaterial({
        side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2,
      }),
    );
    const ends = [];
    for (const part of parts) {
      for (const ring of part) {
        ring.forEach(([x, y], k) => {
          const [u, v] = ring[(k + 1) % ring.length];
          ends.push(x, y, 0, u, v, 0);
        });
      }
    }
    const edges = new THREE.BufferGeometry();
    edges.setAttribute("position", new THREE.Float32BufferAttribute(ends, 3));
    this.walls = new THREE.LineSegments(edges, new THREE.LineBasicMaterial());
    this.scene.add(this.floor, this.walls);
  }

  /** All rods as level rings joined to mantles: between knots a disc moves in a straight line. */
  addRods() {
    const { agents } = this.run;
    const rows = agents.map(({ knots, leaves }) => {
      const last = knots.at(-1);
      return leaves > last[2] ? [...knots, [last[0], last[1], leaves]] : knots;
    });
    const rings = rows.reduce((sum, knots) => sum + knots.length, 0);
    const positions = new Float32Array(3 * (SIDES * rings + 2 * agents.length * (SIDES + 1)));
    const paints = new Float32Array(positions.length);
    const indices = new Uint32Array(6 * SIDES * (rings - agents.length) + 6 * SIDES * agents.length);
    this.ranges = [];
    let [vertex, index] = [0, 0];
    const colour = new THREE.Color();
    const put = (x, y, z) => {
      positions.set([x, y, z], 3 * vertex);
      paints.set([colour.r, colour.g, colour.b], 3 * vertex);
      vertex += 1;
    };
    const ring = ([x, y, t], radius) => {
      for (let k = 0; k < SIDES; k += 1) {
        const angle = (2 * Math.PI * k) / SIDES;
        put(x + radius * Math.cos(angle), y + radius * Math.sin(angle), this.height(t));
      }
    };
    const face = (...corners) => {
      indices.set(corners, index);
      index += 3;
    };
    rows.forEach((knots, a) => {
      const start = index;
      const { radius } = agents[a];
      colour.set(agents[a].colour);
      const base = vertex;
      for (const knot of knots) ring(knot, radius);
      for (let row = 0; row + 1 < knots.length; row += 1) {
        for (let k = 0; k < SIDES; k += 1) {
          const low = base + row * SIDES + k;
          const next = base + row * SIDES + ((k + 1) % SIDES);
          face(low, next, next + SIDES);
          face(low, next + SIDES, low + SIDES);
        }
      }
      for (const [knot, upwards] of [[knots[0], false], [knots.at(-1), true]]) {
        const rim = vertex;
        ring(knot, radius);
        put(knot[0], knot[1], this.height(knot[2]));
        for (let k = 0; k < SIDES; k += 1) {
          const next = rim + ((k + 1) % SIDES);
          if (upwards) face(rim + SIDES, rim + k, next);
          else face(rim + SIDES, next, rim + k);
        }
      }
      this.ranges.push({ start, count: index - start });
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(paints, 3));
    geometry.setIndex(new THREE.BufferAttribute(indices, 1));
    geometry.computeVertexNormals();
    this.addMeshes(geometry);
  }

  /** The past is solid, what is still to come is pale: the same rods, cut at the time plane. */
  addMeshes(geometry) {
    this.below = new THREE.Plane(new THREE.Vector3(0, 0, -1), 0);
    this.above = new THREE.Plane(new THREE.Vector3(0, 0, 1), 0);
    const material = (plane, opacity) =>
      new THREE.MeshLambertMaterial({
        vertexColors: true, clippingPlanes: [plane], opacity, transparent: opacity < 1,
        depthWrite: opacity > 0.2,
      });
    this.past = new THREE.Mesh(geometry, [material(this.below, 1), material(this.below, 0.05)]);
    this.future = new THREE.Mesh(geometry, [material(this.above, 0.3), material(this.above, 0.05)]);
    this.scene.add(this.past, this.future);
  }

  addTimePlane() {
    const [xmin, ymin, xmax, ymax] = this.run.bounds;
    const [width, height] = [xmax - xmin, ymax - ymin];
    this.time = new THREE.Group();
    this.time.position.set((xmin + xmax) / 2, (ymin + ymax) / 2, 0);
    const sheet = new THREE.PlaneGeometry(width, height);
    this.sheet = new THREE.Mesh(
      sheet,
      new THREE.MeshBasicMaterial({
        transparent: true, opacity: 0.1, side: THREE.DoubleSide, depthWrite: false,
      }),
    );
    this.frame = new THREE.LineSegments(new THREE.EdgesGeometry(sheet), new THREE.LineBasicMaterial());
    this.time.add(this.sheet, this.frame);
    this.discs = new THREE.InstancedMesh(
      new THREE.CircleGeometry(1, 24),
      new THREE.MeshBasicMaterial({ side: THREE.DoubleSide }),
      this.run.agents.length,
    );
    this.discs.frustumCulled = false;
    this.run.agents.forEach(({ colour }, a) => this.discs.setColorAt(a, new THREE.Color(colour)));
    this.scene.add(this.time, this.discs);
  }

  paint() {
    const palette = colours();
    this.scene.background = new THREE.Color(palette.ground);
    this.floor.material.color.set(palette.floor);
    this.walls.material.color.set(palette.wall);
    this.sheet.material.color.set(palette.accent);
    this.frame.material.color.set(palette.accent);
  }

  /** Draw the agents that are shown with the first material, the others with the second. */
  isolate() {
    const { geometry } = this.past;
    geometry.clearGroups();
    let open = null;
    this.ranges.forEach(({ start, count }, a) => {
      const kind = this.state.shows(a) ? 0 : 1;
      if (open && open.kind === kind) open.count += count;
      else {
        if (open) geometry.addGroup(open.start, open.count, open.kind);
        open = { start, count, kind };
      }
    });
    geometry.addGroup(open.start, open.count, open.kind);
    // A few rods alone may be seen better than many through one another.
    this.future.material[0].opacity = this.state.selected.size ? 0.6 : 0.3;
  }

  listenToPointer() {
    const { canvas, state } = this;
    let pressed = null;
    canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons === 0) this.pointed = event;
    });
    canvas.addEventListener("pointerleave", () => {
      this.pointed = null;
      state.hover(null);
    });
    canvas.addEventListener("pointerup", (event) => {
      if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;
      const hit = this.pick(event);
      state.select(hit ? [hit.agent] : []);
    });
  }

  /** The agent whose rod is under the pointer, and the time there. */
  pick(event) {
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(
      ((event.clientX - box.left) / box.width) * 2 - 1,
      1 - ((event.clientY - box.top) / box.height) * 2,
    );
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    for (const { faceIndex, point } of ray.intersectObject(this.past)) {
      const agent = this.ranges.findIndex(({ start, count }) => 3 * faceIndex < start + count);
      if (this.state.shows(agent)) return { agent, time: this.run.begin + point.z / this.pace };
    }
    return null;
  }

  draw() {
    if (this.pointed) {
      const hit = this.pick(this.pointed);
      const { clientX: x, clientY: y } = this.pointed;
      this.state.pointer = { x, y, time: hit ? hit.time : null };
      this.canvas.style.cursor = hit ? "pointer" : "grab";
      this.state.hover(hit ? hit.agent : null);
      this.pointed = null;
    }
    if (fit(this.canvas)) {
      this.renderer.setViewport(0, 0, this.canvas.width, this.canvas.height);
      this.camera.aspect = this.canvas.width / this.canvas.height;
      this.camera.updateProjectionMatrix();
      if (!this.placed) this.showAll();
      this.placed = this.dirty = true;
    }
    if (!this.dirty) return;
    this.dirty = false;
    this.moveTime();
    this.renderer.render(this.scene, this.camera);
  }

  moveTime() {
    const z = this.height(this.state.time);
    this.below.constant = z;
    this.above.constant = -z;
    this.time.position.z = z;
    const place = [0, 0];
    const matrix = new THREE.Matrix4();
    this.run.agents.forEach(({ radius }, a) => {
      const there = this.run.place(a, this.state.time, place) && this.state.shows(a);
      const size = there ? radius * 1.02 : 0;
      matrix.makeScale(size, size, 1).setPosition(place[0], place[1], z + this.size * 5e-4);
      this.discs.setMatrixAt(a, matrix);
    });
    this.discs.instanceMatrix.needsUpdate = true;
  }
}
