// SPDX-License-Identifier: Apache-2.0
// The page's script in a build without the parts from npm: says in place of each chart, and of the page of
// what is watched, why it is not there.
document.getElementById("live")?.append(
    "Not shown: this kalfem was built without the page's parts (KALFEM_PAGE_PARTS=OFF). The same is told at /metrics.");
for (const figure of document.querySelectorAll("[data-chart], [data-scene]")) {
  const note = document.createElement("p");
  note.className = "note";
  note.textContent = "Not drawn: this kalfem was built without the page's parts (KALFEM_PAGE_PARTS=OFF). The numbers are in results.h5.";
  (figure.querySelector(".plot, .structure") ?? figure).append(note);
}
