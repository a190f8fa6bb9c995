// Design studies: the linkage moves, fields are checked while they are typed, a run is followed, a front is clicked.
const SVG = ["polygon.pic-link, polyline.pic-link, line.pic-link", "circle.pic-hole", "circle.pic-mass"];
const TURN_MS = 6000;

/** Moves a linkage: a few attributes a frame, read from a table that the page brings. */
function animate(figure) {
  const { points, joints, shapes, frames } = JSON.parse(figure.querySelector(".frames").textContent);
  const moving = figure.querySelector("g.moving");
  const [links, holes, masses] = SVG.map((names) => [...moving.querySelectorAll(names)]);
  const player = figure.querySelector(".player");
  const slider = player.querySelector("[data-angle]");
  const button = player.querySelector("[data-play]");
  const words = [button.textContent, button.dataset.pause];
  let running = false, began = 0, shown = -1;

  function show(step) {
    if (step === shown) return;
    shown = step;
    const row = frames[step];
    shapes.forEach((shape, k) => {
      const link = links[k];
      if (link.tagName === "line") {
        const [a, b] = shape;
        link.setAttribute("x1", row[2 * a]);
        link.setAttribute("y1", row[2 * a + 1]);
        link.setAttribute("x2", row[2 * b]);
        link.setAttribute("y2", row[2 * b + 1]);
      } else link.setAttribute("points", shape.map((at) => `${row[2 * at]},${row[2 * at + 1]}`).join(" "));
    });
    for (let at = 0; at < points; at += 1) {
      const circle = at < joints ? holes[at] : masses[at - joints];
      circle.setAttribute("cx", row[2 * at]);
      circle.setAttribute("cy", row[2 * at + 1]);
    }
    slider.value = step;
  }
  function frame(now) {
    if (!running) return;
    began ||= now - (shown / frames.length) * TURN_MS;
    show(Math.floor(((now - began) / TURN_MS) * frames.length) % frames.length);
    requestAnimationFrame(frame);
  }
  function run(on) {
    running = on;
    began = 0;
    button.textContent = words[Number(on)];
    if (on) requestAnimationFrame(frame);
  }
  button.addEventListener("click", () => run(!running));
  slider.addEventListener("input", () => { run(false); show(Number(slider.value)); });
  player.hidden = false;
  show(0);
  // Who asked for less motion starts it himself, if at all.
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  calm.addEventListener("change", () => calm.matches && run(false));
  if (!calm.matches) run(true);
}

/** Asks the service what is wrong with the form as it stands, a moment after the last key. */
function check(form) {
  let waiting = 0, asked = 0;
  const general = form.querySelector("[data-general]");
  function put(field, text) {
    const key = `${field.id}-fault`;
    let said = document.getElementById(key);
    if (!said && text) {
      said = Object.assign(document.createElement("p"), { id: key, className: "fault" });
      field.closest(".field").append(said);
    }
    if (said) { said.textContent = text; said.hidden = !text; }
    field.closest(".field").classList.toggle("wrong", Boolean(text));
    if (text) { field.setAttribute("aria-invalid", "true"); field.setAttribute("aria-describedby", key); }
    else field.removeAttribute("aria-invalid");
  }
  async function ask() {
    const number = ++asked;
    try {
      const answer = await fetch("/designs/check", { method: "POST", body: new URLSearchParams(new FormData(form)) });
      if (!answer.ok || number !== asked) return;
      const found = await answer.json();
      for (const field of form.querySelectorAll(".field input, .field select, .field textarea")) put(field, found.fields[field.name] ?? "");
      general.textContent = found.general;
      general.hidden = !found.general;
    } catch { /* no link: the service checks again when the form is sent */ }
  }
  form.addEventListener("input", () => { clearTimeout(waiting); waiting = setTimeout(ask, 400); });
}

/** Shows how far a run is; when it has ended the page is loaded again with what it found. */
function follow(card) {
  const source = new EventSource(card.dataset.follow);
  const number = new Intl.NumberFormat(document.documentElement.lang, { maximumSignificantDigits: 7 });
  source.addEventListener("progress", (event) => {
    const { state, progress } = JSON.parse(event.data);
    card.querySelector("[data-steps]").textContent = progress.steps;
    card.querySelector("[data-evaluations]").textContent = progress.evaluations;
    card.querySelector("[data-seconds]").textContent = `${number.format(Math.round(10 * progress.seconds) / 10)}\u202fs`;
    const value = card.querySelector("[data-value]");
    if (value && progress.value !== null) value.textContent = `${number.format(progress.value)} ${progress.unit}`;
    if (state !== "running") { source.close(); location.reload(); }
  });
}

/** A touch on the front opens the nearest point. */
function choose(figure) {
  const dots = [...figure.querySelectorAll("circle.pic-dot")];
  figure.addEventListener("click", (event) => {
    const apart = dots.map((dot) => {
      const box = dot.getBoundingClientRect();
      return Math.hypot(box.x + box.width / 2 - event.clientX, box.y + box.height / 2 - event.clientY);
    });
    const nearest = apart.indexOf(Math.min(...apart));
    if (apart[nearest] < 30) location.search = `?point=${nearest}`;
  });
}

document.querySelectorAll("[data-linkage]").forEach(animate);
document.querySelectorAll(".design-form").forEach(check);
document.querySelectorAll("[data-follow]").forEach(follow);
document.querySelectorAll(".front-picture").forEach(choose);
