/* Marks the section in view in the navigation, opens folded sections for print, and starts the 3-D viewer. */
(function () {
  "use strict";

  const links = Array.from(document.querySelectorAll('nav a[href*="#"]')).filter((link) => link.pathname === location.pathname);
  const targets = links.map((link) => document.getElementById(decodeURIComponent(link.hash.slice(1))));

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

  /* Opens a folded section that a link leads to. A browser opens only the sections round the link's target. */
  function openTarget() {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (target instanceof HTMLDetailsElement) target.open = true;
  }
  window.addEventListener("hashchange", openTarget);
  openTarget();

  const viewer = document.querySelector(".viewer");
  const stage = viewer && window.vciStage();  // null without WebGL: then the page keeps its still picture
  if (stage) stage.show(viewer);
})();
