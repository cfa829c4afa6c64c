// Every region of the page has a name of its own, for those who hear it.
let blocks = 0;
new MutationObserver(() => {
  for (const nav of document.querySelectorAll("nav.md-code__nav:not([aria-label])"))
    nav.setAttribute("aria-label", `Code block ${++blocks}`);
  // A wide table can be scrolled by the keyboard.
  for (const table of document.querySelectorAll(".md-typeset__scrollwrap:not([tabindex])"))
    table.tabIndex = 0;
}).observe(document.body, { childList: true, subtree: true });
