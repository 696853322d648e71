"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const slider = document.getElementById("step");
const column = Object.fromEntries(data.columns.map((name, at) => [name, at]));
// What follows the slider: functions of the stop that it is at.
const followers = [];

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

function nameOf(row) {
  const azimuth = row[column.azimuth_deg] ?? "", time = row[column.time_s] ?? "";
  let name = `Step ${row[column.step]} of 0 to ${data.of - 1}`;
  if (azimuth !== "") name += `, azimuth ${short(azimuth)}°`;
  if (time !== "") name += `, ${short(time)} s`;
  return name;
}

function show(stop) {
  const row = data.rows[stop];
  slider.value = stop;
  const which = nameOf(row);
  document.getElementById("which").textContent = which;
  slider.setAttribute("aria-valuetext", which);
  for (const output of document.querySelectorAll("output[data-column]")) {
    const value = row[column[output.dataset.column]] ?? "";
    const isText = ["file", "blake3"].includes(output.dataset.column);
    output.textContent = isText ? value : short(value);
    output.title = value;
  }
  for (const figure of document.querySelectorAll("[data-picture]")) {
    figure.classList.toggle("chosen-step", data.frames[figure.dataset.picture - 1] === data.stops[stop]);
  }
  for (const follow of followers) follow(stop);
}

function nearest(values, wanted) {
  let best = 0;
  values.forEach((value, at) => {
    if (Math.abs(value - wanted) < Math.abs(values[best] - wanted)) best = at;
  });
  return best;
}

// The bytes of a text that `packed` in html.rs has written.
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

// Copies a text; where the browser keeps pages from the clipboard, selects it.
async function copy(element, button) {
  try {
    await navigator.clipboard.writeText(element.textContent);
    button.textContent = "Copied";
  } catch {
    getSelection().selectAllChildren(element);
    button.textContent = document.execCommand("copy") ? "Copied" : "Selected";
  }
}

// The picture of a stop: the nearest of those on the page.
const pictureOf = data.stops.map((row) => (data.frames.length ? nearest(data.frames, row) : -1));
// Stops that have a picture of their own; all of them where there is none.
const film = data.frames.length ? data.frames.map((row) => data.stops.indexOf(row)) : data.stops.map((_, at) => at);
const STEPS_A_SECOND = 12;
let playing = null;

function play(now) {
  if (playing === null) return;
  playing.from ??= now;
  const passed = Math.floor((now - playing.from) / 1000 * STEPS_A_SECOND);
  const stop = film[(playing.first + passed) % film.length];
  if (Number(slider.value) !== stop) show(stop);
  requestAnimationFrame(play);
}

function pause() {
  if (playing !== null) toggle();
}

function toggle() {
  const button = document.getElementById("play");
  playing = playing === null ? { first: nearest(film, Number(slider.value)), from: null } : null;
  button.textContent = playing ? "❚❚ Pause" : "▶ Play";
  button.setAttribute("aria-pressed", playing !== null);
  if (playing) requestAnimationFrame(play);
}

function showStep(stop) {
  pause();
  show(Math.min(data.rows.length - 1, Math.max(0, stop)));
}

document.getElementById("copy")?.addEventListener("click", (event) => copy(document.getElementById("command"), event.target));

if (slider) {
  slider.addEventListener("input", () => showStep(Number(slider.value)));
  document.getElementById("play").addEventListener("click", toggle);
  document.addEventListener("click", (event) => {
    const button = event.target.closest("button");
    if (button?.dataset.by) showStep(Number(slider.value) + Number(button.dataset.by));
    if (button?.dataset.stop) showStep(Number(button.dataset.stop));
    if (button?.dataset.row) showStep(data.stops.indexOf(Number(button.dataset.row)));
  });
  document.addEventListener("keydown", (event) => {
    const takesSpace = event.target.closest("button, summary, select, input[type=checkbox]");
    if (event.key !== " " || takesSpace) return;
    event.preventDefault();
    toggle();
  });
}
