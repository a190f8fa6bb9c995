// A typed run is kept in the browser from the first figure until the server has it: through a reload, a lost link, a
// restart of the server. What waits is sent again and again under one form key, so that it is stored once.

const DRAFT = "drumtrue-draft:";
const WAITS = "drumtrue-waits:";
const AGAIN_MS = 2000;

export function keepTyped(session) {
  const form = document.querySelector("form.typed-run");
  if (form) keepDraft(form, session);
  if (form) form.addEventListener("submit", (event) => { event.preventDefault(); send(form, session); });
  const kept = read(WAITS + session);
  if (kept) { waiting(kept); deliver(session); }
  addEventListener("online", () => deliver(session));
}

function keepDraft(form, session) {
  const key = DRAFT + session;
  const kept = read(key);
  if (kept && kept.moment === document.body.dataset.moment) {
    for (const [name, value] of Object.entries(kept.values)) {
      const field = form.elements.namedItem(name);
      if (field && field.type !== "hidden" && !field.value) field.value = value;
    }
    if (Object.values(kept.values).some((value) => value)) form.closest("details").open = true;
  }
  form.addEventListener("input", () => {
    const values = Object.fromEntries([...form.elements].filter((f) => f.name && f.type !== "hidden").map((f) => [f.name, f.value]));
    write(key, { moment: document.body.dataset.moment, values });
  });
}

function send(form, session) {
  const body = new URLSearchParams(new FormData(form)).toString();
  write(WAITS + session, { url: form.getAttribute("action"), body });
  document.body.dataset.sending = "yes";
  deliver(session);
}

let busy = false;
async function deliver(session) {
  const kept = read(WAITS + session);
  if (!kept || busy) return;
  busy = true;
  try {
    const answer = await fetch(kept.url, {
      method: "POST", body: kept.body, signal: AbortSignal.timeout(15000),
      headers: { "content-type": "application/x-www-form-urlencoded", accept: "text/html" },
    });
    if (answer.status >= 500) throw new Error(`the server answered ${answer.status}`);
    if (answer.status === 403 && !kept.renewed) { await renew(kept, session); return; }
    remove(WAITS + session);
    if (answer.redirected) { remove(DRAFT + session); location.assign(answer.url); }
    else show(await answer.text());
  } catch {
    waiting(kept);
    setTimeout(() => deliver(session), AGAIN_MS);
  } finally {
    busy = false;
  }
}

// The page is older than the browser's cookies: take the token of a new page, and try once more.
async function renew(kept, session) {
  const page = new DOMParser().parseFromString(await (await fetch(location.pathname, { headers: { accept: "text/html" } })).text(), "text/html");
  const body = new URLSearchParams(kept.body);
  body.set("form_token", page.querySelector("[name=form_token]")?.value ?? "");
  write(WAITS + session, { ...kept, body: body.toString(), renewed: true });
  setTimeout(() => deliver(session), 0);
}

// The server refused it: its page says why, beside the fields, with what was typed.
function show(html) {
  const page = new DOMParser().parseFromString(html, "text/html");
  document.querySelector("main").replaceWith(page.querySelector("main"));
  document.body.dataset.stamp = page.body.dataset.stamp ?? "";
  document.body.dataset.moment = page.body.dataset.moment ?? "";
  document.body.dataset.sending = "";
  keepTyped(document.body.dataset.session);
  document.querySelector(".wrong input, .notice, .fault")?.scrollIntoView({ block: "center" });
}

function waiting(kept) {
  const words = document.querySelector(".waiting");
  const typed = [...new URLSearchParams(kept.body)].filter(([name, value]) => value && /amplitude|phase|speed/.test(name)).map(([, value]) => value);
  const place = words ?? document.querySelector(".link-state");
  place.hidden = false;
  place.textContent = `${words ? words.dataset.text : document.querySelector(".link-state").dataset.offline} (${typed.join(" · ")})`;
  const button = document.querySelector("form.typed-run button");
  if (button) button.disabled = true;
}

function read(key) {
  try { return JSON.parse(localStorage.getItem(key)); } catch { return null; }
}
function write(key, value) {
  try { localStorage.setItem(key, JSON.stringify(value)); } catch { /* a full or forbidden store: the form is still sent */ }
}
function remove(key) {
  try { localStorage.removeItem(key); } catch { /* as above */ }
}
