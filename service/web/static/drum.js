// The picture of the drum is a control: a touch chooses the hole, ticks the piece, or leads to what can be done with it.
// It follows what is typed: the server draws it anew, so that picture and list always say the same.

const REACH_PX = 44; // a glove seldom meets the middle of a hole
const PAUSE_MS = 120;
let timer;

export function tapDrum() {
  for (const box of document.querySelectorAll("main .ends")) {
    if (box.dataset.taps) continue;
    box.dataset.taps = "yes";
    box.addEventListener("click", touched);
  }
  const form = document.querySelector("main [data-picture]")?.form ?? document.querySelector("main [data-picture]")?.closest("form");
  if (!form || form.dataset.drawn) return;
  form.dataset.drawn = "yes";
  for (const name of ["input", "restored"]) form.addEventListener(name, () => { clearTimeout(timer); timer = setTimeout(draw, PAUSE_MS, form); });
  if (form.elements["masses.mass_g"].value !== form.elements["masses.mass_g"].defaultValue || form.querySelector("[aria-invalid]")) draw(form);
}

function touched(event) {
  const place = nearest(event);
  if (!place) return;
  const { plane, at } = place.dataset;
  const select = document.querySelector("main [name='masses.angle_deg']");
  const same = (text) => Math.abs(Number(text) - Number(at)) < 1e-6;
  if (select) {
    const option = [...select.options].find((one) => same(one.value));
    if (option) { select.value = option.value; select.dispatchEvent(new Event("input", { bubbles: true })); }
    return;
  }
  const tick = [...document.querySelectorAll("main .moves [data-at]")].find((one) => one.dataset.plane === plane && same(one.dataset.at));
  if (tick) { tick.click(); return; }
  const strike = [...document.querySelectorAll("main .strike form")].find((one) => one.elements.blocked_plane?.value === plane && same(one.elements.blocked_deg?.value));
  if (strike) { strike.closest("details").open = true; strike.querySelector("button").focus(); strike.scrollIntoView({ block: "center" }); }
}

function nearest(event) {
  const far = (place) => {
    const box = (place.querySelector(".pic-hole") ?? place).getBoundingClientRect();
    return Math.hypot(box.x + box.width / 2 - event.clientX, box.y + box.height / 2 - event.clientY);
  };
  const places = [...(event.target.closest("svg")?.querySelectorAll(".pic-place[data-at]") ?? [])].map((place) => [far(place), place]);
  const [found] = places.sort((a, b) => a[0] - b[0]);
  return found && found[0] <= REACH_PX ? found[1] : undefined;
}

// Without a link the picture is shown as one that does not hold.
async function draw(form) {
  const list = document.querySelector("main .ends .picture-list");
  const asked = new URLSearchParams(location.search);
  for (const name of ["masses.mass_g", "masses.angle_deg"]) asked.set(name, form.elements[name].value);
  if (form.elements.keep?.checked) asked.set("keep", "yes");
  list.classList.add("old");
  try {
    const answer = await fetch(`${form.querySelector("[data-picture]").dataset.picture}?${asked}`, { headers: { accept: "text/html" } });
    if (!answer.ok) return;
    const made = new DOMParser().parseFromString(await answer.text(), "text/html").querySelectorAll("figure");
    list.replaceChildren(...made);
    list.classList.remove("old");
  } catch { /* it stays marked as old */ }
}
