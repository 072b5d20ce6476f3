// SPDX-License-Identifier: Apache-2.0
// The contents mark the section that is being read; beside the page they stand open, above it they open when asked for.

export function openContentsBeside() {
  const beside = matchMedia("(min-width: 72rem)"), contents = document.querySelector("nav details");
  if (!contents) return;
  const follow = () => { contents.open = beside.matches; };
  beside.addEventListener("change", follow);
  follow();
}

export function markContents() {
  const links = new Map([...document.querySelectorAll("nav a")].map(link => [link.hash.slice(1), link]));
  const onScroll = new IntersectionObserver(entries => {
    const seen = entries.find(entry => entry.isIntersecting);
    if (!seen) return;
    links.forEach(link => link.removeAttribute("aria-current"));
    links.get(seen.target.id)?.setAttribute("aria-current", "true");
  }, {rootMargin: "0px 0px -70% 0px"});
  document.querySelectorAll("main > section").forEach(section => onScroll.observe(section));
}
