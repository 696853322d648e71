// The bodies in space, by three.js.
const canvas = document.getElementById("scene");

// Coordinates as steps of the parts' boxes, frame by frame: the inverse of `data` in scene.rs, like the two below.
function unpackPositions(changes, n, nFrames) {
  const frames = [], now = new Uint16Array(3 * n);
  let at = 0;
  for (let frame = 0; frame < nFrames; frame += 1) {
    for (let axis = 0; axis < 3; axis += 1) {
      let change = 0;
      for (let i = axis; i < 3 * n; i += 3) {
        change += changes[at++];
        now[i] += change;
      }
    }
    frames.push(now.slice());
  }
  return frames;
}

function unpackTriangles(corners) {
  let lowest = 0;
  for (let i = 0; i < corners.length; i += 3) {
    lowest += corners[i];
    corners[i] = lowest;
    corners[i + 1] += lowest;
    corners[i + 2] += lowest;
  }
  return corners;
}

function unpackColours(changes, n) {
  for (let i = n; i < changes.length; i += 1) changes[i] += changes[i - n];
  return changes;
}

// Positions at a frame.
function place(surface, frame, into) {
  const steps = surface.frames[frame];
  for (const part of surface.parts) {
    const [x, y, z] = part.low, [dx, dy, dz] = part.step;
    for (let i = 3 * part.from; i < 3 * part.to; i += 3) {
      into[i] = x + dx * steps[i];
      into[i + 1] = y + dy * steps[i + 1];
      into[i + 2] = z + dz * steps[i + 2];
    }
  }
}

async function surfaceOf(packed) {
  const [positions, triangles] = await Promise.all([unpacked(packed.positions), unpacked(packed.triangles)]);
  const n = packed.vertices;
  const surface = {
    parts: packed.parts, n, frames: unpackPositions(new Int16Array(positions), n, packed.frames),
    corners: unpackTriangles(new Uint32Array(triangles)),
    position: new THREE.BufferAttribute(new Float32Array(3 * n), 3),
    colour: new THREE.BufferAttribute(new Float32Array(3 * n), 3),
  };
  surface.rest = new Float32Array(3 * n);
  place(surface, 0, surface.rest);
  surface.position.array.set(surface.rest);
  return surface;
}

const BODIES = ["#2f7fd6", "#e2743a", "#35a060", "#9c5bd0", "#c99a1e", "#1f9aa5", "#d4548d", "#7b8694"];
const OTHER = "#a9b2bf", WORST = "#ff1744";

// The colours of the classes q0 to q17 of the style sheet.
function palette() {
  const colours = [];
  for (const path of document.querySelectorAll("#key-quality path")) colours[path.classList[0].slice(1)] = new THREE.Color(getComputedStyle(path).fill);
  return colours;
}

class Stage {
  constructor(packed, bodies, others, qualities) {
    Object.assign(this, { packed, bodies, others, frame: -1, field: "", palette: palette() });
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.scene = new THREE.Scene();
    this.turning = new THREE.Group();
    this.turning.matrixAutoUpdate = false;
    this.scene.add(this.turning, new THREE.AmbientLight("#ffffff", 1.1));
    this.qualities = qualities;
    this.view = this.firstView();
    this.camera = new THREE.PerspectiveCamera(30, 1.4, this.view.radius * 1e-3, this.view.radius * 100);
    const light = new THREE.DirectionalLight("#ffffff", 2.4);
    light.position.set(-0.35, 0.75, 0.9);
    this.camera.add(light);
    this.scene.add(this.camera);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableZoom = false;
    this.controls.addEventListener("change", () => this.draw());
    // A finger that goes up or down moves the page.
    canvas.style.touchAction = "pan-y";
    this.parts = [];
    this.ghosts = [];
    this.fill(bodies, true);
    this.fill(others, false);
    this.addWorst();
    this.farthest = this.largestDisplacement();
    canvas.insertAdjacentHTML("afterend", '<svg class="triad" viewBox="-46 -46 92 92" aria-hidden="true"></svg>');
    this.triad = canvas.nextSibling;
    this.reset();
  }

  fill(surface, isBody) {
    let first = 0;
    surface.parts.forEach((part, at) => {
      const end = first + 3 * part.triangles;
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", surface.position);
      geometry.setAttribute("color", surface.colour);
      geometry.setIndex(new THREE.BufferAttribute(surface.corners.slice(first, end), 1));
      first = end;
      const material = new THREE.MeshLambertMaterial({
        color: isBody ? BODIES[at % BODIES.length] : OTHER, flatShading: true, side: THREE.DoubleSide,
        polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
      });
      const solid = new THREE.Mesh(geometry, material);
      const wires = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color: "#000000", wireframe: true, transparent: true, opacity: 0.28 }));
      wires.visible = false;
      const group = new THREE.Group();
      group.add(solid, wires);
      group.visible = part.shown;
      for (const mesh of [solid, wires]) mesh.frustumCulled = false;
      (part.turns ? this.turning : this.scene).add(group);
      this.parts.push({ part, isBody, group, solid, wires, colour: `#${material.color.getHexString()}` });
      if (isBody) this.addGhost(surface, geometry.index);
    });
  }

  addGhost(surface, index) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(surface.rest, 3));
    geometry.setIndex(index);
    const material = new THREE.MeshLambertMaterial({ color: OTHER, flatShading: true, side: THREE.DoubleSide, transparent: true, opacity: 0.35, depthWrite: false });
    const ghost = new THREE.Mesh(geometry, material);
    ghost.visible = false;
    this.ghosts.push(ghost);
    this.turning.add(ghost);
  }

  // A mark at the worst cell, seen through everything.
  addWorst() {
    const ends = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
    const geometry = new THREE.BufferGeometry().setFromPoints(ends.map((end) => new THREE.Vector3(...end)));
    geometry.setIndex([0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5]);
    this.worst = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color: WORST, depthTest: false, transparent: true, opacity: 0.85 }));
    this.worst.renderOrder = 1;
    this.worst.scale.setScalar(0.02 * this.view.radius);
    this.worst.visible = false;
    this.scene.add(this.worst);
  }

  turnOf(frame) {
    const { axis, hub, turns_deg: turns } = this.packed;
    const turn = new THREE.Matrix4().makeRotationAxis(new THREE.Vector3(...axis).normalize(), (turns[frame] ?? 0) * Math.PI / 180);
    const there = new THREE.Matrix4().makeTranslation(...hub), back = new THREE.Matrix4().makeTranslation(...hub.map((x) => -x));
    return there.multiply(turn).multiply(back);
  }

  // From above, along the thinnest extent of what moves, and from the side of the bodies where other parts are beside them;
  // near enough that all of it is in view at all steps.
  firstView() {
    const { bodies, others } = this, seen = [], now = new Float32Array(3 * bodies.n), every = Math.max(1, Math.floor(bodies.n / 2000));
    for (let frame = 1; frame < bodies.frames.length; frame += 1) {
      place(bodies, frame, now);
      const turn = this.turnOf(frame - 1);
      for (let i = 0; i < bodies.n; i += every) seen.push(new THREE.Vector3().fromArray(now, 3 * i).applyMatrix4(turn));
    }
    for (const { from, to } of others.parts.filter(({ shown }) => shown)) {
      for (let i = from; i < to; i += 1) seen.push(new THREE.Vector3().fromArray(others.rest, 3 * i));
    }
    const boxOf = (geometry) => (geometry.computeBoundingBox(), geometry.boundingBox);
    const middle = (box) => box.getCenter(new THREE.Vector3());
    const box = boxOf(new THREE.BufferGeometry().setFromPoints(seen)), centre = middle(box), extent = box.getSize(new THREE.Vector3()).toArray();
    const aside = middle(boxOf(new THREE.BufferGeometry().setAttribute("position", bodies.position))).sub(centre).toArray();
    const [thin, , long] = [2, 0, 1].sort((a, b) => extent[a] - extent[b]);
    const side = (axis, rest) => (Math.abs(aside[axis]) > 0.02 * extent[axis] ? Math.sign(aside[axis]) : rest);
    const towards = [0, 1, 2].map((axis) => (axis === thin ? 0.55 : axis === long ? 0.5 * side(axis, 1) : 0.75 * side(axis, -1)));
    const up = new THREE.Vector3().setComponent(thin, 1), eye = new THREE.Vector3(...towards).normalize();
    const right = new THREE.Vector3().crossVectors(up, eye).normalize(), top = new THREE.Vector3().crossVectors(eye, right);
    // The worst cells too, where they are near the bodies.
    const worst = this.packed.worst.filter((at) => at).map((at) => new THREE.Vector3(...at));
    seen.push(...worst.filter((at) => box.distanceToPoint(at) < 0.2 * Math.max(...extent)));
    let radius = 1e-30, depth = 0;
    for (const point of seen) {
      point.sub(centre);
      radius = Math.max(radius, 1.08 * Math.abs(point.dot(top)), 1.08 * Math.abs(point.dot(right)) * 0.7);
      depth = Math.max(depth, point.dot(eye));
    }
    return { centre, radius, depth, eye, up };
  }

  largestDisplacement() {
    const { bodies } = this, { rest } = bodies, now = new Float32Array(3 * bodies.n);
    let most = 0;
    for (let frame = 1; frame < bodies.frames.length; frame += 1) {
      place(bodies, frame, now);
      for (let i = 0; i < 3 * bodies.n; i += 3) {
        const x = now[i] - rest[i], y = now[i + 1] - rest[i + 1], z = now[i + 2] - rest[i + 2];
        most = Math.max(most, x * x + y * y + z * z);
      }
    }
    return Math.sqrt(most);
  }

  reset() {
    const { centre, radius, depth, eye, up } = this.view;
    const away = radius / Math.tan(this.camera.fov / 2 * Math.PI / 180) + depth;
    this.camera.up.copy(up);
    this.camera.position.copy(eye).multiplyScalar(away).add(centre);
    this.controls.target.copy(centre);
    this.controls.update();
    this.draw();
  }

  // Frame -1 is the reference mesh.
  show(frame) {
    this.frame = frame;
    place(this.bodies, frame + 1, this.bodies.position.array);
    this.bodies.position.needsUpdate = true;
    if (this.field) this.colourIn();
    this.turning.matrix.copy(this.turnOf(frame));
    this.turning.matrixWorldNeedsUpdate = true;
    const worst = this.packed.worst[frame + 1];
    if (worst) this.worst.position.set(...worst);
    this.worst.visible = this.marksWorst && worst !== null;
    this.draw();
  }

  // Colours a field: the displacement, from class 16 of the palette to class 1, or the class of the quality.
  colourIn() {
    const { position, rest, colour, n } = this.bodies, now = position.array, mixed = new THREE.Color();
    for (let i = 0, at = 0; i < n; i += 1, at += 3) {
      if (this.field === "quality") {
        this.palette[this.qualities[(this.frame + 1) * n + i]].toArray(colour.array, at);
        continue;
      }
      const by = Math.hypot(now[at] - rest[at], now[at + 1] - rest[at + 1], now[at + 2] - rest[at + 2]);
      const step = this.farthest > 0 ? Math.min(15, 15 * by / this.farthest) : 0, below = Math.min(14, Math.floor(step));
      mixed.lerpColors(this.palette[16 - below], this.palette[15 - below], step - below).toArray(colour.array, at);
    }
    colour.needsUpdate = true;
  }

  setField(field) {
    this.field = field;
    for (const { solid, colour } of this.parts.filter(({ isBody }) => isBody)) {
      solid.material.vertexColors = field !== "";
      solid.material.color.set(field ? "#ffffff" : colour);
      solid.material.needsUpdate = true;
    }
    if (field) this.colourIn();
    this.draw();
  }

  // Once for all changes before the next frame of the screen.
  draw() {
    if (this.isWaiting) return;
    this.isWaiting = true;
    requestAnimationFrame(() => {
      this.isWaiting = false;
      this.renderer.render(this.scene, this.camera);
      this.drawTriad();
      canvas.dataset.frame = this.frame;
    });
  }

  // The directions of the axes, the nearest one over the others.
  drawTriad() {
    const seen = this.camera.matrixWorldInverse.elements;
    const axes = ["x", "y", "z"].map((name, axis) => ({ name, right: seen[4 * axis], down: -seen[4 * axis + 1], near: seen[4 * axis + 2] }));
    this.triad.innerHTML = axes.sort((a, b) => a.near - b.near).map(({ name, right, down }) =>
      `<path class="${name}" d="M0 0L${26 * right} ${26 * down}"/><text x="${37 * right}" y="${37 * down + 4}">${name}</text>`).join("");
  }

  // A picture of a frame in the first view.
  picture(frame) {
    this.show(frame);
    this.renderer.render(this.scene, this.camera);
    return canvas.toDataURL();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  turn(right, up) {
    const arm = this.camera.position.clone().sub(this.controls.target);
    const axis = this.camera.up.clone().normalize();
    arm.applyAxisAngle(axis, right);
    const side = new THREE.Vector3().crossVectors(axis, arm).normalize();
    const raised = arm.clone().applyAxisAngle(side, up);
    const angle = raised.angleTo(axis);
    this.camera.position.copy(this.controls.target).add(angle > 0.05 && angle < Math.PI - 0.05 ? raised : arm);
    this.controls.update();
    this.draw();
  }

  zoom(factor) {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
    this.draw();
  }
}

function keysOf(stage) {
  const angle = Math.PI / 18;
  const acts = {
    ArrowLeft: () => stage.turn(-angle, 0), ArrowRight: () => stage.turn(angle, 0), ArrowUp: () => stage.turn(0, -angle), ArrowDown: () => stage.turn(0, angle),
    "+": () => stage.zoom(0.8), "-": () => stage.zoom(1.25), 0: () => stage.reset(),
  };
  canvas.addEventListener("keydown", (event) => {
    if (!acts[event.key]) return;
    event.preventDefault();
    acts[event.key]();
  });
  // The wheel moves the page until someone has clicked here.
  canvas.addEventListener("focus", () => { stage.controls.enableZoom = true; });
  canvas.addEventListener("blur", () => { stage.controls.enableZoom = false; });
  canvas.addEventListener("pointerdown", () => canvas.focus({ preventScroll: true }));
  for (const button of document.querySelectorAll("[data-view]")) button.addEventListener("click", () => acts[button.dataset.view]());
}

function choice(text, isOn, act, swatch) {
  const label = document.createElement("label"), box = document.createElement("input");
  box.type = "checkbox";
  box.checked = isOn;
  box.addEventListener("change", () => act(box.checked));
  label.append(box);
  if (swatch) {
    const chip = document.createElement("span");
    chip.className = "chip";
    chip.style.background = swatch;
    label.append(chip);
  }
  label.append(text);
  return label;
}

function choicesOf(stage) {
  const choices = document.getElementById("scene-choices"), field = document.getElementById("field");
  for (const { part, group, colour } of stage.parts) {
    choices.append(choice(part.name, part.shown, (isOn) => { group.visible = isOn; stage.draw(); }, colour));
  }
  const all = (members, isOn) => { for (const member of members) member.visible = isOn; stage.draw(); };
  choices.append(
    choice("worst cell", true, (isOn) => { stage.marksWorst = isOn; stage.show(stage.frame); }, WORST),
    choice("triangle edges", false, (isOn) => all(stage.parts.map(({ wires }) => wires), isOn)),
    choice("reference shape", false, (isOn) => all(stage.ghosts, isOn)),
  );
  field.addEventListener("change", () => {
    stage.setField(field.value);
    for (const name of ["displacement", "quality"]) document.getElementById(`key-${name}`).hidden = field.value !== name;
  });
  document.querySelector("#key-displacement .most").textContent = `${short(String(stage.farthest))} ${data.unit}`;
}

function showNoSpace(why) {
  const note = document.getElementById("scene-note");
  note.textContent = why;
  note.hidden = false;
  canvas.parentElement.hidden = true;
  document.getElementById("scene-tools").hidden = true;
}

async function raise(packed) {
  if (!document.createElement("canvas").getContext("webgl2")) {
    showNoSpace("This browser offers no WebGL, so the bodies are not shown in space.");
    return;
  }
  const [bodies, others, qualities] = await Promise.all([surfaceOf(packed.bodies), surfaceOf(packed.others), unpacked(packed.quality)]);
  const stage = new Stage(packed, bodies, others, unpackColours(new Uint8Array(qualities), bodies.n));
  stage.marksWorst = true;
  keysOf(stage);
  choicesOf(stage);
  stage.resize();
  for (const image of document.querySelectorAll("img.solid")) {
    image.src = stage.picture(image.parentElement.dataset.picture - 1);
    image.hidden = false;
    stage.drawTriad();
    image.after(stage.triad.cloneNode(true));
  }
  new ResizeObserver(() => stage.resize()).observe(canvas.parentElement);
  const follow = (stop) => {
    if (stage.frame !== pictureOf[stop]) stage.show(pictureOf[stop]);
  };
  followers.push(follow);
  follow(Number(slider.value));
  canvas.dataset.ready = stage.bodies.frames.length;
}

if (slider && canvas) {
  raise(JSON.parse(document.getElementById("scene-data").textContent))
    .catch((error) => showNoSpace(`The bodies cannot be shown in space: ${error.message}.`))
    .finally(() => show(Number(slider.value)));
}
if (slider) show(0);
