/* One throw: its sliders, views and numbers, and its finite-element results. */

import { ask, askJson, askText, drawPlot, follow, loadDrawing, ProblemError, save } from "./api.js";
import { Sliders } from "./sliders.js";
import { briefly, fill, fillFormulas, fillSlopes, rowsOf } from "./numbers.js";

function materialText({ youngs_modulus, poisson_ratio, density }) {
  return `E ${Number((youngs_modulus / 1e9).toPrecision(4))} GPa, ν ${poisson_ratio}, ${density} kg/m³`;
}

export class Panel {
  constructor(name, title, fields, values, settings, told) {
    const made = document.getElementById("panel").content.cloneNode(true);
    this.name = name;
    this.settings = settings;
    this.told = told;
    this.root = made.querySelector("section");
    this.root.dataset.updated = "0";
    this.find = (selector) => this.root.querySelector(selector);
    this.find("h2").textContent = title;
    this.find("h2").id = `title-${name}`;
    this.root.setAttribute("aria-labelledby", `title-${name}`);
    const { material, ...dimensions } = values;
    this.material = material ?? settings.steel;
    const places = { main: this.find("fieldset.main"), more: this.find("fieldset.more"), weight: this.find("fieldset.weight") };
    this.sliders = new Sliders(name, fields, places, dimensions, settings.unit, () => this.change(), (field) => this.light(field));
    this.find(".views").addEventListener("click", (event) => {
      const letter = event.target.closest("[data-field]");
      if (letter) {
        this.sliders.rows[letter.dataset.field].box.focus();
      }
    });
    this.find(".weights").addEventListener("change", (event) => this.sliders.weigh(event.target.checked));
    this.estimate = null;
    this.elements = null;
    this.job = null;
    this.find(".calculate").addEventListener("click", () => this.calculate());
    this.find(".cancel").addEventListener("click", () => this.cancel());
    this.find(".toml").addEventListener("click", () => this.saveToml());
    this.find(".json").addEventListener("click", () => this.saveJson());
    this.find(".step").addEventListener("click", () => this.saveFile("throw.step"));
    this.find(".slopes").addEventListener("toggle", () => this.showSlopes());
    this.find(".report").addEventListener("click", () => window.open(`/api/jobs/${this.job}/report`));
    setTimeout(loadDrawing, 500);
  }

  /* Take over a throw and its material. */
  set({ material, ...dimensions }) {
    this.material = material ?? this.settings.steel;
    this.sliders.set(dimensions);
  }

  question() {
    return { throw: this.sliders.throw(), material: this.material };
  }

  /* The throw, and its material unless that is steel. */
  values() {
    return this.ofSteel() ? this.sliders.throw() : { ...this.sliders.throw(), material: this.material };
  }

  ofSteel() {
    return Object.entries(this.settings.steel).every(([name, value]) => this.material[name] === value);
  }

  /* Light the letter of a dimension on the drawing; by default that of the field in which one types. */
  light(field) {
    this.lit = field;
    const shown = field || this.root.querySelector(".dimension:focus-within")?.dataset.dimension;
    for (const letter of this.root.querySelectorAll("[data-field]")) {
      letter.classList.toggle("lit", letter.dataset.field === shown);
    }
  }

  /* A dimension has changed: finite-element results are of another throw. */
  change() {
    this.elements = null;
    this.job = null;
    this.find(".step").disabled = this.find(".report").disabled = true;
    this.find(".solid").hidden = true;
    this.find(".progress").textContent = "";
    this.told();
    this.update();
  }

  /* One update at a time; after it, one more with the newest values if they changed meanwhile. */
  async update() {
    if (this.asking) {
      this.again = true;
      return;
    }
    this.asking = true;
    do {
      this.again = false;
      await this.refresh();
    } while (this.again);
    this.asking = false;
  }

  async refresh() {
    const question = this.question();
    const views = ["side", "front"].map((view) => askText("/api/throws/outline", { throw: question.throw, view, letters: true }));
    const formulas = askJson("/api/throws/formulas", question);
    const estimate = this.settings.estimate(question).catch((error) => ({ refused: error.message }));
    try {
      const [side, front] = await Promise.all(views);
      this.show(side, front, await formulas, await estimate);
      this.find(".wrong").textContent = this.sliders.complain([]).join(" ");
      this.root.classList.remove("stale");
    } catch (error) {
      await Promise.allSettled([...views, formulas]);
      this.refuse(error);
    }
    await this.showSlopes();
    this.root.dataset.updated = String(Number(this.root.dataset.updated) + 1);
  }

  refuse(error) {
    const found = error instanceof ProblemError && error.errors.length ? error.errors : [{ field: "", message: error.message }];
    this.find(".wrong").textContent = this.sliders.complain(found).join(" ");
    this.root.classList.add("stale");
  }

  show(side, front, formulas, estimate) {
    this.find(".side").innerHTML = side;
    this.find(".front").innerHTML = front;
    this.light(this.lit);
    this.find(".weights").checked = Boolean(this.sliders.throw().counterweight);
    this.sliders.limit(estimate.ranges ?? {}, this.settings.source === "law" ? "The law" : "The model");
    this.estimate = estimate;
    this.formulas = formulas;
    this.find(".by").textContent = this.settings.sourceName();
    this.find(".remarks").textContent = [estimate.refused, ...(estimate.remarks || [])].filter(Boolean).join(" ");
    this.showNumbers();
  }

  /* What changes e_n, if it is wanted: of the law, whose differences take no time. */
  async showSlopes() {
    const place = this.find(".slopes");
    if (!place.open) {
      return;
    }
    const found = await askJson("/api/throws/law", { ...this.question(), slopes: true }).catch((error) => ({ refused: error.message }));
    fillSlopes(place.querySelector("tbody"), found.slopes ?? {}, this.sliders.rows);
    place.querySelector("table").hidden = Boolean(found.refused);
    place.querySelector(".remarks").textContent = found.refused ?? "";
  }

  showNumbers() {
    const estimate = this.estimate?.refused ? null : this.estimate;
    fill(this.find(".numbers tbody"), rowsOf(estimate, this.elements?.throw), this.settings.sourceName());
    const known = this.elements?.throw.supports.pinned;
    const values = estimate?.values || {};
    this.find(".brief").replaceChildren(...briefly(estimate));
    const told = known ? "± is the estimated error of the finite elements." : "Calculate gives the values by finite elements.";
    this.find(".numbers caption").textContent = `${this.ofSteel() ? "Steel" : materialText(this.material)}. ${told}`;
    this.find(".ratio").textContent = known ? "Ratio to FE" : `Ratio to ${this.settings.source}`;
    fillFormulas(this.find(".formulas tbody"), this.formulas, {
      axial: known?.axial_compliance ?? values.axial_compliance_pinned?.value,
      torsional: known?.torsional_compliance ?? values.torsional_compliance_pinned?.value,
    });
  }

  async calculate() {
    const question = { ...this.question(), stress: this.find(".stress").checked };
    try {
      const job = await askJson("/api/throws/analysis", question);
      this.job = job.id;
      this.find(".calculate").disabled = true;
      this.find(".cancel").hidden = false;
      const seen = { numbers: false, view: "" };
      await follow(job.id, (told) => this.tell(told, seen));
    } catch (error) {
      this.refuse(error);
    }
    this.find(".calculate").disabled = false;
    this.find(".cancel").hidden = true;
  }

  async tell(job, seen) {
    document.dispatchEvent(new Event("jobs-changed"));
    if (job.id !== this.job) {
      return; // a dimension has changed meanwhile
    }
    const words = { queued: "Waiting for another job.", done: "", canceled: "Canceled.", failed: job.problem?.detail };
    this.find(".progress").textContent = words[job.state] ?? `${job.step || "Starting"} …`;
    if (job.files.includes("result.json") && (!seen.numbers || job.state === "done")) {
      seen.numbers = true;
      this.elements = await askJson(`/api/jobs/${job.id}/result`);
      this.showNumbers();
      if (this.elements.fillet_note) {
        this.find(".progress").textContent = this.elements.fillet_note;
      }
    }
    // The view is written again when the stresses are there.
    const view = job.files.includes("throw_view.json") ? `${job.step === "Writing the solid" || job.state === "done"}` : "";
    if (view && view !== seen.view && !(seen.view && !this.elements?.fillets)) {
      seen.view = view;
      await this.turn(job.id);
    }
    if (job.state === "done") {
      this.find(".step").disabled = !job.files.includes("throw.step");
      this.find(".report").disabled = !job.files.includes("throw_drawing.svg");
    }
  }

  /* Draw the throw in three dimensions, as in reports. */
  async turn(id) {
    const figure = await askText(`/api/jobs/${id}/files/throw_view.json`);
    if (id !== this.job) {
      return;
    }
    await drawPlot(this.find(".solid"), `view-${this.name}`, figure, "the throw in three dimensions");
  }

  async cancel() {
    if (this.job) {
      await ask(`/api/jobs/${this.job}/cancel`, {}).catch(() => null);
    }
  }

  async saveToml() {
    try {
      const found = await askJson("/api/throws/validate", this.question());
      save("throw.toml", found.toml, "text/plain");
    } catch (error) {
      this.refuse(error);
    }
  }

  saveJson() {
    const { estimate, formulas, elements } = this;
    const content = { ...this.question(), estimate, formulas, finite_elements: elements };
    save("throw.json", JSON.stringify(content, null, 1), "application/json");
  }

  async saveFile(name) {
    save(name, await askText(`/api/jobs/${this.job}/files/${name}`), "application/octet-stream");
  }
}
