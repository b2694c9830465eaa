/* The numbers of a throw: by the law or a model with their bands, and by finite elements with error bars. */

import { named } from "./sliders.js";

const TINY = { "m/N": [1e9, "nm/N"], "rad/(N m)": [1e9, "nrad/(N m)"] };

export function quantity(value, unit, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) {
    return "–";
  }
  const [factor, name] = TINY[unit] || [1, unit];
  return `${Number((value * factor).toPrecision(digits))} ${name}`.trim().replace(/^-/, "\u2212");
}

/* Rows: name, unit, value and band by the law or model, value and error by finite elements. */
export function rowsOf(estimate, elements) {
  const rows = [];
  const wanted = [
    ["axial_compliance", "pinned", "Axial compliance eₙ, ends pinned", "m/N"],
    ["axial_compliance", "guided", "Axial compliance eₙ, ends guided", "m/N"],
    ["torsional_compliance", "pinned", "Torsional compliance, ends pinned", "rad/(N m)"],
    ["influence_coefficient", "pinned", "Influence coefficient c, ends pinned", "m/N"],
  ];
  for (const [name, support, title, unit] of wanted) {
    const found = elements?.supports?.[support];
    rows.push({
      title,
      unit,
      estimate: estimate?.values?.[`${name}_${support}`] || null,
      value: found?.[name],
      error: found?.errors?.[name],
    });
  }
  for (const side of ["left", "right"]) {
    const found = estimate?.reactions?.[side];
    const axial = found && found.force[2] / 1000;
    const off = found?.force_band?.[2] / 1000;
    const known = elements?.supports?.pinned?.reactions?.[side];
    rows.push({
      title: `Axial reaction, ${side} end, to 100 kN on the pin towards the shaft`,
      unit: "kN",
      estimate: found ? { value: axial, lower: axial - off, upper: axial + off } : null,
      value: known && known.force[2] / 1000,
    });
  }
  return rows;
}

/* Cells with labels of their own, shown where the table's head has no room. */
function cell(text, label) {
  const made = Object.assign(document.createElement("td"), { textContent: text });
  made.dataset.label = label;
  return made;
}

export function fill(body, rows, by) {
  body.replaceChildren(
    ...rows.map((row) => {
      const made = document.createElement("tr");
      const unit = (TINY[row.unit] || [1, row.unit])[1];
      const head = Object.assign(document.createElement("th"), { scope: "row", textContent: `${row.title} [${unit}]` });
      made.append(
        head,
        cell(bare(row.estimate?.value, row.unit), by),
        cell(band(row.estimate, row.unit), "Band"),
        cell(withError(row), "Finite elements")
      );
      return made;
    })
  );
}

/* The number without its unit, which the head of its row shows. */
function bare(value, unit, digits) {
  return quantity(value, unit, digits).split(" ")[0];
}

function band(estimate, unit) {
  if (!estimate || !Number.isFinite(estimate.lower) || !Number.isFinite(estimate.upper)) {
    return "–";
  }
  return `${bare(estimate.lower, unit)} to ${bare(estimate.upper, unit)}`;
}

/* The answers that stay in view on a narrow screen. */
export function briefly(estimate) {
  const found = estimate?.values || {};
  return ["axial", "torsional"]
    .map((kind) => [kind, found[`${kind}_compliance_pinned`]])
    .filter(([, one]) => one)
    .map(([kind, one]) => {
      const line = document.createElement("span");
      const value = document.createElement("b");
      value.textContent = quantity(one.value, one.unit);
      line.append(`${kind}, pinned `, value, ` (${band(one, one.unit)})`);
      return line;
    });
}

/* Errors have two digits. */
function withError(row) {
  const value = bare(row.value, row.unit);
  return Number.isFinite(row.error) ? `${value} ± ${bare(row.error, row.unit, 2)}` : value;
}

/* Published formulas, and their ratios to finite elements or to the law. */
export function fillFormulas(body, formulas, reference) {
  const rows = [
    ...formulas.axial.map((one) => [one, reference.axial]),
    ...formulas.torsional.map((one) => [one, reference.torsional]),
  ];
  body.replaceChildren(
    ...rows.map(([one, known]) => {
      const made = document.createElement("tr");
      const texts = [
        one.name,
        quantity(one.value, one.unit),
        known ? (one.value / known).toFixed(2) : "–",
        one.valid ? "yes" : "no",
      ];
      made.append(...texts.map((text) => cell(text, "")));
      made.title = [...one.remarks, one.source].join(" ");
      return made;
    })
  );
}

/* Slopes in the order of their size, each with a bar from the middle: to the left where more of it makes less. */
export function fillSlopes(body, slopes, rows) {
  const sorted = Object.entries(slopes).sort(([, one], [, other]) => Math.abs(other) - Math.abs(one));
  const largest = Math.abs(sorted[0]?.[1] ?? 1);
  body.replaceChildren(
    ...sorted.map(([name, slope]) => {
      const made = document.createElement("tr");
      made.dataset.slope = name;
      const head = Object.assign(document.createElement("th"), { scope: "row" });
      head.append(...named(rows[name].field));
      const bar = Object.assign(document.createElement("div"), { className: slope < 0 ? "less" : "more" });
      bar.style.width = `${(50 * Math.abs(slope)) / largest}%`;
      const drawn = cell("", "");
      drawn.append(bar);
      const sign = slope < 0 ? "\u2212" : "+";
      made.append(head, cell(`${sign}${Math.abs(slope).toFixed(2)}`, ""), drawn);
      return made;
    })
  );
}
