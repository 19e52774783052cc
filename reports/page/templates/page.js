/* Marks the section in view in the navigation, and gives the 3-D stage to the case in view. */
(function () {
  "use strict";

  const links = Array.from(document.querySelectorAll("nav a"));
  const targets = links.map((link) => document.querySelector(link.getAttribute("href")));

  function markCurrent() {
    let current = 0;
    targets.forEach((target, k) => {
      if (target.getBoundingClientRect().top < window.innerHeight * 0.35) current = k;
    });
    links.forEach((link, k) => link.classList.toggle("current", k === current));
  }
  window.addEventListener("scroll", markCurrent, { passive: true });
  markCurrent();

  window.addEventListener("beforeprint", () => {
    document.querySelectorAll("details").forEach((item) => { item.open = true; });
  });

  const stage = window.vciStage();
  if (!stage) return;  // no WebGL: the pictures stay
  const viewers = Array.from(document.querySelectorAll(".viewer"));

  /* Height of the window that a viewer fills. */
  function visibleHeight(viewer) {
    const box = viewer.getBoundingClientRect();
    return Math.min(box.bottom, window.innerHeight) - Math.max(box.top, 0);
  }

  function moveStage() {
    if (!viewers.length) return;
    const best = viewers.reduce((a, b) => (visibleHeight(b) > visibleHeight(a) ? b : a));
    if (visibleHeight(best) > 0) stage.show(best);
  }
  window.addEventListener("scroll", moveStage, { passive: true });
  window.addEventListener("resize", moveStage);
  moveStage();
})();
