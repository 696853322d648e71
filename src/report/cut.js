// The cut: cells and boundaries at a plane, on the axes of uPlot. The wheel, fingers, keys and buttons zoom and move it.

// Numbers that `packed_numbers` in html.rs has written.
async function numbersOf(text) {
  const bytes = new Uint8Array(await unpacked(text)), n = bytes.length / 4, all = new Uint32Array(n);
  for (let i = 0, last = 0; i < n; i += 1) {
    last += bytes[i] | bytes[n + i] << 8 | bytes[2 * n + i] << 16 | bytes[3 * n + i] << 24;
    all[i] = last;
  }
  return all;
}

async function cutOf(packed) {
  const floats = async (text) => new Float32Array((await numbersOf(text)).buffer);
  const [rest, values, coefficients, colours, groups] = await Promise.all([
    floats(packed.rest), floats(packed.values), floats(packed.coefficients), unpacked(packed.colours),
    Promise.all(packed.groups.map(async ({ name, body, shapes, nodes }) => ({ name, body, shapes: await numbersOf(shapes), nodes: await numbersOf(nodes) }))),
  ]);
  const n = groups[0].shapes.length, [cells, ...walls] = groups;
  return { ...packed, rest, values, coefficients, colours: unpackColours(new Uint8Array(colours), n), n, cells, walls, frame: -1 };
}

// Coordinates of the vertices at a frame, one axis after another.
function placesOf(cut, frame) {
  const { vertices, modes } = cut, places = cut.rest.slice();
  for (let axis = 0; axis < places.length / vertices; axis += 1) {
    for (let mode = 0; mode < modes; mode += 1) {
      const weight = cut.coefficients[(frame * modes + mode) * 3 + axis];
      if (weight) for (let i = 0; i < vertices; i += 1) places[axis * vertices + i] += weight * cut.values[mode * vertices + i];
    }
  }
  return places;
}

// Lines around the parts of the members of a group that are in the plane: x and y in turn; and the index of the member. In 3D as in section.rs.
function linesOf(cut, group, places) {
  const n = cut.vertices, isSolid = places.length > 2 * n, lines = [];
  const local = cut.shapes.map((sides) => 1 + Math.max(...sides.flat()));
  let at = 0;
  group.shapes.forEach((shape, member) => {
    const from = at, sides = cut.shapes[shape], node = (corner) => group.nodes[from + corner], isUp = (corner) => places[2 * n + node(corner)] >= 0;
    at += local[shape];
    if (!isSolid) {
      lines.push({ member, line: sides[0].flatMap((corner) => [places[node(corner)], places[n + node(corner)]]) });
      return;
    }
    let nUp = 0;
    for (let corner = 0; corner < local[shape]; corner += 1) nUp += isUp(corner);
    if (nUp === 0 || nUp === local[shape]) return;
    const segments = [];
    for (const side of sides) {
      const crossed = side.map((a, i) => [a, side[(i + 1) % side.length]]).filter(([a, b]) => isUp(a) !== isUp(b));
      if (crossed.length && !isUp(crossed[0][0])) crossed.push(crossed.shift());
      for (let i = 0; i < crossed.length; i += 2) segments.push([crossed[i], crossed[i + 1]].map(([a, b]) => (a < b ? 65536 * a + b : 65536 * b + a)));
    }
    while (segments.length) {
      const [first, second] = segments.pop(), edges = [first];
      for (let end = second; end !== first;) {
        edges.push(end);
        const next = segments.findIndex((segment) => segment.includes(end));
        if (next < 0) break;
        const [[a, b]] = segments.splice(next, 1);
        end = a === end ? b : a;
      }
      lines.push({ member, line: edges.flatMap((edge) => {
        const [a, b] = [node(edge >> 16), node(edge & 65535)].sort((one, other) => one - other), part = places[2 * n + a] / (places[2 * n + a] - places[2 * n + b]);
        return [0, n].map((axis) => places[axis + a] + part * (places[axis + b] - places[axis + a]));
      }) });
    }
  });
  return lines;
}

// Lines joined where they meet, so that dashes go on.
function joined(lines) {
  const touching = new Map(), key = (line, at) => `${line.at(at)},${line.at(at + 1)}`, used = new Set();
  for (const { line } of lines) for (const end of [key(line, 0), key(line, -2)]) touching.set(end, [...(touching.get(end) ?? []), line]);
  return lines.flatMap(({ line }) => {
    if (used.has(line)) return [];
    const chain = [...line];
    for (let next = line; next;) {
      used.add(next);
      const end = key(chain, -2);
      next = touching.get(end).find((other) => !used.has(other));
      if (next) chain.push(...(key(next, 0) === end ? next.slice(2) : next.slice(0, 2)));
    }
    return [{ line: chain }];
  });
}

// The lines at a frame: cells, boundaries, and bodies in the reference mesh. The last frames are kept.
function stateOf(cut, frame) {
  cut.states ??= new Map();
  if (!cut.states.has(frame)) {
    if (cut.states.size > 7) cut.states.delete(cut.states.keys().next().value);
    const places = placesOf(cut, frame);
    cut.states.set(frame, { cells: linesOf(cut, cut.cells, places), walls: cut.walls.map((wall) => joined(linesOf(cut, wall, places))) });
  }
  return cut.states.get(frame);
}

// Draws cells in the order of their colours, and boundaries over them; the number of cells in view. A canvas that is often read has no
// graphics card under it, for which thousands of small paths are slow.
function drawCut(u, cut, frame) {
  const { bbox } = u, state = stateOf(cut, frame), dot = devicePixelRatio;
  cut.canvas ??= document.createElement("canvas");
  Object.assign(cut.canvas, { width: bbox.width, height: bbox.height });
  const ctx = cut.canvas.getContext("2d", { willReadFrequently: true });
  const scale = bbox.width / (u.scales.x.max - u.scales.x.min);
  const x0 = (cut.centre[0] - u.scales.x.min) * scale, y0 = (u.scales.y.max - cut.centre[1]) * scale;
  const trace = (path, line) => {
    for (let i = 0; i < line.length; i += 2) path[i ? "lineTo" : "moveTo"](x0 + line[i] * scale, y0 - line[i + 1] * scale);
  };
  const kinds = [], seen = new Set();
  for (const { member, line } of state.cells) {
    let left = Infinity, right = -Infinity, low = Infinity, high = -Infinity;
    for (let i = 0; i < line.length; i += 2) {
      left = Math.min(left, line[i]); right = Math.max(right, line[i]);
      low = Math.min(low, line[i + 1]); high = Math.max(high, line[i + 1]);
    }
    if (x0 + right * scale < 0 || x0 + left * scale > bbox.width || y0 - low * scale < 0 || y0 - high * scale > bbox.height) continue;
    seen.add(member);
    const hasEdges = Math.min(right - left, high - low) * scale > 3 * dot;
    (kinds[2 * cut.colours[frame * cut.n + member] + hasEdges] ??= []).push(line);
  }
  const fills = [];
  for (const path of document.querySelectorAll(".cut .key path")) fills[path.classList[0].slice(1)] = getComputedStyle(path).fill;
  ctx.lineWidth = 0.5 * dot;
  kinds.forEach((lines, kind) => {
    ctx.fillStyle = fills[kind >> 1];
    ctx.strokeStyle = kind & 1 ? "#0006" : ctx.fillStyle;
    for (let first = 0; first < lines.length; first += 64) {
      const path = new Path2D();
      for (const line of lines.slice(first, first + 64)) {
        trace(path, line);
        path.closePath();
      }
      ctx.fill(path);
      ctx.stroke(path);
    }
  });
  const draw = (lines, style, width, dash) => {
    const path = new Path2D();
    for (const { line } of lines) trace(path, line);
    Object.assign(ctx, { strokeStyle: style, lineWidth: width * dot });
    ctx.setLineDash(dash.map((length) => length * dot));
    ctx.stroke(path);
  };
  cut.walls.forEach(({ body }, at) => body && frame > 0 && draw(stateOf(cut, 0).walls[at], "#e11d48", 1.2, [4, 3]));
  cut.walls.forEach(({ body }, at) => draw(state.walls[at], body ? "#e11d48" : "#111", body ? 1.8 : 1.4, []));
  u.ctx.drawImage(cut.canvas, bbox.left, bbox.top);
  return seen.size;
}

// Round marks, of which each has a text.
function placeMarks(u, marks) {
  u.over.querySelectorAll(".mark").forEach((mark) => mark.remove());
  for (const [[x, y], text] of marks) {
    const mark = document.createElement("span"), [left, top] = [u.valToPos(x, "x"), u.valToPos(y, "y")];
    if (left < 0 || top < 0 || left > u.over.clientWidth || top > u.over.clientHeight) continue;
    Object.assign(mark, { className: "mark", title: text });
    Object.assign(mark.style, { left: `${left}px`, top: `${top}px` });
    u.over.append(mark);
  }
}

const AXES = { left: 58, below: 32, label: 18, right: 12, top: 8 };
const heightOfCut = (width) => Math.round(0.7 * (width - AXES.left - AXES.label - AXES.right) + AXES.below + AXES.label + AXES.top);

// A picture of the cut in a box. Its view is a place beside the centre of the frame and half a width.
function panel(box, cut, frame) {
  const shown = { box, cut, frame, view: { x: 0, y: 0, half: cut.half }, height: heightOfCut };
  const range = (axis) => () => {
    const { x, y, half } = shown.view, [a, b] = cut.frames[shown.frame].centre;
    const { width, height } = shown.live ?? { width: box.clientWidth, height: heightOfCut(box.clientWidth) };
    const [wide, high] = [width - AXES.left - AXES.label - AXES.right, height - AXES.below - AXES.label - AXES.top];
    return axis === "x" ? [a + x - half, a + x + half] : [b + y - half * high / wide, b + y + half * high / wide];
  };
  const font = '12px system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif';
  const axis = (at, size) => ({
    label: `${cut.axes[at]}, ${data.unit}`, labelSize: AXES.label, size, font, labelFont: font, stroke: () => colour("--soft"), grid: { show: false },
    ticks: { stroke: () => colour("--soft"), width: 1, size: 6 }, space: at ? 40 : 64,
    values: (u, splits) => splits.map((value) => fine(value, splits[1] - splits[0])),
  });
  const clear = { x: false, y: false };
  shown.live = new uPlot({
    width: box.clientWidth, height: heightOfCut(box.clientWidth), legend: { show: false }, pxAlign: 0, padding: [AXES.top, AXES.right, 0, 0],
    scales: { x: { time: false, range: range("x") }, y: { range: range("y") } }, axes: [axis(0, AXES.below), axis(1, AXES.left)],
    series: [{}, { show: false }], cursor: { ...clear, drag: clear, points: { show: false }, bind: { dblclick: () => null } },
    hooks: { draw: [(u) => {
      box.dataset.seen = drawCut(u, cut, shown.frame);
      box.dataset.frame = shown.frame;
      box.dataset.outlines = cut.walls.filter((_, at) => stateOf(cut, shown.frame).walls[at].length).map(({ name }) => name).join(";");
      placeMarks(u, cut.frames[shown.frame].marks);
    }] },
  }, [[0, 1], [0, 1]], box);
  shown.live.root.ariaHidden = "true";
  plots.push(shown);
  return shown;
}

// A value of an axis, in as many digits as its steps need.
function fine(value, step) {
  const size = Math.max(Math.abs(value), Math.abs(step)), digits = Math.ceil(Math.log10(size / step)) + 2;
  return short(String(Number(value.toPrecision(Math.min(12, Math.max(1, digits)))))).replace("-", "\u2212");
}

// Zoom about a place of the picture, moves, and first views.
function steer(shown) {
  const { box, cut, live } = shown, pointers = new Map();
  const redraw = () => live.setData(live.data);
  const all = Math.max(...cut.rest.subarray(0, 2 * cut.vertices).map(Math.abs));
  const zoom = (factor, at = [0.5, 0.5]) => {
    const { view } = shown, half = Math.min(2 * Math.max(all, cut.half), Math.max(1e-6 * cut.half, view.half * factor)), change = view.half - half;
    const tall = (live.scales.y.max - live.scales.y.min) / (live.scales.x.max - live.scales.x.min);
    shown.view = { half, x: view.x + change * (2 * at[0] - 1), y: view.y + change * (1 - 2 * at[1]) * tall };
    redraw();
  };
  const move = (right, up) => { shown.view.x += right * shown.view.half; shown.view.y += up * shown.view.half; redraw(); };
  const views = { first: () => { shown.view = { x: 0, y: 0, half: cut.half }; redraw(); }, whole: () => {
    const { centre } = cut.frames[shown.frame], n = cut.vertices, span = (from) => cut.rest.subarray(from, from + n).reduce(([low, high], x) => [Math.min(low, x), Math.max(high, x)], [Infinity, -Infinity]);
    const [[left, right], [low, high]] = [span(0), span(n)];
    shown.view = { x: (left + right) / 2 + cut.centre[0] - centre[0], y: (low + high) / 2 + cut.centre[1] - centre[1], half: 0.52 * Math.max(right - left, (high - low) / 0.7) };
    redraw();
  } };
  const acts = { "+": () => zoom(0.5), "-": () => zoom(2), 0: views.first, a: views.whole, ArrowLeft: () => move(-0.25, 0), ArrowRight: () => move(0.25, 0), ArrowUp: () => move(0, 0.25), ArrowDown: () => move(0, -0.25) };
  box.addEventListener("keydown", (event) => {
    if (!acts[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    acts[event.key]();
  });
  const { over } = live, placeOf = ({ clientX, clientY }) => {
    const { left, top, width, height } = over.getBoundingClientRect();
    return [(clientX - left) / width, (clientY - top) / height];
  };
  // The wheel moves the page until someone has clicked here.
  over.addEventListener("wheel", (event) => {
    if (document.activeElement !== box && !event.ctrlKey) return;
    event.preventDefault();
    zoom(Math.exp(0.002 * event.deltaY), placeOf(event));
  }, { passive: false });
  over.addEventListener("pointerdown", (event) => {
    box.focus({ preventScroll: true });
    over.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, placeOf(event));
  });
  over.addEventListener("pointermove", (event) => {
    const was = pointers.get(event.pointerId), now = placeOf(event);
    if (!was) return;
    const [, other] = [...pointers].find(([id]) => id !== event.pointerId) ?? [];
    const n = pointers.size, tall = over.clientHeight / over.clientWidth;
    if (other) zoom(Math.hypot(was[0] - other[0], (was[1] - other[1]) * tall) / Math.max(0.02, Math.hypot(now[0] - other[0], (now[1] - other[1]) * tall)), other);
    else move(2 * (was[0] - now[0]) / n, 2 * (now[1] - was[1]) * tall / n);
    pointers.set(event.pointerId, now);
  });
  for (const end of ["pointerup", "pointercancel"]) over.addEventListener(end, (event) => pointers.delete(event.pointerId));
  const bar = document.createElement("div");
  bar.className = "tools";
  for (const [key, sign, what] of [["+", "+", "zoom into the cut"], ["-", "−", "zoom out of the cut"], ["0", "⟲", "first view of the cut"], ["a", "⤢", "all cells of the cut"]]) {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", textContent: sign, title: what[0].toUpperCase() + what.slice(1), ariaLabel: what });
    button.addEventListener("click", acts[key]);
    bar.append(button);
  }
  const how = document.createElement("span");
  Object.assign(how, { className: "remark how", textContent: "Drag to move; click and use the wheel, or two fingers, to zoom." });
  bar.append(how);
  box.after(bar);
}

// The cut follows the slider, and is in the still pictures.
async function showCut(holder) {
  const remark = document.getElementById("cut-step");
  try {
    const cut = await cutOf(JSON.parse(document.getElementById("cut-data").textContent));
    const boxOf = (parent, frame) => {
      const box = document.createElement("div");
      Object.assign(box, { className: "slice", role: "img", ariaLabel: cut.frames[frame].words });
      parent.append(box);
      return box;
    };
    for (const figure of document.querySelectorAll("[data-picture]")) panel(boxOf(figure, figure.dataset.picture), cut, Number(figure.dataset.picture));
    const box = boxOf(holder, pictureOf[Number(slider.value)] + 1), shown = panel(box, cut, pictureOf[Number(slider.value)] + 1);
    Object.assign(box, { role: "group", tabIndex: 0 });
    steer(shown);
    const follow = (stop) => {
      const picture = pictureOf[stop], { words } = cut.frames[picture + 1];
      if (shown.frame !== picture + 1) {
        shown.frame = picture + 1;
        shown.live.setData(shown.live.data);
      }
      box.ariaLabel = `${words} Keys: + and − zoom, arrows move, 0 is the first view, a shows all cells.`;
      remark.textContent = words + (data.frames[picture] === data.stops[stop] ? "" : " It is the nearest step with a picture.");
    };
    followers.push(follow);
    follow(Number(slider.value));
    holder.dataset.ready = cut.frames.length - 1;
  } catch (error) {
    remark.textContent = `The cuts cannot be shown: ${error.message}.`;
  }
}

const cutBox = document.getElementById("cut");
if (cutBox && typeof uPlot !== "undefined") showCut(cutBox);
