"use strict";
(async () => {
  const root = document.documentElement;
  const figures = JSON.parse(document.querySelector("script.figures").textContent);
  const charts = [...document.querySelectorAll(".chart")];

  async function load() {
    const packed = atob(document.querySelector("script.plotly").textContent);
    const bytes = Uint8Array.from(packed, (c) => c.charCodeAt(0));
    const unpacked = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    const script = document.createElement("script");
    script.textContent = await new Response(unpacked).text();
    document.head.append(script);
  }

  // A colour's role becomes the colour that the page has for it just now.
  function coloured(value, style) {
    if (typeof value === "string") {
      return value.startsWith("--") ? style.getPropertyValue(value).trim() || value : value;
    }
    if (Array.isArray(value)) return value.map((each) => coloured(each, style));
    if (value === null || typeof value !== "object") return value;
    return Object.fromEntries(
      Object.entries(value).map(([key, each]) => [key, coloured(each, style)]));
  }

  // Fingers scroll the page, a mouse zooms.
  const touch = matchMedia("(pointer: coarse)").matches;

  function layout(own, style, width) {
    const axis = {
      gridcolor: style.getPropertyValue("--grid"), linecolor: style.getPropertyValue("--rule"),
      zeroline: false, showline: true, fixedrange: touch, tickfont: { size: 11 },
    };
    const axes = Object.keys(own).filter((key) => /^[xy]axis/.test(key));
    return {
      paper_bgcolor: "transparent", plot_bgcolor: "transparent",
      font: { family: "system-ui, sans-serif", size: 12, color: style.getPropertyValue("--ink") },
      // On the left: the button that saves the chart is on the right.
      legend: { orientation: "h", x: 0, xanchor: "left", y: 1, yanchor: "bottom" },
      modebar: {
        bgcolor: "transparent", color: style.getPropertyValue("--faint"),
        activecolor: style.getPropertyValue("--ink"),
      },
      hoverlabel: {
        bgcolor: style.getPropertyValue("--card"), bordercolor: style.getPropertyValue("--rule"),
        font: { color: style.getPropertyValue("--ink") },
      },
      dragmode: touch ? false : "zoom",
      ...own,
      ...Object.fromEntries(axes.map((key) => [key, { ...axis, ...own[key] }])),
      margin: { l: 58, r: 10, ...own.margin },
      ...(width ? { width, autosize: false } : { autosize: true }),
    };
  }

  // One panel of a figure.
  function alone({ data, layout }, k) {
    const axis = `y${k ? k + 1 : ""}`;
    const traces = data.filter((trace) => trace.yaxis === axis);
    return {
      data: traces.map((trace, i) => ({
        // The first panel's curves have the names of all.
        ...trace, yaxis: "y", name: data[i].name, showlegend: data[i].showlegend,
      })),
      layout: {
        ...Object.fromEntries(Object.entries(layout).filter(([key]) => !key.startsWith("yaxis"))),
        height: 320,
        xaxis: { ...layout.xaxis, anchor: "y" },
        yaxis: { ...layout[`yaxis${axis.slice(1)}`], domain: [0, 0.88] },
        annotations: [{ ...layout.annotations[k], y: 0.88 }],
        shapes: layout.shapes.filter((shape) => shape.yref === axis)
          .map((shape) => ({ ...shape, yref: "y" })),
      },
    };
  }

  function draw(chart, width) {
    const style = getComputedStyle(root);
    const whole = figures[chart.dataset.figure], panel = chart.dataset.panel;
    const figure = coloured(panel ? alone(whole, Number(panel)) : whole, style);
    return Plotly.react(chart, {
      data: figure.data, frames: figure.frames,
      layout: layout(figure.layout, style, width),
      // Under a mouse a button saves the chart as PNG.
      config: {
        displayModeBar: touch ? false : "hover", displaylogo: false,
        modeBarButtons: [["toImage"]], responsive: true,
      },
    });
  }

  const all = (width) => charts.forEach((chart) => {
    draw(chart, width && chart.closest(".wide") ? 2 * width : width);
  });
  const soon = () => new Promise((resolve) => setTimeout(resolve));

  await load();
  for (const chart of charts) {
    await draw(chart);
    chart.dataset.drawn = "yes";
    await soon();
  }
  for (const choice of document.querySelectorAll("select")) {
    choice.addEventListener("change", () => {
      let figure = choice.closest("figure");
      do {
        const chart = figure.querySelector(".chart");
        chart.dataset.panel = choice.value;
        draw(chart);
        figure = figure.nextElementSibling;
      } while (figure && !figure.matches(".first"));
    });
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => all());
  addEventListener("beforeprint", () => {
    root.classList.add("paper");
    all(330);
  });
  addEventListener("afterprint", () => {
    root.classList.remove("paper");
    all();
  });
})();
