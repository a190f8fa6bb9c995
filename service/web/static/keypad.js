// A keypad for gloves: it types into the field that was touched last, else into the first empty one. What an answer puts
// into the page anew is served too: nothing is bound to the elements themselves.
const fields = () => [...document.querySelectorAll(".weigh input.figure")];
let name = "";

function field() {
  const found = fields();
  return found.find((one) => one.name === name) ?? found.find((one) => !one.value) ?? found[0];
}

function mark() {
  const here = field();
  for (const one of fields()) one.closest(".field").classList.toggle("typed-into", one === here);
}

document.addEventListener("focusin", ({ target }) => {
  if (!target.matches(".weigh input.figure")) return;
  name = target.name;
  mark();
});
document.addEventListener("click", ({ target }) => {
  const key = target.closest?.(".keypad [data-key]")?.dataset.key;
  const into = key && field();
  if (!into) return;
  name = into.name;
  into.value = key === "back" ? into.value.slice(0, -1) : into.value + key;
  into.dispatchEvent(new Event("input", { bubbles: true }));
  mark();
});
mark();
