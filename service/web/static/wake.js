// Keeps the screen on where hands are full: while a run is taken, while a stop is under way.
let lock = null;

export async function stayAwake() {
  const wanted = document.querySelector("[data-live], .lock, .moves");
  if (!wanted || !navigator.wakeLock || document.hidden || lock) return;
  try {
    lock = await navigator.wakeLock.request("screen");
    lock.addEventListener("release", () => { lock = null; });
  } catch { /* a low battery: the page works all the same */ }
}

addEventListener("visibilitychange", stayAwake);
