// The plots, drawn by uPlot. They zoom, and those over the steps follow the slider.
const DASHES = [[], [7, 3], [2, 2.5], [9, 3, 2, 3], [], [5, 2], [1.5, 3], [12, 4]];
const steps = [];
const plots = [];

function colour(name, part) {
  const value = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  return part === undefined ? value : value + Math.round(255 * part).toString(16).padStart(2, "0");
}

function numbers(name) {
  return data.rows.map((row) => (row[column[name]] ?? "") === "" ? null : Number(row[column[name]]));
}

// The x of a plot and its lines: columns of the steps, or lines of their own.
function valuesOf(plot) {
  if (plot.is_marked) return [data.x, ...plot.series.map((series) => numbers(series.column))];
  return uPlot.join(plot.series.map(({ points }) => [points.map(([x]) => x), points.map(([, y]) => y)]));
}

// The lower end of a logarithmic axis that would reach too far: below it are zeros, and at most a quarter of the other values, where these are a
// thousandth of the next larger one or less.
function floorOf(plot, lines) {
  if (!plot.is_log || plot.bars.length) return 0;
  const known = lines.flat().filter(Number.isFinite), all = known.filter((y) => y > 0).sort((a, b) => a - b);
  let from = 0;
  for (let at = 1; at <= all.length / 4; at += 1) if (all[at] >= 1e3 * all[at - 1]) from = at;
  return all.length && (from > 0 || all.length < known.length) ? Number(`1e${Math.floor(Math.log10(all[from]) + 1e-9) - 1}`) : 0;
}

// Round values on a logarithmic axis: at most seven decades, or parts of few of them.
function decades(low, high) {
  const first = Math.floor(Math.log10(low) + 1e-9), last = Math.ceil(Math.log10(high) - 1e-9);
  const every = Math.max(1, Math.ceil((last - first) / 6)), parts = last - first > 2 ? [1] : [1, 2, 5];
  const found = [];
  for (let exponent = first; exponent <= last; exponent += 1) {
    if ((last - exponent) % every === 0) found.push(...parts.map((part) => Number(`${part}e${exponent}`)));
  }
  return found.filter((value) => value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9));
}

// As in 2·10⁻⁵.
function power(value) {
  const [digit, exponent] = value.toExponential(0).split("e").map(Number);
  const raised = String(exponent).replace("-", "⁻").replace(/\d/g, (figure) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[figure]);
  const ten = { 0: "1", 1: "10" }[exponent] ?? `10${raised}`;
  return digit === 1 ? ten : exponent === 0 ? String(digit) : `${digit}·${ten}`;
}

function label(value) {
  return short(String(Number(value.toPrecision(6)))).replace("-", "\u2212");
}

// Lines with dots where there are few; bars, of which the second set is an outline.
function styleOf(series, plot) {
  if (!series.bars) return { width: 1.8, dash: DASHES[series.style], points: { show: series.known < 40, size: 5 }, spanGaps: !plot.is_marked };
  const fill = series.style === 0 ? () => colour("--s0", 0.75) : null;
  return { width: fill ? 0 : 1.5, fill, points: { show: false }, paths: uPlot.paths.bars({ size: [1, Infinity], align: 1, gap: 0 }) };
}

function optionsOf(plot, width) {
  const font = '12px system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif';
  const axis = (title, size) => ({
    label: title, labelSize: 20, size, font, labelFont: font, stroke: () => colour("--soft"),
    grid: { stroke: () => colour("--line"), width: 1 }, ticks: { stroke: () => colour("--line"), width: 1 },
  });
  const x = axis(plot.x, 32), y = axis(plot.y, (u, values) => Math.max(58, 32 + 6.6 * Math.max(0, ...(values ?? []).map((value) => value.length))));
  x.values = y.values = (_, splits) => splits.map((value) => (value === null ? "" : label(value)));
  if (plot.is_log) {
    y.splits = (u, _, low, high) => decades(low, high);
    y.values = (_, splits) => splits.map(power);
    y.filter = (_, splits) => splits;
  }
  // A bar begins at its x: the axis ends one width after the last.
  const barred = plot.series.find((series) => series.bars);
  const width0 = barred ? barred.points[1][0] - barred.points[0][0] : 0;
  if (plot.in_degrees) x.incrs = [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 45, 60, 90, 180, 360, 720, 1440, 3600];
  const level = plot.levels.map(([, value]) => value);
  const range = (u, low, high) => {
    const all = [low, high, ...(plot.zoomed ? [] : [...level, ...plot.include])].filter((value) => value !== null && Number.isFinite(value));
    if (!all.length) return plot.is_log ? [0.1, 1] : [0, 1];
    const [least, most] = [Math.min(...all), Math.max(...all)];
    if (least === 0 && most === 0) return [-1, 1];
    return plot.is_log ? uPlot.rangeLog(least, most === least ? 10 * least : most, 10, true) : uPlot.rangeNum(least, most, 0.08, true);
  };
  return {
    width, height: plot.height(width), legend: { show: false }, pxAlign: 0, padding: [10, 12, 0, 0],
    scales: { x: { time: false, range: (u, low, high) => [low, high + (high === barred?.points.at(-1)[0] ? width0 : 0)] }, y: { distr: plot.is_log ? 3 : 1, range } },
    axes: [x, y],
    series: [{}, ...plot.series.map((series) => ({ label: series.name, stroke: () => colour(`--s${series.style}`), ...styleOf(series, plot) }))],
    bands: plot.bands.map(([low, high]) => ({ series: [high + 1, low + 1], fill: () => colour(`--s${plot.series[low].style}`, 0.18) })),
    cursor: { drag: { x: true, y: false }, ...(plot.is_marked ? { sync: { key: "steps" } } : {}) },
    hooks: { drawSeries: [], draw: [(u) => { drawLevels(u, level); placeMark(plot); }], setScale: [(u, key) => key === "x" && scaled(u, plot)], setCursor: [(u) => tell(u, plot)] },
  };
}

function drawLevels(u, values) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.strokeStyle = colour("--soft");
  ctx.setLineDash([2 * devicePixelRatio, 3 * devicePixelRatio]);
  for (const value of values) {
    const y = u.valToPos(value, "y", true);
    if (y < bbox.top || y > bbox.top + bbox.height) continue;
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
  }
  ctx.restore();
}

// Plots over the steps show the same steps.
let isFollowing = false;
function scaled(u, plot) {
  const { min, max } = u.scales.x;
  const xs = u.data[0];
  const isWhole = min <= xs[0] && max >= xs[xs.length - 1];
  plot.zoomed = !isWhole;
  plot.figure.classList.toggle("zoomed", !isWhole);
  if (!plot.is_marked || isFollowing) return;
  isFollowing = true;
  for (const other of steps) if (other !== plot && other.live) other.live.setScale("x", { min, max });
  isFollowing = false;
}

// The values under the pointer.
function tell(u, plot) {
  const at = u.cursor.idx;
  const isOver = u.cursor.left >= 0 && at !== null && at !== undefined && plot.figure.matches(":hover");
  plot.tip.hidden = !isOver;
  if (!isOver) return;
  const values = plot.series.map((series, i) => [series.name, plot.values[i + 1][at]]).filter(([, value]) => value !== null && value !== undefined);
  plot.tip.textContent = `${label(u.data[0][at])}: ${values.map(([name, value]) => (values.length > 1 ? `${name} ` : "") + label(value)).join(", ")}`;
}

function zoom(plot, factor) {
  const u = plot.live, xs = u.data[0];
  const [first, last] = [xs[0], xs[xs.length - 1]];
  const { min, max } = u.scales.x;
  const chosen = plot.is_marked && slider ? data.x[Number(slider.value)] : (min + max) / 2;
  const middle = chosen >= min && chosen <= max ? chosen : (min + max) / 2;
  const half = Math.max((max - min) / 2 * factor, (last - first) * 1e-4);
  const low = Math.max(first, middle - half), high = Math.min(last, middle + half);
  if (factor === Infinity || low <= first && high >= last) u.setScale("x", { min: first, max: last });
  else u.setScale("x", { min: low, max: high });
}

function shift(plot, part) {
  const u = plot.live, xs = u.data[0];
  const { min, max } = u.scales.x;
  const by = Math.min(xs[xs.length - 1] - max, Math.max(xs[0] - min, part * (max - min)));
  u.setScale("x", { min: min + by, max: max + by });
}

// The line of the chosen step. The axes of a plot have their size only when it is drawn.
function placeMark(plot) {
  if (!plot.is_marked || !slider || !plot.live) return;
  const at = data.x[Number(slider.value)], x = plot.live.valToPos(at, "x");
  plot.mark.style.transform = `translateX(${x}px)`;
  plot.mark.hidden = x < -0.5 || x > plot.live.over.clientWidth + 0.5;
  plot.mark.dataset.x = at;
}

function buttonsOf(plot, title) {
  const bar = document.createElement("span");
  bar.className = "zoom";
  for (const [sign, what, factor] of [["−", "zoom out of", 2], ["+", "zoom into", 0.5], ["⟲", "all of", Infinity]]) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = sign;
    button.title = `${what[0].toUpperCase()}${what.slice(1)} the plot`;
    button.setAttribute("aria-label", `${what} ${title}`);
    button.addEventListener("click", () => zoom(plot, factor));
    bar.append(button);
  }
  return bar;
}

// Names of the lines with the values at the chosen step, bars, levels.
function legendOf(plot) {
  const list = document.createElement("ul");
  list.className = "legend";
  const add = (swatch, d, name, value) => {
    const item = document.createElement("li"), text = document.createElement("span");
    item.innerHTML = `<svg viewBox="0 0 24 10" aria-hidden="true"><path class="${swatch}" d="${d}"/></svg>`;
    text.append(`${name} `, value ?? "");
    item.append(text);
    list.append(item);
  };
  for (const { bars, style, name, column } of plot.series) {
    const value = document.createElement("output");
    if (column) value.dataset.column = column;
    if (bars) add(`${style ? "outline" : "bars"} s${style}`, "M3 9V2H21V9", name);
    else add(`line s${style}`, "M1 5H23", name, column ? value : "");
  }
  for (const [name, value] of plot.levels) {
    const number = document.createElement("b");
    number.textContent = label(value);
    add("level", "M1 5H23", name, number);
  }
  return list;
}

// A plot in words, for those who do not see it.
function wordsOf(plot, [x, ...lines]) {
  const words = lines.map((line, at) => {
    const known = x.map((place, i) => [place, line[i]]).filter(([, y]) => y !== null && y !== undefined);
    plot.series[at].known = known.length;
    if (!known.length) return "";
    const least = known.reduce((a, b) => (b[1] < a[1] ? b : a)), most = known.reduce((a, b) => (b[1] > a[1] ? b : a));
    return ` ${plot.series[at].name}: smallest ${label(least[1])} at ${label(least[0])}, largest ${label(most[1])} at ${label(most[0])}.`;
  });
  const levels = plot.levels.map(([name, value]) => ` ${name}: ${label(value)}.`);
  return `${plot.title} (${plot.y}) against ${plot.x}.${words.join("")}${levels.join("")} Keys: + and − zoom, arrows move, 0 shows all.`;
}

function bring(figure) {
  const plot = JSON.parse(figure.querySelector("script").textContent);
  const caption = figure.querySelector("figcaption");
  const box = document.createElement("div"), remark = document.createElement("p");
  plot.series.push(...plot.bars.map(([name, points], style) => ({ name, points, style, bars: true })));
  const values = valuesOf(plot), floor = floorOf(plot, values.slice(1));
  const onAxis = (y) => (y > floor || !Number.isFinite(y) ? y : floor || null);
  const drawn = values.map((line, at) => (at && plot.is_log ? line.map(onAxis) : line));
  if (floor) plot.remark += ` Values below ${power(floor)} are drawn at the lower edge.`;
  else if (plot.is_log && values.slice(1).flat().includes(0)) plot.remark += " Values of zero are not shown on this axis.";
  Object.assign(box, { className: "live-plot", role: "group", tabIndex: 0, ariaLabel: wordsOf(plot, values) });
  Object.assign(remark, { className: "remark", textContent: plot.remark });
  figure.append(box, legendOf(plot), remark);
  Object.assign(plot, { figure, values, floor, zoomed: false, height: (width) => Math.round(Math.max(210, 0.58 * width, 64 + 6.4 * plot.y.length)), tip: document.createElement("p"), mark: document.createElement("div") });
  if (plot.is_marked) steps.push(plot);
  plot.live = new uPlot(optionsOf(plot, box.clientWidth), drawn, box);
  plot.live.root.ariaHidden = "true";
  plot.tip.className = "tip";
  plot.tip.hidden = true;
  plot.mark.className = "step-mark";
  box.append(plot.tip);
  if (plot.is_marked) plot.live.over.append(plot.mark);
  caption.append(buttonsOf(plot, caption.textContent));
  box.addEventListener("keydown", (event) => {
    const act = { "+": () => zoom(plot, 0.5), "-": () => zoom(plot, 2), 0: () => zoom(plot, Infinity), ArrowLeft: () => shift(plot, -0.25), ArrowRight: () => shift(plot, 0.25) }[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  });
  plot.live.over.addEventListener("click", (event) => {
    if (!plot.is_marked || plot.live.select.width > 3) return;
    const x = plot.live.posToVal(event.clientX - plot.live.over.getBoundingClientRect().left, "x");
    showStep(nearest(data.x, x));
  });
  plots.push(plot);
}

if (typeof uPlot !== "undefined") {
  uPlot.sync("steps");
  document.querySelectorAll("figure.plot").forEach(bring);
  new ResizeObserver(() => {
    for (const plot of plots) {
      const width = plot.live.root.parentElement.clientWidth;
      if (width > 0 && width !== plot.live.width) plot.live.setSize({ width, height: plot.height(width) });
    }
  }).observe(document.body);
  // Paper has the bright colours.
  for (const media of ["(prefers-color-scheme: dark)", "print"]) {
    matchMedia(media).addEventListener("change", () => plots.forEach((plot) => plot.live.redraw()));
  }
  if (slider) followers.push(() => steps.forEach(placeMark));
}
