// The force of the mass that is typed, at once: F = m r w^2, its factor stated by the page in N per typed unit.
export function followForce() {
  const line = document.querySelector("[data-pull]");
  const field = line?.closest("form")?.elements["masses.mass_g"];
  if (!line || !field) return;
  const show = new Intl.NumberFormat(document.documentElement.lang, { maximumSignificantDigits: 3 });
  const [mass, force] = [line.querySelector("[data-mass]"), line.querySelector("[data-force]")];
  const update = () => {
    const typed = field.value.trim();
    const number = Number(typed.replace(",", "."));
    const plain = /^\d+([.,]\d+)?$/.test(typed) && number > 0;
    mass.textContent = plain ? `${typed} ${line.dataset.unit}` : typed || "—";
    force.textContent = plain ? `${show.format(number * Number(line.dataset.pull))} N` : "—";
  };
  field.addEventListener("input", update);
  field.form.addEventListener("restored", update);
  update();
}
