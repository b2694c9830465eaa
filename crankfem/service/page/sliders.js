/* The dimensions of one throw: a slider and a field each, with units; errors are shown at their fields. */

export const METERS = { mm: 0.001, cm: 0.01, m: 1, in: 0.0254 };
const SPAN = 2.5; // a slider reaches from a part of its first value to a multiple of it
const STEPS = 400;
const QUANTITY = /^\s*([-+]?[\d.]+(?:e[-+]?\d+)?)\s*([a-z]*)\s*$/i;

export function shown(value, unit) {
  return String(Number((value / METERS[unit]).toPrecision(6)));
}

/* Lengths are in meters here; null is not given. */
export class Sliders {
  constructor(name, fields, place, more, values, unit, changed) {
    this.name = name;
    this.values = { ...values };
    this.unit = unit;
    this.changed = changed;
    this.rows = {};
    for (const field of fields) {
      this.add(field, field.required || field.name === "fillet_radius" ? place : more);
    }
  }

  add(field, place) {
    const id = `${this.name}-${field.name}`;
    const row = document.createElement("div");
    row.className = "dimension";
    const label = document.createElement("label");
    label.htmlFor = id;
    label.textContent = field.meaning;
    if (field.symbol) {
      const [symbol, index] = field.symbol.split("_");
      const small = Object.assign(document.createElement("sub"), { textContent: index ?? "" });
      const letter = Object.assign(document.createElement("b"), { textContent: ` ${symbol}` });
      letter.append(small);
      label.append(letter);
    }
    const wrong = document.createElement("p");
    wrong.id = `${id}-wrong`;
    let box;
    let slider = null;
    if (field.choices) {
      box = document.createElement("select");
      for (const choice of field.choices) {
        box.append(new Option(choice, choice));
      }
      box.addEventListener("change", () => this.take(field.name, box.value));
    } else {
      box = document.createElement("input");
      box.type = "text";
      box.inputMode = "decimal";
      box.autocomplete = "off";
      box.addEventListener("input", () => this.type(field.name, box.value));
      box.addEventListener("change", () => this.center(field.name));
      slider = document.createElement("input");
      slider.type = "range";
      slider.setAttribute("aria-label", `${field.meaning}, slider`);
      slider.addEventListener("input", () => this.slide(field.name, Number(slider.value)));
    }
    box.id = id;
    box.setAttribute("aria-describedby", wrong.id);
    row.append(label, box, ...(slider ? [slider] : []), wrong);
    place.append(row);
    this.rows[field.name] = { field, box, slider, wrong, text: null };
    this.show(field.name);
    this.center(field.name);
  }

  /* Set the slider's range around the present value. */
  center(name) {
    const { slider, field } = this.rows[name];
    if (!slider) {
      return;
    }
    const about = this.values[name] || field.usual || 0;
    const low = this.values[name] && field.minimum > 0 ? about / SPAN : Math.max(0, field.minimum);
    const high = Math.max(about * SPAN, field.usual ?? 0);
    slider.min = Math.max(field.minimum, low);
    slider.max = Math.min(field.maximum, high);
    slider.step = (slider.max - slider.min) / STEPS;
    slider.value = this.values[name] ?? 0;
    this.describe(name);
  }

  describe(name) {
    const { slider, box } = this.rows[name];
    slider?.setAttribute("aria-valuetext", box.value ? `${box.value} ${this.unit}` : "not given");
  }

  slide(name, value) {
    const rounded = METERS[this.unit] * Number((value / METERS[this.unit]).toPrecision(4));
    this.rows[name].text = null;
    this.values[name] = rounded;
    this.show(name);
    this.changed();
  }

  /* Units that the page does not know are left to the service. */
  type(name, text) {
    const row = this.rows[name];
    const found = QUANTITY.exec(text);
    const unit = found && (found[2] || this.unit);
    if (!text.trim()) {
      row.text = null;
      this.values[name] = null;
    } else if (found && METERS[unit]) {
      row.text = null;
      this.values[name] = Number(found[1]) * METERS[unit];
      row.slider.value = this.values[name];
    } else {
      row.text = text;
    }
    this.describe(name);
    this.changed();
  }

  take(name, value) {
    this.values[name] = value;
    this.changed();
  }

  show(name) {
    const { box, slider } = this.rows[name];
    const value = this.values[name];
    if (slider) {
      box.value = typeof value === "number" ? shown(value, this.unit) : "";
      this.describe(name);
    } else if (value) {
      box.value = value;
    }
  }

  setUnit(unit) {
    this.unit = unit;
    for (const name of Object.keys(this.rows)) {
      this.show(name);
    }
  }

  /* The throw for a request. */
  throw() {
    const found = {};
    for (const [name, { text }] of Object.entries(this.rows)) {
      const value = text ?? this.values[name];
      if (value !== null && value !== undefined && value !== "") {
        found[name] = typeof value === "number" ? Number(value.toPrecision(12)) : value;
      }
    }
    return found;
  }

  /* Show errors at their fields; return the sentences that belong to none of them. */
  complain(errors) {
    const others = [];
    const told = {};
    for (const { field, message } of errors) {
      const name = field.replace(/^throw\./, "");
      if (this.rows[name]) {
        told[name] = message.replace(/^[\w.]+: /, "");
      } else {
        others.push(message);
      }
    }
    for (const [name, { box, wrong }] of Object.entries(this.rows)) {
      wrong.textContent = told[name] || "";
      box.toggleAttribute("aria-invalid", false);
      if (told[name]) {
        box.setAttribute("aria-invalid", "true");
        box.closest("details")?.setAttribute("open", "");
      }
    }
    return others;
  }
}
