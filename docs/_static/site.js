// Wide tables and long lines of code: stops of the keyboard while they scroll.
(() => {
  "use strict";

  const resized = new ResizeObserver((entries) => {
    for (const { target } of entries) {
      if (target.scrollWidth > target.clientWidth) {
        target.tabIndex = 0;
      } else {
        target.removeAttribute("tabindex");
      }
    }
  });
  const scrolling = "article pre, article table.docutils, article .table-wrapper";
  document.querySelectorAll(scrolling).forEach((element) => resized.observe(element));
})();
