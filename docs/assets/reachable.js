// What the theme makes in the browser: wide tables that keys scroll too, and buttons to copy that are no navigation.
function reach() {
  document.querySelectorAll(".md-typeset__scrollwrap:not([tabindex])").forEach((one) => { one.tabIndex = 0; });
  document.querySelectorAll(".md-code__nav:not([role])").forEach((one) => { one.setAttribute("role", "presentation"); });
}
new MutationObserver(reach).observe(document.body, { childList: true, subtree: true });
reach();
