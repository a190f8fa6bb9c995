// A keypad for gloves: it types into the field that was touched last, else into the first one.
const pad = document.querySelector(".keypad");
const fields = [...document.querySelectorAll(".weigh input.figure")];
if (pad && fields.length) {
  let field = fields.find((one) => !one.value) ?? fields[0];
  const mark = (one) => {
    field = one;
    for (const other of fields) other.closest(".field").classList.toggle("typed-into", other === one);
  };
  pad.hidden = false;
  for (const one of fields) one.addEventListener("focus", () => mark(one));
  mark(field);
  for (const key of pad.querySelectorAll("[data-key]")) {
    key.addEventListener("click", () => {
      field.value = key.dataset.key === "back" ? field.value.slice(0, -1) : field.value + key.dataset.key;
      field.dispatchEvent(new Event("input", { bubbles: true }));
    });
  }
}
