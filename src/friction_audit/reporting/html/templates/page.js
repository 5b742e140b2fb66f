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

  // Paper shows what is folded on the screen.
  const folded = () => [...document.querySelectorAll("details:not([open])")];
  let unfolded = [];
  window.addEventListener("beforeprint", () => { unfolded = folded(); for (const one of unfolded) one.open = true; });
  window.addEventListener("afterprint", () => { for (const one of unfolded) one.open = false; });
})();
