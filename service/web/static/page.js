// On every page: times as the tablet's own, and a word when the server cannot be reached.
for (const time of document.querySelectorAll("time[datetime]")) {
  const moment = new Date(time.dateTime);
  const form = { dateStyle: "medium", timeStyle: "short" };
  if (!Number.isNaN(moment.valueOf())) time.textContent = moment.toLocaleString(document.documentElement.lang, form);
}

// What the server was too busy for is sent again by itself, under the key of its form: it is done once.
const again = document.querySelector("form[data-again-s]");
if (again) setTimeout(() => again.requestSubmit(), 1000 * Number(again.dataset.againS));

const state = document.querySelector(".link-state");
function showLink() {
  state.hidden = navigator.onLine;
  if (!navigator.onLine) state.textContent = state.dataset.offline;
}
addEventListener("online", showLink);
addEventListener("offline", showLink);
showLink();
