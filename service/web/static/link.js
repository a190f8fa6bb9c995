// Says when the server cannot be reached, and when a page is only the one that was last seen; goes on by itself.

const AGAIN_MS = 3000;
const state = document.querySelector(".link-state");
const { keptAt, noLink } = document.body.dataset;

export function watchLink() {
  addEventListener("online", showLink);
  addEventListener("offline", showLink);
  showLink();
  if (keptAt !== undefined) tryAgain();
  navigator.serviceWorker?.register("/worker.js").catch(() => undefined); // asked for at each page: kept pages need it
}

function showLink() {
  const old = keptAt !== undefined && noLink === undefined;
  state.hidden = navigator.onLine && !old;
  const at = keptAt ? new Date(Number(keptAt)).toLocaleTimeString(document.documentElement.lang, { timeStyle: "short" }) : "";
  state.textContent = old ? state.dataset.old.replace("{}", at) : state.dataset.offline;
}

// The page as it is now, once there is a server; unless somebody types.
async function tryAgain() {
  const typing = document.activeElement?.matches("main input, main select") || document.body.dataset.sending === "yes";
  try {
    if (!typing && (await fetch("/health", { cache: "no-store", signal: AbortSignal.timeout(AGAIN_MS) })).ok) { location.reload(); return; }
  } catch { /* not yet */ }
  setTimeout(tryAgain, AGAIN_MS);
}
