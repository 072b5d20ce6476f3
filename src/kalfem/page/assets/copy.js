// SPDX-License-Identifier: Apache-2.0
// Buttons that take numbers and pieces of a case to the clipboard.

export function offerCopies() {
  for (const node of document.querySelectorAll("[data-copy]")) {
    node.hidden = false;
    const words = node.textContent;
    node.addEventListener("click", async () => {
      node.textContent = await copied(textOf(node)) ? "Copied" : "Not copied: the browser does not allow it";
      setTimeout(() => { node.textContent = words; }, 2000);
    });
  }
}

const textOf = node => node.dataset.copy || node.parentElement.querySelector("pre").textContent;

async function copied(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return copiedBySelection(text);
  }
}

// For pages without a secure origin.
function copiedBySelection(text) {
  const area = document.createElement("textarea");
  area.value = text;
  document.body.append(area);
  area.select();
  const done = document.execCommand("copy");
  area.remove();
  return done;
}
