// Every form is kept on the device until the server has acknowledged it: through a lost link, a closed page, a restart of
// the server. What waits is shown, and sent again and again under one form key, so that it is done once. Nothing that
// is ticked here counts before the server has it: the page goes on with the server's answer alone.

import { put, remove, waiting } from "./queue.js";
import { dropDraft, keepDrafts, momentOf } from "./drafts.js";

const AGAIN_MS = 2000;
const PATIENCE_MS = 60000; // a search for the best pieces may take this long
const OLD_MS = 15 * 60 * 1000; // a tick of a safety list is asked about again after so long
const AWAY = [502, 503, 504];
const bar = document.querySelector(".waiting");
const held = new Set();
const confirmed = new Set();
let busy = false;
let timer;
let prepare = () => {};

// `again` readies a page that an answer has put into this one.
export function takeForms(again) {
  prepare = again;
  addEventListener("submit", (event) => taken(event.target) && send(event));
  addEventListener("online", deliver);
  bar.querySelector("[data-drop]").addEventListener("click", drop);
  bar.querySelector("[data-send]").addEventListener("click", confirm);
  deliver();
}

function taken(form) {
  return form.method === "post" && form.closest("main") && !form.hasAttribute("data-plain");
}

async function send(event) {
  event.preventDefault();
  const { target: form, submitter } = event;
  if (held.size) return; // tapped twice
  const body = new URLSearchParams(new FormData(form, submitter)).toString();
  const { pathname, search } = new URL(form.action);
  const asked = (submitter ?? form.querySelector("button"))?.textContent.trim() ?? "";
  const item = { id: crypto.randomUUID?.() ?? `${Date.now()} ${Math.random()}`, url: pathname + search, body, page: location.href, moment: momentOf(form), asked, at: Date.now() };
  hold();
  await put(item);
  await deliver();
}

// While something of this page is on its way nothing else of it can be.
function hold() {
  document.body.dataset.sending = "yes";
  for (const button of document.querySelectorAll("main form button:enabled")) { button.disabled = true; held.add(button); }
  held.add(bar);
}

function letGo() {
  for (const button of held) if (button !== bar) button.disabled = false;
  held.clear();
  document.body.dataset.sending = "";
}

export async function deliver() {
  if (busy) return;
  busy = true;
  clearTimeout(timer);
  try {
    for (let item; (item = (await waiting()).find((one) => !one.refused || isHere(one))); ) if (!(await sent(item))) return;
    await showRefused();
  } finally {
    busy = false;
  }
}

async function sent(item) {
  if (isHere(item) && !held.size) hold();
  if (isOld(item)) { tell(item, bar.dataset.old); return false; }
  let answer;
  try {
    answer = await fetch(item.url, {
      method: "POST", body: item.body, signal: AbortSignal.timeout(PATIENCE_MS),
      headers: { "content-type": "application/x-www-form-urlencoded", accept: "text/html", "x-outbox": "1" },
    });
  } catch {
    return later(item, bar.dataset.text, AGAIN_MS);
  }
  if (AWAY.includes(answer.status)) {
    const own = answer.headers.get("retry-after"); // the service itself is busy, or a proxy does not find it
    return later(item, own ? bar.dataset.busy : bar.dataset.text, own ? 1000 * own : AGAIN_MS);
  }
  if (answer.status === 401) { location.assign(`/login?back=${encodeURIComponent(location.pathname)}`); return false; }
  if (answer.status === 403 && !item.renewed) return renew(item);
  return acknowledged(item, answer);
}

async function acknowledged(item, answer) {
  const goto = answer.headers.get("x-goto");
  if (!goto && !isHere(item)) { await put({ ...item, refused: true }); return true; }
  const html = goto ? "" : await answer.text();
  await remove(item);
  if (goto || answer.ok) dropDraft(new URL(item.url, location.href).pathname, item.moment);
  bar.hidden = true;
  if (!isHere(item)) return true;
  if (goto) location.assign(goto);
  else show(html);
  return !goto;
}

function later(item, words, ms) {
  tell(item, words);
  clearTimeout(timer);
  timer = setTimeout(deliver, ms);
  return false;
}

// The page is older than the browser's cookies: take the token of a new page, and try once more.
async function renew(item) {
  try {
    const html = await (await fetch("/preferences", { headers: { accept: "text/html" } })).text();
    const body = new URLSearchParams(item.body);
    body.set("form_token", new DOMParser().parseFromString(html, "text/html").querySelector("[name=form_token]")?.value ?? "");
    await put({ ...item, body: body.toString(), renewed: true });
    return true;
  } catch {
    return later(item, bar.dataset.text, AGAIN_MS);
  }
}

// The server asks for more, or says beside the fields why it refused.
function show(html) {
  const page = new DOMParser().parseFromString(html, "text/html");
  letGo();
  document.querySelector("main").replaceWith(page.querySelector("main"));
  document.title = page.title;
  document.body.dataset.stamp = page.body.dataset.stamp ?? "";
  document.body.dataset.moment = page.body.dataset.moment ?? "";
  keepDrafts();
  prepare();
  document.querySelector("main .wrong, main .notice, main .fault")?.scrollIntoView({ block: "center" });
}

// Of the page that is shown: the same session, the same form, or the page that stands for one without a link.
function isHere(item) {
  const [from, here] = [new URL(item.page).pathname, location.pathname].map((path) => path.match(/^\/sessions\/[^/]+/)?.[0] ?? path);
  return from === here || document.body.hasAttribute("data-no-link");
}

const isOld = (item) => /\/stops(\/|$)/.test(item.url) && Date.now() - item.at > OLD_MS && !confirmed.has(item.id);

function tell(item, words) {
  const typed = [...new URLSearchParams(item.body)].filter(([name, value]) => value && /amplitude|phase|speed|mass_g|name$/.test(name)).map(([, value]) => value);
  const at = new Date(item.at).toLocaleTimeString(document.documentElement.lang, { timeStyle: "short" });
  bar.hidden = false;
  bar.querySelector("[data-asked]").textContent = [item.asked, at, ...typed.slice(0, 8)].filter(Boolean).join(" · ");
  bar.querySelector("[data-words]").textContent = words;
  bar.querySelector("[data-stop]").hidden = !/\/stops\//.test(item.url);
  bar.querySelector("[data-send]").hidden = !isOld(item);
}

// What was refused while another page was shown is told, and shown where it was typed.
async function showRefused() {
  const item = (await waiting()).find((one) => one.refused);
  if (!item) return;
  tell(item, bar.dataset.refused);
  const link = bar.querySelector("[data-page]");
  link.href = new URL(item.page).pathname;
  link.hidden = false;
}

async function confirm() {
  const [item] = await waiting();
  if (item) confirmed.add(item.id);
  deliver();
}

async function drop() {
  const [item] = await waiting();
  if (item) await remove(item);
  bar.hidden = true;
  letGo();
  deliver();
}
