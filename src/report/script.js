"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const slider = document.getElementById("step");
const column = Object.fromEntries(data.columns.map((name, at) => [name, at]));

// The rule of `short` in src/diagnostic/numbers.rs.
function short(text) {
  const value = Number(text);
  if (text === "" || Number.isNaN(value)) return text;
  if (Number.isInteger(value) && Math.abs(value) < 1e9) return String(value);
  const rounded = Number(value.toPrecision(6));
  const size = Math.abs(rounded);
  if (size < 1e-3 || size >= 1e6) return rounded.toExponential().replace("e+", "e");
  return String(rounded);
}

function show(stop) {
  const row = data.rows[stop];
  slider.value = stop;
  const azimuth = row[column.azimuth_deg] ?? "", time = row[column.time_s] ?? "";
  let which = `Step ${row[column.step]} of 0 to ${data.of - 1}`;
  if (azimuth !== "") which += `, azimuth ${short(azimuth)}°`;
  if (time !== "") which += `, ${short(time)} s`;
  document.getElementById("which").textContent = which;
  slider.setAttribute("aria-valuetext", which);
  for (const output of document.querySelectorAll("output[data-column]")) {
    const value = row[column[output.dataset.column]] ?? "";
    const isText = ["file", "blake3"].includes(output.dataset.column);
    output.textContent = isText ? value : short(value);
    output.title = value;
  }
  for (const plot of document.querySelectorAll("svg[data-from]")) {
    const { from, to, left, width } = plot.dataset;
    const part = (data.x[stop] - from) / (to - from);
    plot.querySelector(".mark").setAttribute("transform", `translate(${+left + part * width})`);
  }
  for (const figure of document.querySelectorAll("figure")) {
    const button = figure.querySelector("button[data-row]");
    figure.classList.toggle("chosen-step", button !== null && Number(button.dataset.row) === data.stops[stop]);
  }
}

function nearest(x) {
  let best = 0;
  data.x.forEach((value, at) => {
    if (Math.abs(value - x) < Math.abs(data.x[best] - x)) best = at;
  });
  return best;
}

if (slider) {
  const last = data.rows.length - 1;
  slider.addEventListener("input", () => show(Number(slider.value)));
  document.addEventListener("click", (event) => {
    const button = event.target.closest("button");
    const plot = event.target.closest("svg[data-from]");
    if (button?.dataset.by) show(Math.min(last, Math.max(0, Number(slider.value) + Number(button.dataset.by))));
    if (button?.dataset.stop) show(Number(button.dataset.stop));
    if (button?.dataset.row) show(data.stops.indexOf(Number(button.dataset.row)));
    if (plot) {
      const { from, to, left, width } = plot.dataset;
      const box = plot.getBoundingClientRect();
      const across = (event.clientX - box.left) / box.width * plot.viewBox.baseVal.width;
      show(nearest(Number(from) + (across - left) / width * (to - from)));
    }
  });
  show(0);
}
