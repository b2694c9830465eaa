/* The dimensions of one throw: a slider and a field each, with units; errors are shown at their fields. */

export const METERS = { mm: 0.001, cm: 0.01, m: 1, in: 0.0254 };
const DEGREES = { deg: Math.PI / 180 };
const SPAN = 2.5; // without a known range a slider reaches from a part of its value to a multiple of it
const STEPS = 400;
const QUANTITY = /^\s*([-+]?[\d.]+(?:e[-+]?\d+)?)\s*([a-z]*)\s*$/i;

const scales = (field) => (field.angle ? DEGREES : METERS);

export const unitOf = (field, unit) => (field.angle ? "deg" : unit);

export function shown(value, field, unit) {
  return String(Number((value / scales(field)[unitOf(field, unit)]).toPrecision(6)));
}

/* What a field means, with its letter. */
export function named({ meaning, symbol }) {
  const [letter, index] = symbol.split("_");
  const small = Object.assign(document.createElement("sub"), { textContent: index ?? "" });
  const shownLetter = Object.assign(document.createElement("b"), { className: "letter", textContent: ` ${letter}` });
  shownLetter.append(small);
  return symbol ? [meaning, shownLetter] : [meaning];
}

/* Lengths are in meters and angles in radians here; null is not given. */
export class Sliders {
  constructor(name, fields, places, values, unit, changed, lit) {
    this.name = name;
    this.unit = unit;
    this.changed = changed;
    this.lit = lit;
    this.rows = {};
    this.split(fields, values);
    for (const field of fields) {
      const main = field.required || field.name === "fillet_radius";
      this.add(field, field.name.includes(".") ? places.weight : main ? places.main : places.more);
    }
  }

  /* Values by the names of the sliders, and the parts of a throw that have none. */
  split(fields, values) {
    const known = new Set(fields.map((field) => field.name));
    this.values = {};
    this.parts = {};
    for (const [name, value] of Object.entries(values)) {
      if (known.has(name) || typeof value !== "object" || value === null) {
        this.values[name] = value;
      } else if (fields.some((field) => field.name.startsWith(`${name}.`))) {
        Object.entries(value).forEach(([part, number]) => (this.values[`${name}.${part}`] = number));
      } else {
        this.parts[name] = value;
      }
    }
  }

  /* Take over a throw. */
  set(values) {
    this.split(Object.values(this.rows).map((row) => row.field), values);
    for (const [name, row] of Object.entries(this.rows)) {
      Object.assign(row, { text: null, range: null });
      this.show(name);
      this.center(name);
      if (this.values[name] && !row.field.required) {
        row.box.closest("details")?.setAttribute("open", "");
      }
    }
    this.changed();
  }

  /* Add counterweights, or take them away. */
  weigh(added) {
    const weights = Object.values(this.rows).filter(({ field }) => field.name.includes("."));
    const usual = weights.map(({ field }) => [field.name, field.start]);
    this.set({ ...this.throw(), counterweight: null, ...(added ? Object.fromEntries(usual) : {}) });
  }

  add(field, place) {
    const id = `${this.name}-${field.name}`;
    const row = document.createElement("div");
    row.className = "dimension";
    row.dataset.dimension = field.name;
    const label = document.createElement("label");
    label.htmlFor = id;
    label.append(...named(field));
    const wrong = Object.assign(document.createElement("p"), { id: `${id}-wrong` });
    const edge = Object.assign(document.createElement("p"), { id: `${id}-edge`, className: "edge" });
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
    box.setAttribute("aria-describedby", `${wrong.id} ${edge.id}`);
    row.append(label, box, ...(slider ? [slider] : []), edge, wrong);
    for (const [event, name] of Object.entries({ pointerenter: field.name, focusin: field.name, pointerleave: "", focusout: "" })) {
      row.addEventListener(event, () => this.lit(name));
    }
    place.append(row);
    this.rows[field.name] = { field, box, slider, wrong, edge, range: null, text: null };
    this.show(field.name);
    this.center(field.name);
  }

  /* Set the slider's range: that of the law or model, else around the present value. */
  center(name) {
    const { slider, field, range } = this.rows[name];
    if (!slider) {
      return;
    }
    const about = Math.abs(this.values[name] || field.usual || 0);
    const low = this.values[name] && field.minimum > 0 ? about / SPAN : Math.max(-about * SPAN, field.minimum);
    const high = Math.max(about * SPAN, field.usual ?? 0);
    slider.min = range?.low ?? Math.max(field.minimum, low);
    slider.max = range?.high ?? Math.min(field.maximum, high);
    slider.step = (slider.max - slider.min) / STEPS;
    slider.value = this.values[name] ?? 0;
    this.describe(name);
  }

  /* Take over the ranges of the law or model; sliders at an end say what ends them there. */
  limit(ranges, by) {
    for (const [name, row] of Object.entries(this.rows)) {
      const range = ranges[name] ?? null;
      const value = this.values[name];
      if (row.slider && JSON.stringify(range) !== JSON.stringify(row.range)) {
        row.range = range;
        this.center(name);
      }
      const near = range && typeof value === "number" ? 0.002 * (range.high - range.low) : NaN;
      row.edge.textContent =
        value <= range?.low + near ? `${by} ends here: ${range.low_limit}.` : value >= range?.high - near ? `${by} ends here: ${range.high_limit}.` : "";
    }
  }

  describe(name) {
    const { slider, box, field } = this.rows[name];
    slider?.setAttribute("aria-valuetext", box.value ? `${box.value} ${unitOf(field, this.unit)}` : "not given");
  }

  slide(name, value) {
    const { field, range } = this.rows[name];
    const scale = scales(field)[unitOf(field, this.unit)];
    const rounded = scale * Number((value / scale).toPrecision(4));
    this.rows[name].text = null;
    this.values[name] = range ? Math.min(Math.max(rounded, range.low), range.high) : rounded;
    this.show(name);
    this.changed();
  }

  /* Units that the page does not know are left to the service. */
  type(name, text) {
    const row = this.rows[name];
    const found = QUANTITY.exec(text);
    const scale = found && scales(row.field)[found[2] || unitOf(row.field, this.unit)];
    if (!text.trim()) {
      row.text = null;
      this.values[name] = null;
    } else if (scale) {
      row.text = null;
      this.values[name] = Number(found[1]) * scale;
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
      box.value = typeof value === "number" ? shown(value, this.rows[name].field, this.unit) : "";
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
    const found = { ...this.parts };
    for (const [name, { text }] of Object.entries(this.rows)) {
      const value = text ?? this.values[name];
      if (value !== null && value !== undefined && value !== "") {
        const [part, field] = name.split(".");
        const place = field ? (found[part] ??= {}) : found;
        place[field ?? part] = typeof value === "number" ? Number(value.toPrecision(12)) : value;
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
