"use strict";
// Below each table stand buttons that copy its rows as text.
{
  const clean = (cell) => cell.textContent.trim();

  function rows(table) {
    const notes = table.querySelector(".name") !== null;
    const head = [...table.querySelectorAll("thead th")].map(clean);
    const all = [notes ? [...head, "note"] : head];
    let note = "";
    for (const row of table.tBodies[0].rows) {
      const cells = [...row.cells].map(clean);
      if (row.classList.contains("name")) [note] = cells;
      else {
        all.push(notes ? [...cells, note] : cells);
        note = "";
      }
    }
    return all;
  }

  const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻";
  const lowered = (digits) => [...digits].map((c) => "0123456789-"[RAISED.indexOf(c)]).join("");

  const quoted = (text) => /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  // A program reads 1.2e-3 where a person reads 1.2·10⁻³.
  const csv = (text) => quoted(text.replaceAll("−", "-").replace(
    /·10([⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+)/g, (_, power) => `e${lowered(power)}`));

  const COMMANDS = {
    "\\": "\\textbackslash{}", "~": "\\textasciitilde{}", "^": "\\textasciicircum{}",
    "<": "$<$", ">": "$>$", "|": "$|$", "−": "$-$", "±": "$\\pm$", "·": "$\\cdot$", "–": "--",
  };
  const latex = (text) => text
    .replace(/[\\~^<>|−±·–]|[&%$#_{}]/g, (c) => COMMANDS[c] ?? `\\${c}`)
    .replace(/[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+/g, (power) => `$^{${lowered(power)}}$`);

  const FORMS = {
    CSV: (all) => all.map((row) => row.map(csv).join(",")).join("\n"),
    LaTeX: ([head, ...others]) => [
      `\\begin{tabular}{l${"r".repeat(head.length - 1)}}`,
      `${head.map(latex).join(" & ")} \\\\ \\hline`,
      ...others.map((row) => `${row.map(latex).join(" & ")} \\\\`),
      "\\end{tabular}",
    ].join("\n"),
  };

  // Unlike navigator.clipboard, this is allowed on pages that come over plain HTTP.
  function copy(text) {
    document.addEventListener("copy", (event) => {
      event.clipboardData.setData("text/plain", text);
      event.preventDefault();
    }, { once: true });
    return document.execCommand("copy");
  }

  for (const table of document.querySelectorAll("table")) {
    const line = document.createElement("p");
    line.className = "copy";
    for (const [name, form] of Object.entries(FORMS)) {
      const button = document.createElement("button"), words = `Copy ${name}`;
      button.textContent = words;
      button.addEventListener("click", () => {
        button.textContent = copy(`${form(rows(table))}\n`) ? "Copied" : "Not copied";
        setTimeout(() => { button.textContent = words; }, 1500);
      });
      line.append(button);
    }
    table.after(line);
  }
}
