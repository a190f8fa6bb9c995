// Follows a session: live values on the dials, and whether another tablet has gone on.

const SILENT_MS = 3000; // the server sends each half second, changed or not
const LOST_MS = 10000; // so long without a word a connection is given up: a tablet that slept, a proxy that hung
const AGAIN_MS = 1000; // how soon another is tried at first; each further one later
const LATEST_MS = 3000;

export function follow(session) {
  let stream, heard = Date.now(), tried = Date.now(), pause = AGAIN_MS, timer;
  const connect = () => {
    clearTimeout(timer);
    timer = undefined;
    stream?.close();
    tried = Date.now();
    stream = new EventSource(`/sessions/${session}/stream`);
    stream.addEventListener("now", (event) => {
      heard = Date.now();
      pause = AGAIN_MS;
      const now = JSON.parse(event.data);
      const changed = document.querySelector(".changed");
      if (changed && now.stamp !== document.body.dataset.stamp) goOn(session, changed);
      if (livePanel()) show(livePanel(), now);
    });
    // A browser tries again after a lost connection, and never again after an answer such as 502, 503 or 401.
    stream.addEventListener("error", () => stream.readyState === EventSource.CLOSED && later());
  };
  const later = () => {
    timer ??= setTimeout(connect, pause * (0.5 + 0.5 * Math.random()));
    pause = Math.min(2 * pause, LATEST_MS);
  };
  connect();
  setInterval(() => {
    if (Date.now() - heard > SILENT_MS && livePanel()) stale(livePanel(), livePanel().dataset.lostText);
    if (Date.now() - Math.max(heard, tried) > LOST_MS) connect();
  }, 500);
  document.addEventListener("visibilitychange", () => !document.hidden && Date.now() - heard > SILENT_MS && connect());
  addEventListener("online", connect);
  addEventListener("pagehide", () => { clearTimeout(timer); stream.close(); });
  // What this tablet asked for leads on by itself: the news of it must not get in between.
  addEventListener("submit", () => { document.body.dataset.sending = "yes"; });
  addEventListener("pageshow", (event) => { if (event.persisted) location.reload(); });
}

// Looked up each time: a form that is refused brings another page into this one.
function livePanel() {
  return document.querySelector("[data-live]");
}

// Another tablet went on: show it at once, unless something is typed here that would be lost from sight.
function goOn(session, changed) {
  const typing = document.querySelector("[data-kept]") || [...document.querySelectorAll("main input:not([type=hidden])")].some((field) =>
    field.type === "checkbox" || field.type === "radio" ? field.checked !== field.defaultChecked : field.value !== field.defaultValue);
  const sending = document.body.dataset.sending === "yes";
  if (typing || sending) changed.hidden = sending;
  else if (changed.hidden) { changed.hidden = false; location.replace(location.pathname.includes("/step/") ? location.href : `/sessions/${session}`); }
}

function show(panel, now) {
  for (const sensor of now.sensors) showSensor(panel, sensor);
  panel.querySelector("[data-speed]").textContent = now.speed;
  panel.querySelector(".fast").hidden = !now.too_fast || now.stale;
  const clocks = panel.querySelector("[data-clocks]");
  clocks.textContent = now.clocks.join(" ");
  clocks.hidden = !now.clocks.length;
  if (now.stale) { stale(panel, now.sensors.length ? panel.dataset.staleText : panel.dataset.noneText); return; }
  panel.classList.remove("stale");
  mark(panel.querySelector(".steadiness"), now.steady);
  panel.querySelector("[data-word]").textContent = now.steady ? panel.dataset.steadyText : panel.dataset.waitsText;
  panel.querySelector("[data-take]").disabled = !now.steady || now.too_fast;
  panel.querySelector("[data-anyway]").hidden = now.steady || now.too_fast || !now.sensors.length;
}

function showSensor(panel, sensor) {
  const dial = [...panel.querySelectorAll("[data-sensor]")].find((one) => one.dataset.sensor === sensor.name);
  if (!dial) return;
  const face = dial.querySelector("[data-amplitude]");
  if (sensor.larger) grow(face, sensor.larger);
  const { top, from, to } = face.querySelector(".pic-needle").dataset;
  turn(face, +from + Math.min(sensor.stored / top, 1.05) * (to - from), sensor.amplitude);
  turn(dial.querySelector("[data-phase]"), sensor.turn, sensor.phase);
  dial.querySelector("[data-why]").textContent = sensor.why_not ?? "";
  mark(dial, sensor.steady);
}

// A value beyond the scale brings a dial of a larger one with it; a dial never shrinks again.
function grow(face, drawn) {
  const made = new DOMParser().parseFromString(drawn, "text/html").querySelector("svg");
  const top = (dial) => +dial.querySelector(".pic-needle").dataset.top;
  if (top(made) > top(face)) face.replaceChildren(made);
}

// The dials are drawn by the server: the needle keeps its hub, only its turn and the figure below change.
function turn(face, degrees, figure) {
  const needle = face.querySelector(".pic-needle");
  needle.classList.toggle("pic-absent", degrees === null);
  if (degrees !== null) needle.setAttribute("transform", needle.getAttribute("transform").replace(/rotate\([-\d.e]+/, `rotate(${degrees}`));
  face.querySelector(".pic-strong").textContent = figure;
  face.querySelector("desc").textContent = figure;
}

function mark(part, steady) {
  part.classList.toggle("steady", steady);
  part.classList.toggle("unsteady", !steady);
}

function stale(panel, words) {
  panel.classList.add("stale");
  for (const part of panel.querySelectorAll(".steady, .unsteady")) part.classList.remove("steady", "unsteady");
  panel.querySelector("[data-word]").textContent = words;
  panel.querySelector("[data-take]").disabled = true;
  panel.querySelector("[data-anyway]").hidden = true;
}
