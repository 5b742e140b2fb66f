"use strict";
(() => {
  const said = document.getElementById("said");

  // Tables: a button in the head of each column sorts by it, numbers as numbers; what has no value comes last.
  const keyOf = (row, column) => {
    const cell = row.cells[column];
    const key = cell.dataset.key;
    return key === undefined ? cell.textContent.trim().toLowerCase() : Number(key);
  };
  const compare = (a, b) => {
    const gone = [a, b].map((key) => key === "" || key === "-" || Number.isNaN(key));
    if (gone[0] || gone[1]) return { last: gone[0] - gone[1] };
    const both = typeof a === "number" && typeof b === "number";
    return { order: both ? a - b : String(a).localeCompare(String(b), "en", { numeric: true }) };
  };
  const sortBy = (table, head, column) => {
    const down = head.getAttribute("aria-sort") === "ascending";
    const rows = [...table.tBodies[0].rows].map((row) => ({ row, key: keyOf(row, column) }));
    rows.sort((a, b) => {
      const found = compare(a.key, b.key);
      return "last" in found ? found.last : down ? -found.order : found.order;
    });
    table.tBodies[0].append(...rows.map((one) => one.row));
    for (const other of head.parentElement.cells) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", down ? "descending" : "ascending");
    said.textContent = `Sorted by ${head.textContent}, ${down ? "descending" : "ascending"}.`;
  };
  for (const table of document.querySelectorAll("table.sortable")) {
    [...table.tHead.rows[0].cells].forEach((head, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = head.textContent;
      button.title = "Sort by this column";
      for (const row of table.tBodies[0].rows) row.cells[column].dataset.head = head.textContent;
      head.replaceChildren(button);
      button.addEventListener("click", () => sortBy(table, head, column));
    });
  }

  // Figures: enlarged in a dialog, where wheel, buttons, keys and drag zoom and move.
  const dialog = document.getElementById("enlarged");
  const stage = dialog.querySelector(".stage");
  let home = null;
  let given = null;
  let whole = null;
  const drawing = () => stage.querySelector("svg");
  const view = () => drawing().getAttribute("viewBox").split(" ").map(Number);
  const show = (box) => drawing().setAttribute("viewBox", box.join(" "));
  const zoom = (factor, x = 0.5, y = 0.5) => {
    const [left, top, width, height] = view();
    const wide = Math.min(Math.max(width * factor, whole[2] / 40), whole[2] * 1.5);
    const high = (wide * height) / width;
    show([left + (width - wide) * x, top + (height - high) * y, wide, high]);
  };
  const move = (x, y) => {
    const [left, top, width, height] = view();
    show([left + x * width, top + y * height, width, height]);
  };
  // The whole figure in a window of the stage's shape, so that zooming in fills the stage.
  const filling = ([left, top, width, height]) => {
    const box = drawing().getBoundingClientRect();
    const scale = Math.max(width / box.width, height / box.height);
    const [wide, high] = [box.width * scale, box.height * scale];
    return [left - (wide - width) / 2, top - (high - height) / 2, wide, high];
  };
  const nameOf = (figure) => figure.querySelector("figcaption strong").textContent.replace(/\.$/, "");
  const open = (figure) => {
    home = figure.querySelector(".sheet");
    document.getElementById("enlarged-title").textContent = nameOf(figure);
    stage.append(home.querySelector("svg"));
    given = view();
    dialog.showModal();
    whole = filling(given);
    show(whole);
  };
  dialog.addEventListener("close", () => {
    show(given);
    home.append(drawing());
    home.closest("figure").querySelector("button").focus();
  });
  const actions = {
    in: () => zoom(0.8),
    out: () => zoom(1.25),
    all: () => show(whole),
    close: () => dialog.close(),
  };
  for (const button of dialog.querySelectorAll("[data-zoom]")) {
    button.addEventListener("click", () => actions[button.dataset.zoom]());
  }
  const keys = {
    "+": actions.in, "=": actions.in, "-": actions.out, "0": actions.all,
    ArrowLeft: () => move(-0.1, 0), ArrowRight: () => move(0.1, 0),
    ArrowUp: () => move(0, -0.1), ArrowDown: () => move(0, 0.1),
  };
  stage.addEventListener("keydown", (event) => {
    const action = keys[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    const box = drawing().getBoundingClientRect();
    zoom(event.deltaY < 0 ? 0.87 : 1.15, (event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height);
  }, { passive: false });
  let dragged = null;
  stage.addEventListener("pointerdown", (event) => {
    dragged = [event.clientX, event.clientY];
    stage.setPointerCapture(event.pointerId);
  });
  stage.addEventListener("pointermove", (event) => {
    if (!dragged) return;
    const box = drawing().getBoundingClientRect();
    move((dragged[0] - event.clientX) / box.width, (dragged[1] - event.clientY) / box.height);
    dragged = [event.clientX, event.clientY];
  });
  for (const name of ["pointerup", "pointercancel"]) stage.addEventListener(name, () => { dragged = null; });
  for (const figure of document.querySelectorAll("figure.drawing")) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = "Enlarge";
    button.setAttribute("aria-label", `Enlarge: ${nameOf(figure)}`);
    button.addEventListener("click", () => open(figure));
    figure.append(button);
  }

  // Figures: the value under the pointer, of the nearest curve where one is near. A panel is
  // [left, top, width, height, values along x, values along y, name of x, name of y].
  const tip = document.createElement("div");
  tip.className = "value";
  tip.setAttribute("aria-hidden", "true");
  const at = (values, share) => {
    const place = Math.min(Math.max(share, 0), 1) * (values.length - 1);
    const low = Math.min(Math.floor(place), values.length - 2);
    return values[low] + (values[low + 1] - values[low]) * (place - low);
  };
  const curves = new WeakMap();
  const curvesOf = (svg) => {
    if (!curves.has(svg)) {
      curves.set(svg, [...svg.querySelectorAll("[data-curve]")].map((one) => ({
        name: one.dataset.curve,
        points: [...one.querySelectorAll("path")].flatMap((path) =>
          [...path.getAttribute("d").matchAll(/(-?[\d.]+) (-?[\d.]+)/g)].map((found) => [+found[1], +found[2]])),
      })));
    }
    return curves.get(svg);
  };
  const nearest = (svg, [x, y], [left, top, width, height], reach) => {
    let best = null;
    for (const { name, points } of curvesOf(svg)) {
      for (const [px, py] of points) {
        const far = Math.hypot(px - x, py - y);
        const inside = px >= left && px <= left + width && py >= top && py <= top + height;
        if (inside && far < reach) { reach = far; best = { name, x: px, y: py }; }
      }
    }
    return best;
  };
  document.addEventListener("pointermove", (event) => {
    const svg = event.target.closest ? event.target.closest("svg[data-panels]") : null;
    tip.remove();
    if (!svg) return;
    const inverse = svg.getScreenCTM().inverse();
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(inverse);
    const panel = JSON.parse(svg.dataset.panels).find((one) =>
      x >= one[0] && x <= one[0] + one[2] && y >= one[1] && y <= one[1] + one[3]);
    if (!panel) return;
    const found = nearest(svg, [x, y], panel, 12 * inverse.a) || { name: "", x, y };
    const across = at(panel[4], (found.x - panel[0]) / panel[2]);
    const up = at(panel[5], 1 - (found.y - panel[1]) / panel[3]);
    const lines = [`${panel[6]}: ${across.toPrecision(3)}`, `${panel[7]}: ${up.toPrecision(3)}`];
    tip.textContent = [...(found.name ? [found.name] : []), ...lines].join("\n");
    (dialog.open ? dialog : document.body).append(tip);
    tip.style.left = `${Math.min(event.clientX + 14, window.innerWidth - tip.offsetWidth - 4)}px`;
    tip.style.top = `${Math.min(event.clientY + 14, window.innerHeight - tip.offsetHeight - 4)}px`;
  });

  // A link to something that is folded unfolds it.
  const unfold = () => {
    const target = location.hash ? document.getElementById(location.hash.slice(1)) : null;
    if (!target) return;
    const inside = target.querySelector(":scope > details");
    for (let one = inside || target; one; one = one.parentElement) if (one.tagName === "DETAILS") one.open = true;
    target.scrollIntoView();
  };
  window.addEventListener("hashchange", unfold);
  unfold();

  // Paper shows what is folded on the screen.
  const folded = () => [...document.querySelectorAll("details:not([open])")];
  let unfolded = [];
  window.addEventListener("beforeprint", () => { unfolded = folded(); for (const one of unfolded) one.open = true; });
  window.addEventListener("afterprint", () => { for (const one of unfolded) one.open = false; });
})();
