// What is typed and ticked is kept in the browser until the server has it: through a reload, a lost link, a closed page.
// It is put back into the same form only where the page shows the same as then.

const DRAFT = "drumtrue-draft:";
const MAX_DRAFTS = 30;

export function keepDrafts() {
  for (const form of document.querySelectorAll("main form[method=post]:not([data-plain])")) {
    if (fields(form).length && !form.dataset.draft) keep(form);
  }
}

// The server has it, or nobody wants it any more.
export function dropDraft(action, moment) {
  write(DRAFT + action + " " + moment, null);
}

export const momentOf = (form) => form.elements.namedItem("moment")?.value ?? "";

function keep(form) {
  const key = DRAFT + form.getAttribute("action") + " " + momentOf(form);
  const base = JSON.stringify(fields(form).map((field) => [field.name, initial(field)]));
  const kept = read(key);
  form.dataset.draft = "kept";
  if (kept?.base === base && !form.querySelector("[aria-invalid]")) restore(form, kept, key);
  form.addEventListener("input", () => {
    const values = fields(form).filter((field) => !/radio/.test(field.type) || field.checked).map((field) => [field.name, current(field)]);
    write(key, { base, values, at: Date.now() });
  });
}

function restore(form, kept, key) {
  for (const [name, value] of kept.values) {
    for (const field of fields(form).filter((one) => one.name === name)) {
      if (field.type === "checkbox") field.checked = value === "yes";
      else if (field.type === "radio") field.checked = field.value === value;
      else field.value = value;
    }
  }
  form.closest("details")?.setAttribute("open", "");
  for (const field of fields(form)) if (current(field) !== initial(field)) field.closest("details")?.setAttribute("open", "");
  form.dispatchEvent(new Event("restored", { bubbles: true }));
  if (form.elements.namedItem("moment")) return;
  const told = document.querySelector("#put-back")?.content.firstElementChild.cloneNode(true);
  if (!told) return;
  told.querySelector("button").addEventListener("click", () => { write(key, null); location.reload(); });
  form.prepend(told);
}

const fields = (form) => [...form.elements].filter((one) => one.name && !["hidden", "password", "submit", "button", "fieldset", "file"].includes(one.type));
const current = (field) => (field.type === "checkbox" ? (field.checked ? "yes" : "") : field.value);
const initial = (field) => {
  if (field.type === "checkbox") return field.defaultChecked ? "yes" : "";
  if (field.type === "radio") return field.defaultChecked ? field.value : "";
  if (field.tagName === "SELECT") return [...field.options].find((one) => one.defaultSelected)?.value ?? field.options[0]?.value ?? "";
  return field.defaultValue;
};

function read(key) {
  try { return JSON.parse(localStorage.getItem(key)); } catch { return null; }
}

// A full or forbidden store: the form is still sent, it only does not outlive the page.
function write(key, value) {
  try {
    if (value === null) localStorage.removeItem(key);
    else localStorage.setItem(key, JSON.stringify(value));
    const old = Object.keys(localStorage).filter((name) => name.startsWith(DRAFT));
    if (old.length <= MAX_DRAFTS) return;
    old.sort((a, b) => (read(a)?.at ?? 0) - (read(b)?.at ?? 0));
    for (const name of old.slice(0, old.length - MAX_DRAFTS)) localStorage.removeItem(name);
  } catch { /* as above */ }
}
