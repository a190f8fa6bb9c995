// On every page: forms that outlive a lost link, what was typed, the state of the link, times as the tablet's own.
import { tapDrum } from "./drum.js";
import { keepDrafts } from "./drafts.js";
import { watchLink } from "./link.js";
import { takeForms } from "./outbox.js";
import { followForce } from "./pull.js";
import { stayAwake } from "./wake.js";

function prepare() {
  for (const time of document.querySelectorAll("time[datetime]")) {
    const moment = new Date(time.dateTime);
    const form = { dateStyle: "medium", timeStyle: "short" };
    if (!Number.isNaN(moment.valueOf())) time.textContent = moment.toLocaleString(document.documentElement.lang, form);
  }
  followForce();
  tapDrum();
  stayAwake();
}

keepDrafts();
prepare();
watchLink();
takeForms(prepare);

// What the server was too busy for is sent again by itself, under the key of its form: it is done once.
const again = document.querySelector("form[data-again-s]");
if (again) setTimeout(() => again.requestSubmit(), 1000 * Number(again.dataset.againS));
