// Keeps the pages open where the link does not: the files of the pages, and each page as it was last seen.
// The server puts before this text: const VERSION, the digest of the files, and const FILES, their addresses.

const SHELL = `shell-${VERSION}`;
const PAGES = "pages";
const START = ["/offline", "/"];
const MAX_PAGES = 60;
const PATIENCE_MS = 8000; // so long a page that is kept here waits for a newer one
const AWAY = [502, 504]; // what a proxy answers while the service behind it is not there

addEventListener("install", (event) => event.waitUntil(install()));
addEventListener("activate", (event) => event.waitUntil(activate()));
addEventListener("fetch", (event) => {
  const { request } = event;
  const url = new URL(request.url);
  if (url.origin !== location.origin) return;
  if (request.mode === "navigate") event.respondWith(request.method === "GET" ? page(request) : sent(request, url));
  else if (request.method === "GET" && url.pathname.startsWith("/static/")) event.respondWith(file(request));
});

async function install() {
  await (await caches.open(SHELL)).addAll(FILES);
  await keepStart();
  await skipWaiting();
}

// Pages name the files of their own version: those of another one are of no use.
async function activate() {
  for (const name of await caches.keys()) if (name !== SHELL && name !== PAGES) await forget(name);
  await clients.claim();
}

async function forget(shell) {
  await caches.delete(shell);
  await caches.delete(PAGES);
  await keepStart();
}

async function keepStart() {
  const pages = await caches.open(PAGES);
  for (const path of START) {
    const answer = await fetch(path, { headers: { accept: "text/html" } });
    // Where a login is asked for, the first page is kept once somebody has seen it.
    if (answer.ok && !answer.redirected) await pages.put(path, answer);
  }
}

async function file(request) {
  return (await caches.match(request, { ignoreVary: true })) ?? fetch(request);
}

async function page(request) {
  const fresh = fetch(request).then((answer) => keep(request, answer));
  const old = await kept(request.url);
  if (!old) return fresh.catch(() => offline());
  const late = new Promise((resolve) => setTimeout(resolve, PATIENCE_MS, old));
  const answer = await Promise.race([fresh, late]).catch(() => old);
  return AWAY.includes(answer.status) ? old : answer;
}

async function keep(request, answer) {
  if (AWAY.includes(answer.status)) return (await kept(request.url)) ?? offline();
  const html = (answer.headers.get("content-type") ?? "").startsWith("text/html");
  if (answer.status !== 200 || !html) return answer;
  const pages = await caches.open(PAGES);
  await pages.put(request.url, answer.clone());
  const known = (await pages.keys()).filter((one) => !START.includes(new URL(one.url).pathname));
  for (const one of known.slice(0, Math.max(known.length - MAX_PAGES, 0))) await pages.delete(one);
  return answer;
}

// A page as it was last seen; it says so, and tries again by itself (link.js).
async function kept(url) {
  const found = await (await caches.open(PAGES)).match(url, { ignoreVary: true });
  if (!found) return undefined;
  const seen = Date.parse(found.headers.get("date") ?? "") || "";
  const html = (await found.text()).replace("<body", `<body data-kept-at="${seen}"`);
  return new Response(html, { headers: { "content-type": "text/html; charset=utf-8", "content-security-policy": found.headers.get("content-security-policy") ?? "default-src 'self'" } });
}

async function offline() {
  return (await kept(new URL("/offline", location.origin).href)) ?? Response.error();
}

// A form that no script has taken over. Another reader, language or light: what is kept is of no use then.
async function sent(request, url) {
  let answer;
  try { answer = await fetch(request); } catch { return offline(); }
  if (["/logout", "/login", "/preferences"].includes(url.pathname)) {
    await caches.delete(PAGES);
    await keepStart().catch(() => undefined);
  }
  return answer;
}
