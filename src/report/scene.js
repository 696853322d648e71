// The bodies in space, by three.js.
const canvas = document.getElementById("scene");

// Coordinates as steps of the parts' boxes, frame by frame: the inverse of `positions` in src/report/pack.rs.
function unpackPositions(bytes, n, nFrames) {
  const frames = [], now = new Uint16Array(3 * n);
  let low = 0;
  for (let frame = 0; frame < nFrames; frame += 1) {
    for (let axis = 0; axis < 3; axis += 1) {
      const high = low + n;
      let change = 0;
      for (let i = 0; i < n; i += 1) {
        const coded = bytes[low + i] | bytes[high + i] << 8;
        change = change + (coded >>> 1 ^ -(coded & 1)) & 65535;
        now[3 * i + axis] += change;
      }
      low = high + n;
    }
    frames.push(now.slice());
  }
  return frames;
}

function unpackTriangles(bytes) {
  const n = bytes.length / 4, corners = new Uint32Array(n);
  let last = 0;
  for (let i = 0; i < n; i += 1) {
    const coded = bytes[i] | bytes[n + i] << 8 | bytes[2 * n + i] << 16 | bytes[3 * n + i] << 24;
    last += coded >>> 1 ^ -(coded & 1);
    corners[i] = last;
  }
  return corners;
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
    parts: packed.parts, n, frames: unpackPositions(new Uint8Array(positions), n, packed.frames),
    corners: unpackTriangles(new Uint8Array(triangles)),
    position: new THREE.BufferAttribute(new Float32Array(3 * n), 3),
    colour: new THREE.BufferAttribute(new Float32Array(3 * n), 3),
  };
  surface.rest = new Float32Array(3 * n);
  place(surface, 0, surface.rest);
  surface.position.array.set(surface.rest);
  return surface;
}

const BODIES = ["#2f7fd6", "#e2743a", "#35a060", "#9c5bd0", "#c99a1e", "#1f9aa5", "#d4548d", "#7b8694"];
const OTHER = "#a9b2bf";

// A colour of the scale of the cuts, from 0 to 1.
const SCALE = ["#440154", "#472f7d", "#39568c", "#2a788e", "#1f988b", "#35b779", "#7ad151", "#d2e21b", "#fde725"];
const scale = [];
function scaleColour(value, into, at) {
  if (!scale.length) scale.push(...SCALE.map((name) => new THREE.Color(name)));
  const place = Math.min(1, Math.max(0, value)) * (SCALE.length - 1);
  const below = Math.min(SCALE.length - 2, Math.floor(place)), part = place - below;
  const [a, b] = [scale[below], scale[below + 1]];
  into[at] = a.r + part * (b.r - a.r);
  into[at + 1] = a.g + part * (b.g - a.g);
  into[at + 2] = a.b + part * (b.b - a.b);
}

class Stage {
  constructor(packed, bodies, others) {
    Object.assign(this, { packed, bodies, others, frame: -1, isColoured: false });
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.scene = new THREE.Scene();
    this.turning = new THREE.Group();
    this.turning.matrixAutoUpdate = false;
    this.scene.add(this.turning, new THREE.AmbientLight("#ffffff", 1.1));
    this.camera = new THREE.PerspectiveCamera(30, 1.4, packed.camera.radius * 1e-3, packed.camera.radius * 100);
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
    this.farthest = this.largestDisplacement();
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
    const { centre, radius, depth, towards, up } = this.packed.camera;
    this.camera.up.set(...up);
    const away = radius / Math.tan(this.camera.fov / 2 * Math.PI / 180) + depth;
    this.camera.position.set(...towards).normalize().multiplyScalar(away).add(new THREE.Vector3(...centre));
    this.controls.target.set(...centre);
    this.controls.update();
    this.draw();
  }

  // Frame 0 is the reference mesh.
  show(frame) {
    this.frame = frame;
    place(this.bodies, frame + 1, this.bodies.position.array);
    this.bodies.position.needsUpdate = true;
    if (this.isColoured) this.colourIn();
    const { axis, hub, turns_deg: turns } = this.packed;
    const turn = new THREE.Matrix4().makeRotationAxis(new THREE.Vector3(...axis).normalize(), (turns[frame] ?? 0) * Math.PI / 180);
    const there = new THREE.Matrix4().makeTranslation(...hub), back = new THREE.Matrix4().makeTranslation(...hub.map((x) => -x));
    this.turning.matrix.copy(there.multiply(turn).multiply(back));
    this.turning.matrixWorldNeedsUpdate = true;
    this.draw();
  }

  colourIn() {
    const { position, rest, colour, n } = this.bodies, now = position.array;
    for (let i = 0; i < 3 * n; i += 3) {
      const by = Math.hypot(now[i] - rest[i], now[i + 1] - rest[i + 1], now[i + 2] - rest[i + 2]);
      scaleColour(this.farthest > 0 ? by / this.farthest : 0, colour.array, i);
    }
    colour.needsUpdate = true;
  }

  set coloured(isColoured) {
    this.isColoured = isColoured;
    for (const { isBody, solid, colour } of this.parts.filter((shown) => shown.isBody)) {
      solid.material.vertexColors = isColoured;
      solid.material.color.set(isColoured ? "#ffffff" : colour);
      solid.material.needsUpdate = true;
    }
    if (isColoured) this.colourIn();
    this.draw();
  }

  // Once for all changes before the next frame of the screen.
  draw() {
    if (this.isWaiting) return;
    this.isWaiting = true;
    requestAnimationFrame(() => {
      this.isWaiting = false;
      this.renderer.render(this.scene, this.camera);
      canvas.dataset.drawn = Number(canvas.dataset.drawn ?? 0) + 1;
      canvas.dataset.frame = this.frame;
    });
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
  const choices = document.getElementById("scene-choices"), key = document.getElementById("scene-key");
  for (const { part, group, colour } of stage.parts) {
    choices.append(choice(part.name, part.shown, (isOn) => { group.visible = isOn; stage.draw(); }, colour));
  }
  const all = (members, isOn) => { for (const member of members) member.visible = isOn; stage.draw(); };
  choices.append(
    choice("colour by displacement", false, (isOn) => { stage.coloured = isOn; key.hidden = !isOn; }),
    choice("triangle edges", false, (isOn) => all(stage.parts.map(({ wires }) => wires), isOn)),
    choice("reference shape", false, (isOn) => all(stage.ghosts, isOn)),
  );
  key.querySelector(".most").textContent = `${short(String(stage.farthest))} ${data.unit}`;
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
  const [bodies, others] = await Promise.all([surfaceOf(packed.bodies), surfaceOf(packed.others)]);
  const stage = new Stage(packed, bodies, others);
  keysOf(stage);
  choicesOf(stage);
  stage.resize();
  for (const image of document.querySelectorAll("img.solid")) {
    image.src = stage.picture(Number(image.dataset.frame));
    image.hidden = false;
  }
  new ResizeObserver(() => stage.resize()).observe(canvas.parentElement);
  const follow = (stop) => {
    if (stage.frame !== pictureOf[stop]) stage.show(pictureOf[stop]);
  };
  followers.push(follow);
  follow(Number(slider.value));
  const context = stage.renderer.getContext(), told = context.getExtension("WEBGL_debug_renderer_info");
  canvas.dataset.renderer = told ? context.getParameter(told.UNMASKED_RENDERER_WEBGL) : context.getParameter(context.RENDERER);
  canvas.dataset.ready = stage.bodies.frames.length;
}

if (slider && canvas) {
  raise(JSON.parse(document.getElementById("scene-data").textContent))
    .catch((error) => showNoSpace(`The bodies cannot be shown in space: ${error.message}.`))
    .finally(() => show(Number(slider.value)));
}
if (slider) show(0);
